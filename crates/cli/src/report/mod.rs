//! `trochoid report`: error against run time, as data, as a table, and as a page of plots.
//!
//! `report.json` has `trochoid`, the version; `scene`, `output`, `frame`, `format`, `space`, the working space; `unit`,
//! the unit of errors; `threads`; `seed`; `whole`, whether the bounds of all pixels are known; `within_seconds`, the limit
//! of time, if there was one; `pixels`, with `picture` (drawn in as many equal parts of the picture), `apart` (drawn where
//! settings differ), `looked_at` (all of them, each once), `total`, `differing` (pixels of the picture where settings
//! differ), and `without_reference` (those looked at whose references are given up, so that their errors are not
//! measured); `confidence`, of all intervals; `summary`, sentences; `missing`, what did not fit into the time, with
//! `settings`, a list of assignments, `rungs_without_bounds`, `references`, `rungs_without_certify_seconds`, `passes`;
//! `left_to_whole`, a sentence; `unseen`, a list of `{view, nodes}`; `rungs`, a list of settings, each with the columns of
//! `report.csv`, with `set`, with `passes`, a list of `{node, type, drop}`, and with `broken`, a list of `{pixel, bound,
//! error}`, which is empty unless bounds do not hold; `attempts`, a list of `{tolerance, allowed, scope, met, set,
//! certified, limited_by}`, where `limited_by` is a pass, `{node, type}`, with `why` if it has no error bound, or
//! "rounding" or "what is seen"; `savings`, a list of `{node, type, why, seconds}`; `scalings`, a list of `{knob, points:
//! [{value, seconds}]}`.
//!
//! Columns of a rung: `scene`, `output`, `frame`, `seed`, `settings`, `is_method` (whether `plan` may choose them), `scope`
//! ("whole" or "pixels": whether errors are certified, and tolerances judged, at all pixels or at those looked at). Bounds
//! start with `certified`, errors with `measured`: `_max`, the largest of all pixels looked at, and `_clear_max`, of those
//! without ambiguous samples, each also in units of the working space (`_working`), with the pixel (`_x`, `_y`); then of
//! the `_pixels` drawn in the picture, and, after `_apart`, of those drawn where settings differ, `_median`, `_p99`,
//! `_p999`, `_rms`, and `_beyond_8_bit`, the share above 1/255. Then `ambiguous_pixels` and `ambiguous_pixels_beyond_8_bit`,
//! shares of pixels; `certified_over_measured` and `certified_over_measured_apart`, medians; `bounds_broken`,
//! `pixels_outside_hull`, `pixels_no_number`, counts of pixels; `render_seconds`, a median, `render_seconds_least`,
//! `render_seconds_most`, `render_runs`, `render_seconds_predicted`, `predicted_over_taken`; `certify_seconds`,
//! `certify_is_predicted`, `certify_over_render`; `bytes`, `threads`, `pareto`. Figures that are estimated have the ends of
//! their intervals in `_low` and `_high`. Errors are in `unit`; `allowed`, `certified` of attempts, `drop`, `bound` and
//! `error` of broken bounds, and columns in `_working`, are in units of the working space. Unknown values are null, in CSV
//! empty fields.
//!
//! The picture and, with `--whole`, maps of its error bounds are in `report.html` only.

mod csv;
mod data;
pub(crate) mod escape;
mod html;
mod json;
pub(crate) mod numbers;
pub(crate) mod pictures;
mod plots;
mod tables;
#[cfg(test)]
mod tests;
mod text;

use crate::changes::Changes;
use crate::failure::{FAILED, Failure, MISSED};
use crate::files::{self, FileOptions};
use crate::progress::Progress;
use crate::shell::{self, printable};
use crate::{interrupt, outputs, remedies, warnings};
use data::Report;
use std::path::PathBuf;
use trochoid::accuracy::{self, Effort, Ladder, LadderRequest, Request, TargetError};
use trochoid::{CheckedGraph, EvalError, Form, Format, Kind, Settings, Tolerance};

/// Options of `trochoid report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Renders the output in turns with settings from the coarsest to the most accurate, bounds the errors of pixels, and compares \
the same pixels with the f64 references. Writes report.html, report.json and report.csv.

Pixels are drawn by a seed: one in each of equal parts of the picture, which gives figures of all pixels with intervals; \
and as many where the settings differ, so that errors of few pixels are seen. As many pixels are looked at as fit into \
--seconds; the report says how many, and --pixels repeats its figures. What the time does not suffice for, or what is left \
to --whole, is said, too.

A tolerance is met by the fastest method that `trochoid plan` may choose; coarser and finer meshes are measured for \
comparison. If an error exceeds its bound, the exit code is 3.

Examples:
  trochoid report storm.json --frame 36 -o report
  trochoid report storm.json --size 320 --pixels 1024 -o report
  trochoid report storm.json --whole -o report")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Frame to report on [default: the document's first]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    frame: Option<i64>,
    /// Output to report on, a Color or Weights [default: the first Color]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Longest side of the measured pictures, in pixels; 0 means the document's size
    #[arg(long, value_name = "PIXELS", default_value_t = 640)]
    size: u32,
    /// Seconds in which the report is made, up to a single step of its work
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seconds: u32,
    /// Number of pixels to draw, instead of as many as fit into --seconds; rounded up to a power of 2
    #[arg(long, value_name = "N", conflicts_with = "seconds", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pixels: Option<u32>,
    /// Certify all pixels and draw a map, measure what is left out and what knobs cost, without a limit of time; draws
    /// 4096 pixels for the references, unless --pixels says otherwise
    #[arg(long, conflicts_with = "seconds")]
    whole: bool,
    /// Seed of the pixels that are drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    changes: Changes,
    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// Folder to write to
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    files: FileOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print report.json
    #[arg(long)]
    json: bool,
}

/// Tolerances from what a coarse mesh can meet to what f32 can meet.
const TOLERANCES: [f64; 10] =
    [1.0 / 8.0, 1.0 / 32.0, 1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0, 1e-3, 1e-4, 1e-5, 3e-6, 1e-6];

/// Kinds of `report.json`, `report.csv` and `report.html`.
const FORMS: [Form; 3] = [Form::Report, Form::Table, Form::Page];

/// Measures an output, and writes the report.
///
/// # Errors
/// All problems that can be found in advance, together; or the problem that stopped the run. Each file is written
/// whole or not at all.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let loaded = args.files.load(&args.graph, &args.changes.assignments())?;
    let graph = &loaded.graph;
    let frame = args.frame.unwrap_or(graph.frames().0);
    let mut faults = Vec::new();
    if args.out.exists() && !args.out.is_dir() {
        let found =
            format!("--out {}: found a file; expected a folder, for the three files of a report", args.out.display());
        return Err(Failure::usage(found, "give a folder, which need not exist yet"));
    }
    let output = choose(graph, args.output.as_ref(), &mut faults);
    let files = ["report.json", "report.csv", "report.html"].map(|name| args.out.join(name));
    let inputs = files::inputs(graph, &args.graph, &args.changes.assignments(), &[]);
    let refusal = |(file, form): (&PathBuf, Form)| args.files.over.refusal(file, form, &inputs);
    faults.extend(files.iter().zip(FORMS).filter_map(refusal));
    faults.extend(args.files.reach.refused(graph, &[output], &[frame], Vec::new()));
    warnings::after(faults, &warnings::of(graph, &[output], loaded.warnings))?;
    interrupt::watch()?;
    let ladder = measure(args, graph, output, frame)?;
    let report = Report::new(graph, &ladder, args.within());
    let json = format!("{:#}\n", json::to_json(&report));
    let html = html::page(&report).map_err(|error| Failure::new(FAILED, format!("report.html: {error}")))?;
    let csv = csv::table(&report).map_err(|error| Failure::new(FAILED, format!("report.csv: {error}")))?;
    for ((file, form), bytes) in files.iter().zip(FORMS).zip([json.as_bytes(), &csv, html.as_bytes()]) {
        trochoid::write_guarded(file, bytes, form, args.files.over.overwrite)?;
    }
    if args.json {
        shell::print(&json)?;
    } else if !args.quiet {
        let written = printable(&files[2].display().to_string());
        let table = text::table(&report);
        shell::print(&format!("{table}\nwritten: {written}, with report.json and report.csv beside it\n"))?;
    }
    if report.ladder.rungs.iter().all(|rung| rung.broken.is_empty()) { Ok(()) } else { Err(Failure::silent(MISSED)) }
}

impl Args {
    fn effort(&self) -> Effort {
        match (self.whole, self.pixels) {
            (true, pixels) => Effort::Whole(pixels.map_or(Effort::MOST, |pixels| pixels as usize)),
            (false, Some(pixels)) => Effort::Pixels(pixels as usize),
            (false, None) => Effort::Within(f64::from(self.seconds)),
        }
    }

    /// Returns the limit of time, if there is one.
    fn within(&self) -> Option<f64> {
        if let Effort::Within(seconds) = self.effort() { Some(seconds) } else { None }
    }
}

/// Returns the index of the output, which is the first Color if none is named.
fn choose(graph: &CheckedGraph, name: Option<&String>, faults: &mut Vec<Failure>) -> usize {
    let Some(name) = name else {
        let color = graph.outputs().iter().position(|output| output.kind == Kind::Color);
        if color.is_none() {
            faults.push(Failure::usage("found no output that is a Color; expected one", "name another with --output"));
        }
        return color.unwrap_or(0);
    };
    let before = faults.len();
    let index = outputs::choose(graph, std::slice::from_ref(name), faults)[0];
    let output = &graph.outputs()[index];
    if faults.len() == before && !matches!(output.kind, Kind::Color | Kind::Weights(_)) {
        let message = format!("--output: found \"{name}\", a {}; expected a Color or Weights", output.kind);
        faults.push(Failure::usage(message, "choose another: tolerances apply to displayed values"));
    }
    index
}

/// Measures at the requested size, or at the document's own size if it reads files that must have the size of the
/// picture.
fn measure(args: &Args, graph: &CheckedGraph, output: usize, frame: i64) -> Result<Ladder, Failure> {
    let mut settings = Settings::default();
    settings.threads = usize::from(args.threads);
    let names = [graph.outputs()[output].name.as_str()];
    // The request of the ladder has the tolerances; this one is ignored.
    let request = Request { outputs: &names, frame, tolerance: Tolerance::Exact, settings: &settings };
    let load = |more: &[String]| args.files.load(&args.graph, &[args.changes.assignments().as_slice(), more].concat());
    let mut progress = Progress::new(1, args.quiet);
    progress.begin(0, frame);
    let small = smaller(graph.format(), args.size);
    let climb = |format: Option<Format>| {
        let asked = LadderRequest { request, format, effort: args.effort(), seed: args.seed, tolerances: &TOLERANCES };
        accuracy::climb(&load, &asked, &progress)
    };
    let found = match climb(small) {
        Err(TargetError::Evaluate(error @ EvalError::Node { .. })) if small.is_some() => {
            let [width, height] = [graph.format().width(), graph.format().height()];
            progress.tell(&[format!(
                "warning: --size {}: found a node that needs the document's size ({}); measured at {width} × {height} pixels",
                args.size,
                remedies::evaluation(&error)
            )]);
            climb(None)
        }
        found => found,
    };
    progress.finish();
    found.map_err(|error| match error {
        TargetError::Load(error) => error.into(),
        TargetError::Evaluate(EvalError::Cancelled) => Failure::interrupted(),
        TargetError::Evaluate(error) => Failure::evaluated(&format!("frame {frame}: "), &error),
        error => Failure::new(FAILED, format!("frame {frame}: {error}")),
    })
}

/// Scales a format to a longest side of this many pixels; `None` if the format is not larger.
fn smaller(format: Format, longest: u32) -> Option<Format> {
    let most = format.width().max(format.height());
    if longest == 0 || longest >= most {
        return None;
    }
    let side = |side: u32| {
        let scaled = (f64::from(side) * f64::from(longest) / f64::from(most)).round();
        (scaled as u32).max(1)
    };
    let small = Format::new(side(format.width()), side(format.height()), format.samples());
    small.ok().map(|small| small.sampled_like(format))
}

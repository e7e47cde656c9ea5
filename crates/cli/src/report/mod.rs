//! `trochoid report`: error against run time, as data, as a table, and as a page of plots.
//!
//! `report.json` has `trochoid`, the version; `scene`, `output`, `frame`, `format`, `space`, `threads`; `whole`,
//! whether the whole picture is certified; `summary`, sentences; `rungs`, a list of settings, each with the columns of
//! `report.csv`, with `set`, and with `passes`, a list of `{node, type, drop}`; `attempts`, a list of `{tolerance,
//! allowed, scope, met, set, certified_max, limited_by}`, where `limited_by` is a pass, `{node, type}`, with `why` if
//! it has no error bound, or "rounding" or "what is seen"; `savings`, a list of `{node, type, why, seconds}`;
//! `scalings`, a list of `{knob, points: [{value, seconds}]}`.
//!
//! Columns of a rung: `scene`, `output`, `frame`, `settings`, `is_method` (whether `plan` may choose them), `scope`
//! ("whole" or "strips": the area in which errors are certified and measured, and tolerances met); `certified_max`,
//! `certified_p999`, `certified_median`; `measured_max`, `measured_rms`, `measured_p999`, `measured_median`, over
//! `measured_pixels`; `certified_over_measured`; `ambiguous` and `ambiguous_beyond_8_bit`, shares of samples;
//! `hull_exits`, `nan_count`; `seconds`, `seconds_spread`, `seconds_predicted`, `predicted_over_taken`; `bytes`,
//! `threads`, `pareto`. Errors are in units of the working space. Unknown values are null, in CSV empty fields.
//!
//! The picture and, with `--whole`, maps of its error bounds are in `report.html` only.

mod csv;
mod data;
mod escape;
mod html;
mod numbers;
mod pictures;
mod plots;
mod tables;
#[cfg(test)]
mod tests;
mod text;

use crate::failure::{FAILED, Failure};
use crate::files::{self, FileOptions};
use crate::progress::Progress;
use crate::remedies;
use crate::shell::{self, printable};
use crate::{interrupt, outputs};
use data::Report;
use std::path::PathBuf;
use trochoid::accuracy::{self, Ladder, LadderRequest, Request, TargetError};
use trochoid::{CheckedGraph, EvalError, Form, Format, Kind, Settings, Tolerance};

/// Options of `trochoid report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Renders the output with settings from the coarsest to the most accurate; certifies and times each, and compares pixels \
with the f64 references. Writes report.html, report.json and report.csv. The references are slow: a sixth of a second per \
pixel for a sea of 300 waves, and a minute before the first pixel for a toon sea.

Error bounds are certified and tolerances are judged on strips, an eighth of the picture in total; elsewhere errors may \
be larger. --whole certifies the whole picture and draws a map of its errors. A tolerance is met by the fastest method \
that `trochoid plan` may choose; coarser and finer meshes are measured for comparison.

Examples:
  trochoid report storm.json --frame 36 -o report
  trochoid report storm.json --size 320 --pixels 40 --whole -o report")]
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
    /// Number of pixels to compare with the references
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pixels: u32,
    /// Certify the whole picture, and draw a map of its errors
    #[arg(long)]
    whole: bool,
    /// Set a knob or port; VALUE is JSON or a bare word, such as storm.height=3; may be repeated
    #[arg(long, value_name = "NODE.KNOB=VALUE")]
    set: Vec<String>,
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
    let loaded = args.files.load(&args.graph, &args.set)?;
    shell::tell(&remedies::texts(&loaded.warnings));
    let graph = &loaded.graph;
    let frame = args.frame.unwrap_or(graph.frames().0);
    let mut faults = Vec::new();
    let output = choose(graph, args.output.as_ref(), &mut faults);
    let files = ["report.json", "report.csv", "report.html"].map(|name| args.out.join(name));
    let inputs = files::inputs(graph, &args.graph, &args.set, &[]);
    let refusal = |(file, form): (&PathBuf, Form)| args.files.over.refusal(file, form, &inputs);
    faults.extend(files.iter().zip(FORMS).filter_map(refusal));
    faults.extend(args.files.reach.refused(graph, &[output], &[frame], Vec::new()));
    Failure::all(faults)?;
    interrupt::watch()?;
    let ladder = measure(args, graph, output, frame)?;
    let report = Report::new(graph, &ladder, args.whole);
    let json = format!("{:#}\n", data::to_json(&report));
    let html = html::page(&report).map_err(|error| Failure::new(FAILED, format!("report.html: {error}")))?;
    let csv = csv::table(&report).map_err(|error| Failure::new(FAILED, format!("report.csv: {error}")))?;
    for ((file, form), bytes) in files.iter().zip(FORMS).zip([json.as_bytes(), &csv, html.as_bytes()]) {
        trochoid::write_guarded(file, bytes, form, args.files.over.overwrite)?;
    }
    if args.json {
        return shell::print(&json);
    }
    if args.quiet {
        return Ok(());
    }
    let written = printable(&files[2].display().to_string());
    shell::print(&format!("{}\nwritten: {written}, with report.json and report.csv beside it\n", text::table(&report)))
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
    let load = |more: &[String]| args.files.load(&args.graph, &[args.set.as_slice(), more].concat());
    let mut progress = Progress::new(1, args.quiet);
    progress.begin(0, frame);
    let small = smaller(graph.format(), args.size);
    let climb = |format: Option<Format>| {
        let pixels = args.pixels as usize;
        let asked = LadderRequest { request, format, pixels, whole: args.whole, tolerances: &TOLERANCES };
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
    small.ok().map(|small| small.with_shading(format.shading()))
}

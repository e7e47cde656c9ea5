//! `trochoid plan`: finds settings that meet a tolerance.
//!
//! The JSON output is the plan that `--out` writes: `trochoid_plan`, `document_hash`, `frame`, `tolerance`, `set`,
//! `predicted_seconds`, `certified`.

use crate::changes::Changes;
use crate::failure::{FAILED, Failure, MISSED};
use crate::files::{self, AccessOptions, FileOptions};
use crate::progress::Progress;
use crate::shell::{self, printable};
use crate::{interrupt, outputs, warnings};
use std::path::{Path, PathBuf};
use trochoid::accuracy::{self, MissedTolerance, PlanFile, PlannedSettings, Request, TargetError};
use trochoid::{CheckedGraph, EvalError, Form, Monitor, Settings, Tolerance};

/// Options of `trochoid plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Tries methods from the coarsest to the most accurate until the f64 bounds of all passes certify that no unambiguous sample \
exceeds the tolerance: first on strips of the picture, then on the whole picture. `render --plan` uses the plan.

Exit code 3 means that the most accurate methods miss the tolerance; the message names the pass that limits them.

Examples:
  trochoid plan storm.json --tolerance 1/64 --frame 36 --out storm.plan.json
  trochoid render storm.json --plan storm.plan.json")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Maximum error of a displayed value, such as 1/512; or exact [default: the document's tolerance]
    #[arg(long, value_name = "ERROR", value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: Option<Tolerance>,
    /// Frame to plan for [default: the document's first]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    frame: Option<i64>,
    /// Plan for this output; may be repeated [default: all outputs]
    #[arg(long, value_name = "NAME")]
    output: Vec<String>,
    #[command(flatten)]
    changes: Changes,
    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// Write the plan to this file as JSON
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    files: FileOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

/// Error in a tolerance.
#[derive(Debug, thiserror::Error)]
#[error("expected {}", Tolerance::EXPECTED)]
pub(crate) struct NoTolerance;

/// Parses a tolerance of the command line.
pub(crate) fn tolerance(text: &str) -> Result<Tolerance, NoTolerance> {
    Tolerance::parse(text).ok_or(NoTolerance)
}

/// Finds a plan, and prints or writes it.
///
/// # Errors
/// The document or the options are invalid, no settings meet the tolerance, or the plan cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let loaded = args.files.load(&args.graph, &args.changes.assignments())?;
    let graph = &loaded.graph;
    let mut faults = Vec::new();
    let chosen = outputs::choose(graph, &args.output, &mut faults);
    let asked = args.tolerance.or(graph.tolerance());
    if asked.is_none() {
        faults.push(Failure::usage(
            "found no --tolerance and no \"tolerance\" in the document; expected one of them",
            "say how far pixels may be off, such as --tolerance 1/512",
        ));
    } else if asked == Some(Tolerance::Reference) {
        faults.push(Failure::usage(
            "found the tolerance reference; expected an error or exact: references have no settings to choose",
            "render with --tolerance reference",
        ));
    }
    let frame = args.frame.unwrap_or(graph.frames().0);
    if let Some(out) = &args.out {
        // A search takes minutes, so a destination that cannot be written is reported before it.
        let inputs = files::inputs(graph, &args.graph, &args.changes.assignments(), &[]);
        faults.extend(files::ending("--out", out, "json"));
        faults.extend(args.files.over.refusal(out, Form::Plan, &inputs));
    }
    faults.extend(args.files.reach.refused(graph, &chosen, &[frame], Vec::new()));
    warnings::after(faults, &warnings::of(graph, &chosen, loaded.warnings))?;
    let Some(asked) = asked else { return Ok(()) };
    let mut settings = Settings::default();
    settings.threads = usize::from(args.threads);
    interrupt::watch()?;
    let mut progress = Progress::new(1, args.quiet);
    progress.begin(0, frame);
    let target = Target {
        reach: &args.files.reach,
        path: &args.graph,
        set: &args.changes.assignments(),
        graph,
        outputs: &chosen,
        frame,
        settings: &settings,
    };
    let planned = target.search(asked, &progress)?;
    progress.finish();
    let plan = PlanFile::new(graph, frame, asked, &planned);
    if let Some(path) = &args.out {
        trochoid::write_guarded(path, plan.text().as_bytes(), Form::Plan, args.files.over.overwrite)?;
    }
    if args.json {
        return shell::print(&plan.text());
    }
    if args.quiet { Ok(()) } else { shell::print(&described(graph, asked, &planned)) }
}

/// Outputs of a document at a frame, for which settings are sought.
pub(crate) struct Target<'a> {
    pub(crate) reach: &'a AccessOptions,
    pub(crate) path: &'a Path,
    pub(crate) set: &'a [String],
    /// The document with `set` applied.
    pub(crate) graph: &'a CheckedGraph,
    pub(crate) outputs: &'a [usize],
    pub(crate) frame: i64,
    pub(crate) settings: &'a Settings,
}

impl Target<'_> {
    /// Searches for settings that meet a tolerance.
    pub(crate) fn search(&self, tolerance: Tolerance, monitor: &dyn Monitor) -> Result<PlannedSettings, Failure> {
        let outputs: Vec<&str> = self.outputs.iter().map(|index| self.graph.outputs()[*index].name.as_str()).collect();
        let load = |more: &[String]| self.reach.load(self.path, &[self.set, more].concat());
        let request = Request { outputs: &outputs, frame: self.frame, tolerance, settings: self.settings };
        accuracy::plan(&load, &request, monitor).map_err(|error| match error {
            TargetError::Load(error) => error.into(),
            TargetError::Evaluate(EvalError::Cancelled) => Failure::interrupted(),
            TargetError::Evaluate(error) => Failure::evaluated(&format!("frame {}: ", self.frame), &error),
            TargetError::Missed(missed) => self.missed(&missed),
            unknown @ TargetError::Unknown { .. } => Failure::new(
                MISSED,
                format!(
                    "frame {}: {unknown}\n  remedy: plan an output that does not depend on it, such as a pass before it; \
                     or ask for \"exact\" or \"reference\", which certify nothing",
                    self.frame
                ),
            ),
            error => Failure::new(FAILED, format!("frame {}: {error}", self.frame)),
        })
    }

    fn missed(&self, missed: &MissedTolerance) -> Failure {
        let within = |parts: &i32| accuracy::allowed(0.5_f64.powi(*parts), self.graph.space()) >= missed.certified;
        let remedy = match (1..60).rev().find(within) {
            Some(parts) => format!("ask for {} or more, or for \"reference\"", Tolerance::Error(0.5_f64.powi(parts))),
            None => "render with --error to see where it is so; ask for \"reference\"".into(),
        };
        Failure { code: MISSED, ..Failure::usage(format!("frame {}: {missed}", self.frame), remedy) }
    }
}

/// Formats a plan as one line: `tolerance 1/64: view.points=surface  beauty: unambiguous samples off by ≤ 8.5e-3 in
/// displayed values, 1.45 % of the samples ambiguous, 5.9 s predicted`.
pub(crate) fn described(graph: &CheckedGraph, asked: Tolerance, planned: &PlannedSettings) -> String {
    let set = if planned.set.is_empty() { "nothing to choose".to_owned() } else { planned.set.join(", ") };
    let mut facts: Vec<String> = planned
        .certified
        .iter()
        .map(|certified| {
            let (clear, all) = (certified.clear.total(), certified.clear.total() + certified.unclear.total());
            let name = printable(&graph.outputs()[certified.output].name);
            let share = 100.0 * (all - clear) as f64 / all.max(1) as f64;
            let max = certified.clear.max();
            let (max, unit) = match accuracy::displayed_of(certified.kind, max, graph.space()) {
                Some(shown) => (shown, " in displayed values"),
                None => (max, ""),
            };
            format!("{name}: unambiguous samples off by ≤ {max:.1e}{unit}, {share:.2} % of the samples ambiguous")
        })
        .collect();
    facts.push(format!("{:.2} s predicted", planned.predicted));
    format!("tolerance {asked}: {}  {}\n", printable(&set), facts.join(", "))
}

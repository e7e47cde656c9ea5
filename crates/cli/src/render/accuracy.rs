//! Accuracy settings of a run, from a tolerance or a plan.

use super::args::Args;
use crate::failure::Failure;
use crate::interrupt;
use crate::plan::{Target, described};
use crate::progress::Progress;
use crate::shell::printable;
use serde_json::{Value, json};
use std::path::Path;
use trochoid::accuracy::{PlanFile, PlannedSettings, allowed, displayed_of};
use trochoid::{Certified, CheckedGraph, Item, Kind, LoadError, Settings, Tolerance, quoted_path};

/// Requested tolerance of a run, and the settings chosen for it.
#[derive(Default)]
pub(super) struct Accuracy {
    pub(super) asked: Option<Tolerance>,
    /// Assignments in addition to `--set`.
    pub(super) set: Vec<String>,
    /// First frame, and the settings found for it.
    planned: Option<(i64, PlannedSettings)>,
}

impl Accuracy {
    /// Searches for settings at the first frame of a run and prints them, or takes the settings of a plan.
    pub(super) fn settle(
        args: &Args,
        graph: &CheckedGraph,
        outputs: &[usize],
        frames: &[i64],
        settings: &Settings,
    ) -> Result<Self, Failure> {
        if let Some(path) = &args.plan {
            let plan = PlanFile::read(path)?;
            Failure::all(strange(path, &plan, graph))?;
            crate::shell::tell(&doubts(path, &plan, graph, frames));
            return Ok(Self { set: plan.assignments(), ..Self::default() });
        }
        let asked = args.tolerance(graph);
        let (Some(tolerance), Some(&frame)) = (asked, frames.first()) else { return Ok(Self::default()) };
        if tolerance == Tolerance::Reference {
            return Ok(Self { asked, ..Self::default() });
        }
        interrupt::watch()?;
        let mut progress = Progress::new(1, args.quiet);
        progress.begin(0, frame);
        let target = Target {
            reach: &args.files.reach,
            path: &args.graph,
            set: &args.assignments(),
            graph,
            outputs,
            frame,
            settings,
        };
        let planned = target.search(tolerance, &progress)?;
        progress.finish();
        if !args.quiet && !args.json && !args.report_on_stdout() {
            crate::shell::print(&described(graph, tolerance, &planned))?;
        }
        Ok(Self { asked, set: planned.set.clone(), planned: Some((frame, planned)) })
    }

    /// Returns the failure of loading the document with these settings; faults in the settings of a plan name the plan.
    pub(super) fn refused(&self, args: &Args, error: LoadError) -> Failure {
        match (error, &args.plan) {
            (LoadError::Invalid(mut faults), Some(plan)) => {
                for fault in faults.iter_mut().filter(|fault| fault.is_assigned) {
                    // Assignments of the command line have been accepted before.
                    (fault.file, fault.is_assigned) = (format!("{}: set {}", plan.display(), fault.file), false);
                    fault.means = None;
                    fault.remedy = format!(
                        "plan again for this document: trochoid plan {} --tolerance 1/64 --out {}",
                        quoted_path(&args.graph),
                        // Next to the document: the plan that does not fit may belong to another document.
                        quoted_path(&args.graph.with_extension("plan.json"))
                    );
                }
                LoadError::Invalid(faults).into()
            }
            (error, _) => error.into(),
        }
    }

    /// Returns whether the references themselves evaluate the pictures.
    pub(super) fn by_reference(&self) -> bool {
        self.asked == Some(Tolerance::Reference)
    }

    /// Returns the error that no frame may exceed.
    pub(super) fn error(&self) -> Option<f64> {
        match self.asked {
            Some(Tolerance::Error(error)) => Some(error),
            _ => None,
        }
    }

    /// Returns the certified errors of outputs at a frame if planning has determined them already.
    pub(super) fn known(&self, frame: i64, outputs: &[usize]) -> Option<Vec<Certified>> {
        let (at, planned) = self.planned.as_ref()?;
        let find = |output: &usize| planned.certified.iter().find(|certified| certified.output == *output).cloned();
        if *at == frame { outputs.iter().map(find).collect() } else { None }
    }

    /// Returns messages for the outputs whose certified error at a frame exceeds the tolerance.
    pub(super) fn misses(&self, graph: &CheckedGraph, frame: i64, certified: &[Certified]) -> Vec<String> {
        let Some(error) = self.error() else { return Vec::new() };
        let miss = |certified: &Certified| {
            let most = match certified.kind {
                Kind::Color => allowed(error, graph.space()),
                Kind::Weights(_) => error,
                _ => return None,
            };
            let (name, max) = (&graph.outputs()[certified.output].name, certified.clear.max());
            let shown = displayed_of(certified.kind, max, graph.space())?;
            (max > most).then(|| {
                format!(
                    "error: frame {frame}: output \"{name}\": found a certified error of {shown:.1e} in displayed values; \
                     expected at most {error:.1e}, as the tolerance requires\n  remedy: plan at this frame: trochoid plan \
                     --frame {frame}"
                )
            })
        };
        certified.iter().filter_map(miss).collect()
    }

    /// Describes the tolerance, the settings, and the predicted and actual time of a frame, for the report.
    pub(super) fn described(&self, frame: i64, seconds: f64) -> Value {
        let planned = self.planned.as_ref().filter(|(at, _)| *at == frame);
        json!({
            "tolerance": self.asked.map(|asked| asked.to_string()),
            "set": self.set,
            "predicted_seconds": planned.map(|(_, planned)| planned.predicted),
            "took_seconds": seconds,
        })
    }
}

/// Returns failures for assignments of a plan that do not set accuracy knobs. A plan may come from anywhere, but its
/// assignments are trusted like those of the user.
fn strange(path: &Path, plan: &PlanFile, graph: &CheckedGraph) -> Vec<Failure> {
    let is_accuracy = |knob: &str| {
        let Some((node, knob)) = knob.split_once('.') else { return true };
        // An assignment that does not fit the document is reported when it is applied.
        let Some(id) = graph.find(node) else { return true };
        let mut items = graph.node(id).ty.declaration().items.iter();
        items.all(|item| !matches!(item, Item::Knob(found) if found.name == knob && !found.accuracy))
    };
    let strange = plan.set.keys().filter(|knob| !is_accuracy(knob));
    let fault = |knob: &String| {
        let message = format!("{}: found an assignment to \"{knob}\"; expected accuracy knobs only", path.display());
        Failure::usage(message, "plan again, or set it with --set")
    };
    strange.map(fault).collect()
}

/// Returns warnings if a plan is used for something that it was not made for.
fn doubts(path: &Path, plan: &PlanFile, graph: &CheckedGraph, frames: &[i64]) -> Vec<String> {
    let warning = |found: &str, expected: &str, remedy: &str| {
        format!("warning: {}: found {found}; expected {expected}\n  remedy: {remedy}", path.display())
    };
    let mut doubts = Vec::new();
    let hash = graph.document_hash();
    if plan.document_hash != hash {
        let found = format!("a plan for another document, with the hash {}", short(&plan.document_hash));
        let expected = format!("{}, the current hash of {}", short(&hash), graph.name());
        doubts.push(warning(&found, &expected, "plan again: its certified errors may not hold"));
    }
    let others: Vec<i64> = frames.iter().copied().filter(|frame| *frame != plan.frame).collect();
    let listed = match others[..] {
        [] => None,
        [frame] => Some(format!("frame {frame}")),
        [first, .., last] => Some(format!("{} other frames from {first} to {last}", others.len())),
    };
    if let Some(listed) = listed {
        let found = format!("a plan made at frame {}", plan.frame);
        let expected = format!("one for {listed} as well");
        doubts.push(warning(&found, &expected, "render with --tolerance, which certifies every frame"));
    }
    let planned = Tolerance::parse(&plan.tolerance);
    if let (Some(planned), Some(asked)) = (planned, graph.tolerance())
        && is_tighter(asked, planned)
    {
        let expected = format!("{asked}, which the document requires");
        doubts.push(warning(&format!("a plan for the tolerance {planned}"), &expected, "plan again, or omit --plan"));
    }
    doubts
}

/// Returns the first digits of a hash, which may be any text of a file.
fn short(hash: &str) -> String {
    let digits: String = hash.chars().take(12).collect();
    if digits.is_empty() { "nothing".into() } else { printable(&digits) + "…" }
}

/// Returns whether one tolerance is stricter than another.
fn is_tighter(asked: Tolerance, planned: Tolerance) -> bool {
    match (asked, planned) {
        (Tolerance::Error(asked), Tolerance::Error(planned)) => asked < planned,
        (Tolerance::Exact, Tolerance::Error(_)) => true,
        (Tolerance::Reference, planned) => planned != Tolerance::Reference,
        _ => false,
    }
}

//! Settings from a tolerance or a plan, for a run.

use super::args::Args;
use crate::failure::Failure;
use crate::interrupt;
use crate::plan::{Target, described};
use crate::progress::Progress;
use crate::shell::printable;
use serde_json::{Value, json};
use std::path::Path;
use trochoid::accuracy::{PlanFile, Planned, allowed};
use trochoid::{Certified, CheckedGraph, Item, Kind, LoadError, Settings, Tolerance, quoted_path};

/// What a run was asked for, and the settings that it has for that.
#[derive(Default)]
pub(super) struct Accuracy {
    pub(super) asked: Option<Tolerance>,
    /// Assignments beyond `--set`.
    pub(super) set: Vec<String>,
    /// What was found for the first frame.
    planned: Option<(i64, Planned)>,
}

impl Accuracy {
    /// Looks for settings at the first frame of a run, or takes those of a plan; prints what it chose.
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
        let asked = args.tolerance.or(graph.tolerance());
        let (Some(tolerance), Some(&frame)) = (asked, frames.first()) else { return Ok(Self::default()) };
        if tolerance == Tolerance::Reference {
            return Ok(Self { asked, ..Self::default() });
        }
        interrupt::watch()?;
        let mut progress = Progress::new(1, args.quiet);
        progress.begin(0, frame);
        let target =
            Target { reach: &args.files.reach, path: &args.graph, set: &args.set, graph, outputs, frame, settings };
        let planned = target.search(tolerance, &progress)?;
        progress.finish();
        if !args.quiet && !args.json && !args.report_on_stdout() {
            crate::shell::print(&described(graph, tolerance, &planned))?;
        }
        Ok(Self { asked, set: planned.set.clone(), planned: Some((frame, planned)) })
    }

    /// What is wrong with a document as its settings have it: in those of a plan, which is named then.
    pub(super) fn refused(&self, args: &Args, error: LoadError) -> Failure {
        match (error, &args.plan) {
            (LoadError::Invalid(mut faults), Some(plan)) => {
                for fault in faults.iter_mut().filter(|fault| fault.is_assigned) {
                    // Those of the command line have been found to fit.
                    (fault.file, fault.is_assigned) = (format!("{}: set {}", plan.display(), fault.file), false);
                    fault.means = None;
                    fault.remedy = format!(
                        "plan again for this document: trochoid plan {} --tolerance 1/64 --out {}",
                        quoted_path(&args.graph),
                        // Beside the document: the one that does not fit may be another's.
                        quoted_path(&args.graph.with_extension("plan.json"))
                    );
                }
                LoadError::Invalid(faults).into()
            }
            (error, _) => error.into(),
        }
    }

    /// Whether pictures come from the references themselves.
    pub(super) fn by_reference(&self) -> bool {
        self.asked == Some(Tolerance::Reference)
    }

    /// The error that every frame has to stay below.
    pub(super) fn error(&self) -> Option<f64> {
        match self.asked {
            Some(Tolerance::Error(error)) => Some(error),
            _ => None,
        }
    }

    /// What is certain of some outputs at a frame, where planning has found it out already.
    pub(super) fn known(&self, frame: i64, outputs: &[usize]) -> Option<Vec<Certified>> {
        let (at, planned) = self.planned.as_ref()?;
        let find = |output: &usize| planned.certified.iter().find(|certified| certified.output == *output).cloned();
        if *at == frame { outputs.iter().map(find).collect() } else { None }
    }

    /// The outputs that a frame's certificates do not grant the tolerance.
    pub(super) fn misses(&self, graph: &CheckedGraph, frame: i64, certified: &[Certified]) -> Vec<String> {
        let Some(error) = self.error() else { return Vec::new() };
        let miss = |certified: &Certified| {
            let most = match certified.kind {
                Kind::Color => allowed(error, graph.space()),
                Kind::Weights(_) => error,
                _ => return None,
            };
            let (name, max) = (&graph.outputs()[certified.output].name, certified.clear.max());
            (max > most).then(|| {
                format!(
                    "error: frame {frame}: output \"{name}\": found {max:.1e} certified; expected at most {most:.1e}, which the \
                     tolerance allows\n  remedy: plan at this frame: trochoid plan --frame {frame}"
                )
            })
        };
        certified.iter().filter_map(miss).collect()
    }

    /// What was chosen, predicted and taken at a frame, for the report.
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

/// What a plan sets that no plan sets: a plan may come from anywhere, and what is set beside a document is trusted.
fn strange(path: &Path, plan: &PlanFile, graph: &CheckedGraph) -> Vec<Failure> {
    let is_accuracy = |knob: &str| {
        let Some((node, knob)) = knob.split_once('.') else { return true };
        // What does not fit the document is told when it is set.
        let Some(id) = graph.find(node) else { return true };
        let mut items = graph.node(id).ty.declaration().items.iter();
        items.all(|item| !matches!(item, Item::Knob(found) if found.name == knob && !found.accuracy))
    };
    let strange = plan.set.keys().filter(|knob| !is_accuracy(knob));
    let fault = |knob: &String| {
        let message = format!("{}: found \"{knob}\" set; expected knobs of accuracy alone", path.display());
        Failure::usage(message, "plan again, or set it with --set")
    };
    strange.map(fault).collect()
}

/// What a plan was not made for, of that which it is used for.
fn doubts(path: &Path, plan: &PlanFile, graph: &CheckedGraph, frames: &[i64]) -> Vec<String> {
    let warning = |found: &str, expected: &str, remedy: &str| {
        format!("warning: {}: found {found}; expected {expected}\n  remedy: {remedy}", path.display())
    };
    let mut doubts = Vec::new();
    let hash = graph.document_hash();
    if plan.document_hash != hash {
        let found = format!("a plan for another document, of the hash {}", short(&plan.document_hash));
        let expected = format!("{}, which {} has as it is now", short(&hash), graph.name());
        doubts.push(warning(&found, &expected, "plan again: what is certified in it may not hold"));
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
        let expected = format!("{asked}, for which the document asks");
        doubts.push(warning(
            &format!("a plan for the tolerance {planned}"),
            &expected,
            "plan again, or leave --plan away",
        ));
    }
    doubts
}

/// The first digits of a hash, of whatever a file says that it is.
fn short(hash: &str) -> String {
    let digits: String = hash.chars().take(12).collect();
    if digits.is_empty() { "nothing".into() } else { printable(&digits) + "…" }
}

/// Whether one tolerance asks for more than another.
fn is_tighter(asked: Tolerance, planned: Tolerance) -> bool {
    match (asked, planned) {
        (Tolerance::Error(asked), Tolerance::Error(planned)) => asked < planned,
        (Tolerance::Exact, Tolerance::Error(_)) => true,
        (Tolerance::Reference, planned) => planned != Tolerance::Reference,
        _ => false,
    }
}

//! Settings from a tolerance or a plan, for a run.

use super::Args;
use crate::failure::Failure;
use crate::interrupt;
use crate::plan::{Target, described};
use crate::progress::Progress;
use serde_json::{Value, json};
use trochoid::accuracy::{PlanFile, Planned, allowed};
use trochoid::{Certified, CheckedGraph, Kind, Settings, Tolerance};

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
        frame: Option<i64>,
        settings: &Settings,
    ) -> Result<Self, Failure> {
        if let Some(path) = &args.plan {
            let plan = PlanFile::read(path)?;
            if plan.document_hash != graph.document_hash() {
                crate::shell::tell(&[format!(
                    "warning: {}: found a plan for another document than {} as it is now; expected its own\n  remedy: plan \
                     again: what is certified in it may not hold",
                    path.display(),
                    args.graph.display()
                )]);
            }
            return Ok(Self { set: plan.assignments(), ..Self::default() });
        }
        let asked = args.tolerance.or(graph.tolerance());
        let (Some(tolerance), Some(frame)) = (asked, frame) else { return Ok(Self::default()) };
        if tolerance == Tolerance::Reference {
            return Ok(Self { asked, ..Self::default() });
        }
        interrupt::watch()?;
        let mut progress = Progress::new(1, args.quiet);
        progress.begin(0, frame);
        let target = Target { path: &args.graph, set: &args.set, graph, outputs, frame, settings };
        let planned = target.search(tolerance, &progress)?;
        progress.finish();
        if !args.quiet && !args.json && !args.report_on_stdout() {
            crate::shell::print(&described(graph, tolerance, &planned))?;
        }
        Ok(Self { asked, set: planned.set.clone(), planned: Some((frame, planned)) })
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

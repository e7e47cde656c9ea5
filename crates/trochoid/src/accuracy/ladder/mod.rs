//! Error against run time: settings from the coarsest to the most accurate, each certified, measured and timed.

mod limit;
mod request;
mod rung;
mod truth;
mod work;

pub use limit::Limit;
pub use request::LadderRequest;
pub use rung::{Errors, PassError, Rung};
pub use work::{Saving, Scaling};

use super::{Request, TargetError, allowed_of, knobs, pilot};
use crate::{LoadError, Loaded};
use limit::limit;
use rung::RungMeasurement;
use trochoid_engine::Monitor;
use trochoid_graph::CheckedGraph;
use trochoid_image::{Format, Window};
use truth::Truth;
use work::{savings, scalings};

/// Measured settings of an output, with the tolerances that they meet.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// Name of the output.
    pub output: String,
    /// Number of the frame.
    pub frame: i64,
    /// Format of the measured pictures.
    pub format: Format,
    /// Number of threads.
    pub threads: usize,
    /// Rungs in order of decreasing error, as far as that is known: coarse and fine meshes first, then the more
    /// accurate methods.
    pub rungs: Vec<Rung>,
    /// Result of each tolerance.
    pub attempts: Vec<Attempt>,
    /// Nodes that the output does not need, or parts of their work.
    pub savings: Vec<Saving>,
    /// Run time by the values of knobs that increase work.
    pub scalings: Vec<Scaling>,
}

/// Tolerance, and the settings that meet it.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Tolerance of displayed values.
    pub tolerance: f64,
    /// Error that the tolerance allows in the working space.
    pub allowed: f64,
    /// Index of the fastest settings that are certified to meet the tolerance, out of those that [`plan`](super::plan)
    /// chooses from; `None` if none do. If only strips of the picture are certified, the tolerance is met on these.
    pub rung: Option<usize>,
    /// Reason that no settings meet the tolerance.
    pub limit: Option<Limit>,
}

/// Factors for accuracy knobs that are numbers.
const FINENESS: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

/// Measures an output of a document; `load` loads the document with additional assignments.
///
/// # Errors
/// As [`plan`](super::plan), except that a missed tolerance is not an error; or the reference fails.
pub fn climb(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    asked: &LadderRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Ladder, TargetError> {
    let sized = |set: &[String]| -> Result<CheckedGraph, LoadError> {
        let graph = load(set)?.graph;
        Ok(match asked.format {
            Some(format) => graph.with_format(format),
            None => graph,
        })
    };
    let graph = sized(&[])?;
    let request = &asked.request;
    let named = graph.outputs().iter().find(|output| output.name == request.outputs[0]);
    let allows = |tolerance: f64| named.and_then(|output| allowed_of(output.kind, tolerance, graph.space()));
    if named.is_some() && allows(1.0).is_none() {
        return Err(TargetError::NothingDisplayed);
    }
    let window = graph.format().window();
    let regions: Vec<Window> = if asked.whole { vec![window] } else { pilot::strips(window).to_vec() };
    let settings = settings(&graph, request);
    // Steps: the references, the rungs, and three more. Progress of a run within a step is not reported.
    let told = monitor;
    let monitor = &WithoutProgress(monitor);
    let (grain, steps) = (asked.pixels.max(1), settings.len() + 4);
    let tell = |step: usize| told.progress(step * grain, steps * grain);
    let truth = Truth::new(&graph, asked, &regions, &FirstSteps { monitor: told, steps })?;
    let mut rungs: Vec<Rung> = Vec::new();
    for (index, (set, is_method)) in settings.into_iter().enumerate() {
        tell(index + 1);
        let graph = sized(&set)?;
        rungs.push(
            RungMeasurement { graph: &graph, asked, regions: &regions, truth: &truth, monitor }.rung(set, is_method)?,
        );
    }
    for index in 0..rungs.len() {
        let own = (rungs[index].seconds, rungs[index].certified.max);
        let beats = |other: &Rung| {
            other.seconds <= own.0 && other.certified.max <= own.1 && (other.seconds, other.certified.max) != own
        };
        rungs[index].is_best = own.1.is_finite() && !rungs.iter().any(beats);
    }
    tell(steps - 3);
    let limit = rungs.last().map(|rung| limit(&sized(&rung.set)?, request, &regions, monitor)).transpose()?;
    let attempts = asked.tolerances.iter().map(|tolerance| {
        let allowed = allows(*tolerance)?;
        let rung = fastest(&rungs, allowed);
        let limit = if rung.is_none() { limit.clone() } else { None };
        Some(Attempt { tolerance: *tolerance, allowed, rung, limit })
    });
    let attempts = attempts.collect::<Option<_>>().ok_or(TargetError::NothingDisplayed)?;
    tell(steps - 2);
    let savings = savings(&graph, request, monitor)?;
    tell(steps - 1);
    let scalings = scalings(&graph, request, &sized, monitor)?;
    Ok(Ladder {
        output: request.outputs[0].to_owned(),
        frame: request.frame,
        format: graph.format(),
        threads: threads(request.settings.threads),
        attempts,
        savings,
        scalings,
        rungs,
    })
}

/// Returns the fastest settings for a plan whose certified error is allowed.
fn fastest(rungs: &[Rung], allowed: f64) -> Option<usize> {
    let meets = rungs.iter().enumerate().filter(|(_, rung)| rung.is_method && rung.certified.max <= allowed);
    meets.min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds)).map(|(index, _)| index)
}

/// Monitor that forwards everything but progress.
struct WithoutProgress<'a>(&'a dyn Monitor);

impl Monitor for WithoutProgress<'_> {
    fn preparing(&self, node: &str) {
        self.0.preparing(node);
    }

    fn progress(&self, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Monitor of the first of several equal steps.
struct FirstSteps<'a> {
    monitor: &'a dyn Monitor,
    steps: usize,
}

impl Monitor for FirstSteps<'_> {
    fn preparing(&self, node: &str) {
        self.monitor.preparing(node);
    }

    fn progress(&self, done: usize, total: usize) {
        self.monitor.progress(done, total * self.steps);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}

fn threads(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// Returns all settings, coarsest first, and whether a plan may choose them. Finer and coarser meshes may not be
/// chosen, because they change which samples are ambiguous.
fn settings(graph: &CheckedGraph, request: &Request<'_>) -> Vec<(Vec<String>, bool)> {
    let methods = knobs::find(graph, request.outputs, request.frame);
    let at = |level: usize| -> Vec<String> {
        methods.iter().map(|knob| knob.assignment(level.min(knob.words.len() - 1))).collect()
    };
    let numbers = knobs::numbers(graph, request.outputs, request.frame, |knob| knob.accuracy);
    let most = methods.iter().map(|knob| knob.words.len()).max().unwrap_or(1);
    let mut all = Vec::new();
    let scaled = |factor: f64| -> Vec<String> {
        at(0).into_iter().chain(numbers.iter().map(|number| number.assignment(factor))).collect()
    };
    let (coarser, finer): (Vec<f64>, Vec<f64>) = FINENESS.into_iter().partition(|factor| *factor < 1.0);
    all.extend(coarser.into_iter().filter(|_| !numbers.is_empty()).map(|factor| (scaled(factor), false)));
    all.push((at(0), true));
    all.extend(finer.into_iter().filter(|_| !numbers.is_empty()).map(|factor| (scaled(factor), false)));
    all.extend((1..most).map(|level| (at(level), true)));
    all
}

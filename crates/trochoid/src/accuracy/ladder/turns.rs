//! Times of rendering, taken in turns.

use super::super::predict;
use super::budget::{Budget, Phase};
use super::{Request, TargetError};
use trochoid_engine::{Buffers, Cache, EvalError, Frame, Monitor, Plan};
use trochoid_graph::CheckedGraph;

/// Most runs of each of the settings.
const RUNS: usize = 5;

/// Ratio of two times that is beyond any spread, if one of them is that of a single run.
const SINGLE: f64 = 2.0;

/// Seconds of several runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// In ascending order.
    seconds: Vec<f64>,
}

impl FromIterator<f64> for Times {
    fn from_iter<T: IntoIterator<Item = f64>>(seconds: T) -> Self {
        let mut times = Self::default();
        seconds.into_iter().for_each(|seconds| times.add(seconds));
        times
    }
}

impl Times {
    fn add(&mut self, seconds: f64) {
        let place = self.seconds.partition_point(|known| *known < seconds);
        self.seconds.insert(place, seconds);
    }

    /// Returns the number of runs.
    pub fn runs(&self) -> usize {
        self.seconds.len()
    }

    /// Returns the median.
    pub fn median(&self) -> f64 {
        self.seconds.get(self.seconds.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// Returns the shortest and the longest time.
    pub fn range(&self) -> [f64; 2] {
        [self.seconds.first(), self.seconds.last()].map(|end| end.copied().unwrap_or(f64::NAN))
    }

    /// Returns whether all runs were shorter than all runs of the other settings; than half of them if there is a single
    /// run of either, which shows no spread.
    pub fn is_below(&self, other: &Self) -> bool {
        let apart = if self.runs().min(other.runs()) > 1 { 1.0 } else { SINGLE };
        apart * self.range()[1] < other.range()[0]
    }
}

/// Pictures and times of some settings.
pub(super) struct Rendered {
    pub(super) frame: Frame,
    pub(super) times: Times,
    /// Predicted seconds; `None` if there was no time for that.
    pub(super) predicted: Option<f64>,
}

/// Renders with all settings, one after the other, again and again. In the result, `None` stands for settings that could
/// not be rendered even once in the time.
pub(super) fn render(
    graphs: &[CheckedGraph],
    request: &Request<'_>,
    budget: &Budget<'_>,
) -> Result<Vec<Option<Rendered>>, TargetError> {
    let mut all: Vec<Option<Rendered>> = Vec::new();
    for (index, graph) in graphs.iter().enumerate() {
        // The first picture is made in any case.
        let deadline = if index == 0 { budget.unlimited() } else { budget.until(Phase::Renders) };
        let frame = match once(graph, request, &deadline) {
            Err(TargetError::Evaluate(EvalError::Cancelled)) if deadline.is_over() => None,
            frame => Some(frame?),
        };
        all.push(frame.map(|frame| {
            let times = Times::from_iter([seconds(&frame)]);
            Rendered { frame, times, predicted: None }
        }));
        budget.step();
    }
    for turn in 1..RUNS {
        for (graph, rendered) in graphs.iter().zip(&mut all) {
            let Some(rendered) = rendered else { continue };
            let deadline = budget.until(Phase::Renders);
            match once(graph, request, &deadline) {
                Err(TargetError::Evaluate(EvalError::Cancelled)) if deadline.is_over() => return Ok(all),
                frame => rendered.times.add(seconds(&frame?)),
            }
            if turn == 1 {
                let (outputs, settings) = (request.outputs, request.settings);
                match predict(graph, outputs, request.frame, settings, &deadline) {
                    Err(TargetError::Evaluate(EvalError::Cancelled)) if deadline.is_over() => return Ok(all),
                    predicted => rendered.predicted = Some(predicted?),
                }
            }
            budget.step();
        }
    }
    Ok(all)
}

/// Number of steps of rendering with some settings.
pub(super) fn steps(settings: usize) -> usize {
    RUNS * settings
}

/// Evaluates a frame without a cache.
fn once(graph: &CheckedGraph, request: &Request<'_>, monitor: &dyn Monitor) -> Result<Frame, TargetError> {
    let plan = Plan::new(graph, request.outputs, request.frame, &[], request.settings)?;
    Ok(plan.evaluate(&Buffers::new(), &mut Cache::new(), monitor)?)
}

fn seconds(frame: &Frame) -> f64 {
    frame.seconds.prepare + frame.seconds.hull + frame.seconds.tiles
}

/// Evaluates a frame a few times without a cache; returns the median of the seconds.
pub(super) fn timed(graph: &CheckedGraph, request: &Request<'_>, monitor: &dyn Monitor) -> Result<f64, TargetError> {
    let times: Result<Times, TargetError> = (0..3).map(|_| Ok(seconds(&once(graph, request, monitor)?))).collect();
    Ok(times?.median())
}

/// Returns which settings no others beat: others beat them if they are certified to a smaller error, and these are not
/// faster beyond the spread of both times; or to the same error, and these are slower beyond the spread.
pub(super) fn unbeaten(all: &[(&Times, Option<f64>)]) -> Vec<bool> {
    let is_best = |(times, error): &(&Times, Option<f64>)| {
        let Some(error) = error else { return false };
        let beats = |(others, other): &(&Times, Option<f64>)| match other {
            Some(other) if other < error => !times.is_below(others),
            Some(other) => other == error && others.is_below(times),
            None => false,
        };
        !all.iter().any(beats)
    };
    all.iter().map(is_best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_sorted() {
        let times = Times::from_iter([3.0, 1.0, 2.0]);
        assert_eq!((times.median(), times.range(), times.runs()), (2.0, [1.0, 3.0], 3));
        assert!(Times::default().median().is_nan());
    }

    #[test]
    fn only_what_is_faster_beyond_the_spread_makes_up_for_a_larger_error() {
        let best = |all: &[(&[f64], f64)]| {
            let times: Vec<Times> = all.iter().map(|(seconds, _)| seconds.iter().copied().collect()).collect();
            let errors = all.iter().map(|(_, error)| Some(*error).filter(|error| error.is_finite()));
            unbeaten(&times.iter().zip(errors).collect::<Vec<_>>())
        };
        // Clearly faster and worse, slower and better: both have their use.
        assert_eq!(best(&[(&[1.0, 1.2], 0.5), (&[2.0, 2.2], 0.1)]), [true, true]);
        // 1.64 s ± 1.89 is no faster than 1.7 s.
        assert_eq!(best(&[(&[0.7, 1.64, 2.6], 0.5), (&[1.6, 1.7], 0.1)]), [false, true]);
        // As good and not slower beyond the spread: as good as one another. Slower beyond it: beaten.
        assert_eq!(best(&[(&[1.0, 1.1], 0.1), (&[1.05, 1.2], 0.1), (&[1.3, 1.4], 0.1)]), [true, true, false]);
        // Single runs show no spread: they decide only if one takes twice as long.
        assert_eq!(best(&[(&[1.0], 0.5), (&[1.9], 0.1)]), [false, true]);
        assert_eq!(best(&[(&[1.0], 0.5), (&[2.1], 0.1)]), [true, true]);
        assert_eq!(best(&[(&[1.0, 1.2], 0.5), (&[2.1], 0.1)]), [false, true]);
        assert_eq!(best(&[(&[], 0.5), (&[2.1], 0.1)]), [false, true], "nothing is known of the time");
        assert_eq!(best(&[(&[1.0, 1.0], f64::NAN), (&[2.0, 2.0], 0.1)]), [false, true], "nothing is certified");
    }
}

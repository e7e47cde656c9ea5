//! What f32 loses of a sea after numbers of steps: the code that makes pictures beside a run in f64.

use super::reference::Run;
use super::{ToonSea, TrailFields};

/// The error of a sea's heights after a number of steps from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepError {
    /// Number of steps.
    pub steps: u64,
    /// Largest difference of a height from the f64 run, in meters.
    pub error: f64,
    /// How far rounding may have carried the f64 run itself, in meters.
    pub doubt: f64,
    /// Largest height of the f64 run at this step or at one of those before that were looked at, in meters.
    pub height: f64,
}

impl ToonSea {
    /// Measures the errors after numbers of steps, in increasing order; `None` soon after `stop` says that they are no
    /// longer needed.
    pub fn step_errors(&self, steps: &[u64], stop: &dyn Fn() -> bool) -> Option<Vec<StepError>> {
        let mut simulation = self.simulate(TrailFields::default());
        let mut run = Run::new(self, true, TrailFields::default());
        let mut height = 0.0_f64;
        let measure = |&steps: &u64| {
            let time = self.time_of(steps);
            if !run.reach(time, stop) || !simulation.reach(time, stop) {
                return None;
            }
            let exact = run.at(time);
            height = exact.height.iter().fold(height, |most, height| most.max(height.abs()));
            let found = simulation.at(time).height.iter().zip(&exact.height);
            let error = found.fold(0.0_f64, |most, (found, exact)| most.max((f64::from(*found) - exact).abs()));
            Some(StepError { steps, error, doubt: exact.doubt.height, height })
        };
        steps.iter().map(measure).collect()
    }
}

//! The definition of a toon sea in f64: every cell, every burst, every step, every mode.
//!
//! [`frame`] is that in plain loops (`plain`). [`Run`] finds the same numbers in vectors (`rows`, `cells`), without the
//! cells that a burst cannot reach.

mod advance;
mod basis;
mod bursts;
mod cells;
mod doubt;
mod heights;
mod plain;
mod roundings;
mod rows;
mod trails;

pub(crate) use advance::{Advance, mean};
pub use doubt::Doubt;

use super::{ToonSea, TrailFields};
use heights::Heights;
use trails::Trails;

/// Number of fields of drift lines.
const DRIFTS: usize = 5;

/// Largest relative error of a rounding in f64.
const ROUNDING: f64 = f64::EPSILON / 2.0;

/// All fields of a sea at one time, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Heights, in meters.
    pub height: Vec<f64>,
    /// The rift; empty if not wanted.
    pub rift: Vec<f64>,
    /// Weight of the drift coordinates, and its products with cosine and sine of the angle along the path and of the
    /// angle across; empty if not wanted.
    pub drift: [Vec<f64>; 5],
    /// How far rounding may have carried the fields from the definition.
    pub doubt: Doubt,
}

/// Returns the fields at a time, from rest, without any jump, by plain loops.
///
/// Costs cells × bursts for each step, and cells × (columns + rows) if steps are not those of the recurrence.
pub fn frame(sea: &ToonSea, time: f64, wanted: TrailFields) -> Reference {
    let mut run = Run { is_plain: true, ..Run::new(sea, true, wanted) };
    run.reach(time, &|| false);
    run.at(time)
}

/// A sea that is stepped through time in f64, with the numbers of [`frame`], but faster. Going back in time starts over.
#[derive(Clone, Debug)]
pub struct Run {
    sea: ToonSea,
    wanted: TrailFields,
    is_plain: bool,
    step: u64,
    heights: Option<Heights>,
    trails: Trails,
}

impl Run {
    /// Makes a sea at rest; `heights` and `wanted` tell which fields are stepped.
    pub fn new(sea: &ToonSea, heights: bool, wanted: TrailFields) -> Self {
        Self {
            sea: sea.with_lengths(wanted),
            wanted,
            is_plain: false,
            step: 0,
            heights: heights.then(|| Heights::new(sea)),
            trails: Trails::new(sea, wanted),
        }
    }

    /// Takes the steps to a time in seconds, unless told to stop between two of them: then it returns false, and
    /// continues from there at the next call.
    pub fn reach(&mut self, time: f64, stop: &dyn Fn() -> bool) -> bool {
        let (last, _) = self.sea.step_at(time);
        if last < self.step {
            *self = Self { is_plain: self.is_plain, ..Self::new(&self.sea, self.heights.is_some(), self.wanted) };
        }
        let seconds = 1.0 / self.sea.motion.rate();
        let mut times = Vec::new();
        while self.step < last {
            if stop() {
                return false;
            }
            let next = last.min(self.step + self.at_once());
            times.clear();
            times.extend((self.step + 1..=next).map(|step| self.sea.time_of(step)));
            if let Some(heights) = &mut self.heights {
                times.iter().for_each(|&time| heights.step(&self.sea, time, self.is_plain));
            }
            self.trails.pass(&self.sea, &times, seconds, self.is_plain);
            self.step = next;
        }
        true
    }

    /// Returns the number of steps to take before asking whether to stop.
    fn at_once(&self) -> u64 {
        if self.heights.is_some() { 1 } else { (1 << 15) / (self.sea.bursts.len() as u64).clamp(1 << 10, 1 << 15) }
    }

    /// Returns the fields at a time in seconds that has been reached, and not surpassed by a step.
    pub fn at(&self, time: f64) -> Reference {
        let (_, part) = self.sea.step_at(time);
        let passed = (part > 0.0).then(|| {
            let mut trails = self.trails.clone();
            trails.pass(&self.sea, &[time], part, self.is_plain);
            trails
        });
        let trails = passed.as_ref().unwrap_or(&self.trails);
        let mut doubt = self.trail_doubt(trails);
        let mut height = Vec::new();
        if let Some(heights) = &self.heights {
            (height, doubt.height) = heights.at(&self.sea, self.step, time, part, self.is_plain);
        }
        Reference { height, rift: trails.rift.clone(), drift: trails.drifts(&self.sea), doubt }
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        self.heights.as_ref().map_or(0, Heights::bytes) + self.trails.bytes()
    }
}

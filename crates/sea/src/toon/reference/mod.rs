//! The definition of a toon sea in f64 and plain loops: every cell, every burst, every step, every mode.

mod advance;
mod basis;
mod bursts;
mod doubt;

pub(crate) use advance::{Advance, mean};
pub use doubt::Doubt;

use rayon::prelude::*;

use super::propagator::Transfer;
use super::{Mixing, ToonSea, TrailFields};
use advance::{Modes, accelerate, recurrence};
use bursts::{ActiveBurst, Row};
use doubt::{CellPeaks, ModePeaks};

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

/// Returns the fields at a time, from rest, without any jump.
///
/// Costs cells × bursts for each step, and cells × (columns + rows) if steps are not those of the recurrence.
pub fn frame(sea: &ToonSea, time: f64, wanted: TrailFields) -> Reference {
    let mut run = Run::new(sea, true, wanted);
    run.reach(time, &|| false);
    run.at(time)
}

/// A sea that is stepped through time in f64. Going back in time starts over.
#[derive(Clone, Debug)]
pub struct Run {
    sea: ToonSea,
    wanted: TrailFields,
    step: u64,
    heights: Option<Heights>,
    rift: Vec<f64>,
    drift: Vec<[f64; 5]>,
    /// Largest absolute values of rift and drift so far.
    trail_peaks: [f64; 2],
}

/// Heights and velocities.
#[derive(Clone, Debug)]
struct Heights {
    method: Method,
    a: Vec<f64>,
    b: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Method {
    /// The state is in cells.
    Cells(Mixing, CellPeaks),
    /// The state is in modes.
    Modes(Box<Modes>, ModePeaks),
}

impl Run {
    /// Makes a sea at rest; `heights` and `wanted` tell which fields are stepped.
    pub fn new(sea: &ToonSea, heights: bool, wanted: TrailFields) -> Self {
        let cells = sea.basin.cells();
        let method = || match recurrence(&sea.motion, 1.0 / sea.motion.rate()) {
            Some(mixing) => Method::Cells(mixing, CellPeaks::default()),
            None => {
                let modes = Modes::new(&sea.motion, &sea.basin, 1.0 / sea.motion.rate());
                Method::Modes(Box::new(modes), ModePeaks::new(cells))
            }
        };
        Self {
            sea: sea.with_lengths(wanted),
            wanted,
            step: 0,
            heights: heights.then(|| Heights { method: method(), a: vec![0.0; cells], b: vec![0.0; cells] }),
            rift: vec![0.0; if wanted.rift { cells } else { 0 }],
            drift: vec![[0.0; 5]; if wanted.drift { cells } else { 0 }],
            trail_peaks: [0.0; 2],
        }
    }

    /// Takes the steps to a time in seconds, unless told to stop between two of them: then it returns false, and
    /// continues from there at the next call.
    pub fn reach(&mut self, time: f64, stop: &dyn Fn() -> bool) -> bool {
        let (last, _) = self.sea.step_at(time);
        if last < self.step {
            *self = Self::new(&self.sea, self.heights.is_some(), self.wanted);
        }
        while self.step < last {
            if stop() {
                return false;
            }
            self.step += 1;
            let bursts = ActiveBurst::all(&self.sea, self.sea.time_of(self.step));
            if let Some(heights) = &mut self.heights {
                heights.step(&self.sea, &force(&self.sea, &bursts));
            }
            let seconds = 1.0 / self.sea.motion.rate();
            pass(&self.sea, &bursts, seconds, &mut self.rift, &mut self.drift);
            self.trail_peaks = raised(self.trail_peaks, &self.rift, &self.drift);
        }
        true
    }

    /// Returns the fields at a time in seconds that has been reached, and not surpassed by a step.
    pub fn at(&self, time: f64) -> Reference {
        let (_, part) = self.sea.step_at(time);
        let (mut rift, mut drift) = (self.rift.clone(), self.drift.clone());
        let bursts = if part > 0.0 { ActiveBurst::all(&self.sea, time) } else { Vec::new() };
        if part > 0.0 {
            pass(&self.sea, &bursts, part, &mut rift, &mut drift);
        }
        let mut doubt = self.trail_doubt(raised(self.trail_peaks, &rift, &drift));
        let mut height = Vec::new();
        if let Some(heights) = &self.heights {
            let rest = (part > 0.0).then(|| (Modes::new(&self.sea.motion, &self.sea.basin, part), part));
            let force = rest.as_ref().map(|_| force(&self.sea, &bursts));
            (height, doubt.height) = heights.at(&self.sea, self.step, rest.as_ref(), force.as_deref());
        }
        let drift = std::array::from_fn(|index| drift.iter().map(|values| values[index]).collect());
        Reference { height, rift, drift, doubt }
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        let heights = self.heights.as_ref().map_or(0, |heights| match &heights.method {
            Method::Cells(..) => 2 * heights.a.len(),
            Method::Modes(modes, _) => 5 * heights.a.len() + modes.transfers.len() * size_of::<Transfer>() / 8,
        });
        (heights + self.rift.len() + 5 * self.drift.len()) * size_of::<f64>()
    }
}

/// Returns the largest absolute values of rift and drift, given the largest so far.
fn raised(peaks: [f64; 2], rift: &[f64], drift: &[[f64; 5]]) -> [f64; 2] {
    let most = |peak: f64, values: &[f64]| values.iter().fold(peak, |most, value| most.max(value.abs()));
    [most(peaks[0], rift), most(peaks[1], drift.as_flattened())]
}

/// Returns the force of bursts on all cells.
fn force(sea: &ToonSea, bursts: &[ActiveBurst<'_>]) -> Vec<f64> {
    let mut force = vec![0.0; sea.basin.cells()];
    let rows = force.par_chunks_mut(sea.basin.columns).enumerate();
    rows.for_each(|(row, out)| Row::new(sea, bursts, row).force(out));
    force
}

/// Lets seconds pass for trails, which may be empty, under bursts.
fn pass(sea: &ToonSea, bursts: &[ActiveBurst<'_>], seconds: f64, rift: &mut [f64], drift: &mut [[f64; 5]]) {
    let columns = sea.basin.columns;
    let rows = rift.par_chunks_mut(columns).enumerate();
    rows.for_each(|(row, values)| Row::new(sea, bursts, row).rift(seconds, values));
    let rows = drift.par_chunks_mut(columns).enumerate();
    rows.for_each(|(row, values)| Row::new(sea, bursts, row).drift(seconds, values));
}

impl Heights {
    fn step(&mut self, sea: &ToonSea, force: &[f64]) {
        let Self { method, a, b } = self;
        match method {
            Method::Cells(mixing, peaks) => {
                let steepest = accelerate(*mixing, &sea.basin, force, a, b);
                a.par_iter_mut().zip(&*b).for_each(|(height, velocity)| *height += *velocity);
                peaks.raise(steepest, force, a, b);
            }
            Method::Modes(modes, peaks) => {
                let coefficients = modes.basis.forward(force);
                modes.step(&coefficients, a, b);
                peaks.raise(force, &coefficients, a, b);
            }
        }
    }

    /// Returns the heights, and how far rounding may have carried them, after a number of steps and a part of a step,
    /// with its seconds and its force.
    fn at(&self, sea: &ToonSea, steps: u64, rest: Option<&(Modes, f64)>, force: Option<&[f64]>) -> (Vec<f64>, f64) {
        let Self { method, a, b } = self;
        let basis = match (method, rest) {
            (Method::Cells(_, peaks), None) => return (a.clone(), peaks.doubt(sea, steps, None)),
            (Method::Modes(modes, _), None) => &modes.basis,
            (_, Some((modes, _))) => &modes.basis,
        };
        let is_cells = matches!(method, Method::Cells(..));
        let (mut a, mut b) = if is_cells { (basis.forward(a), basis.forward(b)) } else { (a.clone(), b.clone()) };
        let mut doubt = match method {
            Method::Cells(_, peaks) => peaks.doubt(sea, steps, rest.map(|(modes, _)| modes)),
            Method::Modes(modes, peaks) => peaks.doubt(sea, steps, modes, rest.map(|(modes, _)| modes)),
        };
        if let (Some((modes, seconds)), Some(force)) = (rest, force) {
            let coefficients = modes.basis.forward(force);
            doubt += doubt::of_part(sea, modes, *seconds, [&a, &b, &coefficients], is_cells);
            modes.step(&coefficients, &mut a, &mut b);
        }
        doubt += basis.rounding() * doubt::norm(&a);
        (basis.backward(&a), doubt)
    }
}

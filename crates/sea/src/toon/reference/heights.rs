//! Heights and velocities, in cells or in modes.

use fearless_simd::Level;
use rayon::prelude::*;

use super::advance::{Modes, accelerate, recurrence};
use super::bursts::ActiveBurst;
use super::doubt::{self, CellPeaks, ModePeaks, Part, largest};
use super::rows::{Step, Sums};
use super::{cells, plain, roundings};
use crate::toon::propagator::Transfer;
use crate::toon::{Mixing, ToonSea};

/// Heights and velocities.
#[derive(Clone, Debug)]
pub(super) struct Heights {
    method: Method,
    a: Vec<f64>,
    b: Vec<f64>,
    /// The force of the last step, kept to reuse its memory.
    force: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Method {
    /// The state is in cells.
    Cells(Mixing, CellPeaks),
    /// The state is in modes.
    Modes(Box<Modes>, ModePeaks),
}

/// Returns the force of bursts on all cells, by plain loops, and how far rounding may have carried it.
fn plain_force(sea: &ToonSea, time: f64) -> (Vec<f64>, f64) {
    let bursts = ActiveBurst::all(sea, time);
    let mut force = vec![0.0; sea.basin.cells()];
    let rows = force.par_chunks_mut(sea.basin.columns).enumerate();
    rows.for_each(|(row, out)| plain::Row { sea, bursts: &bursts, row }.force(out));
    (force, roundings::force(sea, bursts.iter()))
}

/// Computes the same in vectors. Returns how far rounding may have carried it.
fn fast_force(sea: &ToonSea, time: f64, force: &mut [f64]) -> f64 {
    let (level, step) = (Level::new(), raising(sea, time));
    let rows = force.par_chunks_mut(sea.basin.columns).enumerate();
    rows.for_each_init(Sums::default, |sums, (row, out)| {
        step.force(level, row, sums, out);
    });
    roundings::force(sea, step.active())
}

fn raising(sea: &ToonSea, time: f64) -> Step<'_> {
    Step::new(sea, time, |burst| burst.raised(sea))
}

impl Heights {
    /// Returns a sea at rest.
    pub(super) fn new(sea: &ToonSea) -> Self {
        let cells = sea.basin.cells();
        let seconds = 1.0 / sea.motion.rate();
        let method = match recurrence(&sea.motion, seconds) {
            Some(mixing) => Method::Cells(mixing, CellPeaks::default()),
            None => {
                let modes = Modes::new(&sea.motion, &sea.basin, seconds);
                Method::Modes(Box::new(modes), ModePeaks::new(cells))
            }
        };
        Self { method, a: vec![0.0; cells], b: vec![0.0; cells], force: vec![0.0; cells] }
    }

    /// Takes the step at a time, by plain loops or in vectors.
    pub(super) fn step(&mut self, sea: &ToonSea, time: f64, is_plain: bool) {
        let Self { method, a, b, force } = self;
        match method {
            Method::Cells(mixing, peaks) if is_plain => {
                let force_off;
                (*force, force_off) = plain_force(sea, time);
                let steepest = accelerate(*mixing, &sea.basin, force, a, b);
                a.par_iter_mut().zip(&*b).for_each(|(height, velocity)| *height += *velocity);
                let [force, height, velocity] = [&*force, a, b].map(|values| largest(values));
                *peaks = peaks.joined(CellPeaks { height, velocity, force, force_off, steepest });
            }
            Method::Cells(mixing, peaks) => {
                let bursts = raising(sea, time);
                let found = cells::step(*mixing, &bursts, &sea.basin, force, a, b);
                *peaks = peaks.joined(CellPeaks { force_off: roundings::force(sea, bursts.active()), ..found });
            }
            Method::Modes(modes, peaks) => {
                let off = if is_plain {
                    let off;
                    (*force, off) = plain_force(sea, time);
                    off
                } else {
                    fast_force(sea, time, force)
                };
                let coefficients = modes.basis.forward(force);
                modes.step(&coefficients, a, b);
                peaks.raise(force, off, &coefficients, [a, b]);
            }
        }
    }

    /// Returns the heights at a time, and how far rounding may have carried them, after a number of steps and a part of a
    /// step in seconds.
    pub(super) fn at(&self, sea: &ToonSea, steps: u64, time: f64, part: f64, is_plain: bool) -> (Vec<f64>, f64) {
        let Self { method, a, b, .. } = self;
        let rest = (part > 0.0).then(|| Modes::new(&sea.motion, &sea.basin, part));
        let basis = match (method, &rest) {
            (Method::Cells(_, peaks), None) => return (a.clone(), peaks.doubt(sea, steps, None)),
            (Method::Modes(modes, _), None) => &modes.basis,
            (_, Some(modes)) => &modes.basis,
        };
        let is_cells = matches!(method, Method::Cells(..));
        let (mut a, mut b) = if is_cells { (basis.forward(a), basis.forward(b)) } else { (a.clone(), b.clone()) };
        let mut doubt = match method {
            Method::Cells(_, peaks) => peaks.doubt(sea, steps, rest.as_ref()),
            Method::Modes(modes, peaks) => peaks.doubt(sea, steps, modes, rest.as_ref()),
        };
        if let Some(modes) = &rest {
            let (force, force_off) = if is_plain {
                plain_force(sea, time)
            } else {
                let mut force = vec![0.0; a.len()];
                let off = fast_force(sea, time, &mut force);
                (force, off)
            };
            let coefficients = modes.basis.forward(&force);
            let state = [&a[..], &b, &coefficients];
            let part = Part { modes, seconds: part, coefficients: state, force_off, is_cells };
            doubt += part.doubt(sea);
            modes.step(&coefficients, &mut a, &mut b);
        }
        doubt += basis.rounding() * doubt::norm(&a);
        (basis.backward(&a), doubt)
    }

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        let numbers = match &self.method {
            Method::Cells(..) => 3 * self.a.len(),
            Method::Modes(modes, _) => 6 * self.a.len() + modes.transfers.len() * size_of::<Transfer>() / 8,
        };
        numbers * size_of::<f64>()
    }
}

//! The drops of the plain f64 loops, found faster.

use super::birth::{Birth, Droplet, Water};
use super::run::{Steps, locked};
use super::{Spray, SprayRun};
use crate::{PreciseSea, Sea, SeaFrame};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Rounding error of a wave in either f64 sum, relative to its size, apart from that of its phase and of the sum.
const FUNCTIONS: f64 = 1e-14;
/// Rounding error of a phase by which the sums may differ, relative to the turns that it is added from.
const TURNS: f64 = 4.0 * f64::EPSILON;

impl SprayRun {
    /// Returns the drops that [`reference::drops`](super::reference::drops) returns, bit for bit, in a fraction of its
    /// time.
    ///
    /// Most cells are decided by the vectorized sum. Where its rounding leaves a doubt, the plain sum decides; births
    /// are computed by it, too.
    pub fn exact_at(&self, time: f64) -> Vec<Droplet> {
        let (spray, level) = (self.spray(), self.level());
        let steps = level.map(|level| self.exact_births(level, time)).unwrap_or_default();
        let born = steps.values().flat_map(|births| births.iter().copied()).chain(spray.thrown(time));
        born.filter_map(|birth| spray.droplet(&birth, level, time)).collect()
    }

    /// Does the same as [`reference::births`](super::reference::births), step by step, and keeps the result.
    fn exact_births(&self, level: f64, time: f64) -> Steps {
        let (spray, sea) = (self.spray(), self.sea());
        // A sea without waves has det J = 1 everywhere.
        if spray.expected() == 0.0 || (sea.waves().is_empty() && spray.threshold <= 1.0) {
            return Steps::new();
        }
        let doubt = doubt(spray, sea);
        let kept = locked(&self.exact).clone();
        let births = |step: i64| births(spray, &sea.at(spray.moment(step)), step, level, doubt);
        let step = |step: i64| (step, kept.get(&step).cloned().unwrap_or_else(|| births(step)));
        let steps: Steps = spray.steps(time).map(step).collect();
        locked(&self.exact).clone_from(&steps);
        steps
    }
}

/// Returns the births of a step, at which the sea is `frame`.
fn births(spray: &Spray, frame: &SeaFrame, step: i64, level: f64, doubt: f64) -> Arc<[Birth]> {
    let mut births = Vec::new();
    let precise = PreciseSea::new(frame);
    for cell in spray.cells().iter() {
        let middle = spray.middle(cell);
        let jacobian = precise.evaluate(middle, spray.cell).sample.jacobian();
        if jacobian - doubt >= spray.threshold {
            continue;
        }
        let mut exact = None;
        spray.candidates(cell, step, |candidate, needed| {
            // A value that is not a number is in doubt, too.
            let is_certain = (jacobian - needed).abs() > doubt;
            let mut folded = || *exact.get_or_insert_with(|| frame.evaluate(middle, spray.cell).jacobian());
            if if is_certain { jacobian < needed } else { folded() < needed } {
                let water = water(frame, candidate.rest(spray), spray.cell, level);
                births.push(spray.birth(&candidate, &water));
            }
        });
    }
    births.into()
}

/// Returns the state of a sea that rests at world y = `level`, by the plain sum.
pub(super) fn water(frame: &SeaFrame, [x, z]: [f64; 2], footprint: f64, level: f64) -> Water {
    let sample = frame.evaluate([x, z], footprint);
    let [dx, dy, dz] = sample.displacement;
    Water { position: [x + dx, level + dy, z + dz], velocity: sample.velocity }
}

/// Returns by how much det J at the middle of any cell may differ between the two sums.
///
/// If no strain exceeds s, and none differs by more than δ, then det J = (1 + xx)(1 + zz) − xz² differs by
/// 2δ(1 + s) + 2δs + 2δ² at most, and its own rounding is below 4 units of the last place of (1 + s)².
fn doubt(spray: &Spray, sea: &Sea) -> f64 {
    let cells = spray.cells();
    let last = [cells.first[0] + cells.columns as i64, cells.first[1] + cells.rows as i64];
    let ends = [cells.first, last].map(|cell| spray.middle(cell));
    let reach: [f64; 2] = std::array::from_fn(|axis| ends[0][axis].abs().max(ends[1][axis].abs()));
    let added = sea.waves().len() as f64 * f64::EPSILON;
    let (mut strain, mut off) = (0.0, 0.0);
    for wave in sea.waves() {
        let turns: f64 = (0..2).map(|axis| (wave.direction[axis] / wave.wavelength).abs() * reach[axis]).sum();
        let size = wave.compression().abs();
        strain += size;
        off += size * (FUNCTIONS + added + TAU * TURNS * (turns + 1.0));
    }
    let off = off + f64::EPSILON;
    4.0 * (off + off * off + 4.0 * f64::EPSILON) * (1.0 + strain) * (1.0 + strain)
}

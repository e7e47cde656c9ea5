//! The drops of the plain f64 loops, found faster.

use super::birth::{Birth, Droplet};
use super::plain_sum::{LANES, PlainSum};
use super::run::{Steps, locked};
use super::{Cells, Spray, SprayRun};
use crate::{FramedSea, Sea, SeaFrame};
use rayon::prelude::*;
use std::sync::Arc;

impl SprayRun {
    /// Returns the drops that [`reference::drops`](super::reference::drops) returns, bit for bit, in a fraction of its
    /// time.
    ///
    /// Most cells are decided by sums over squares of cells. Where their rounding leaves a doubt, the plain sum decides;
    /// births are computed by it, too, eight at a time.
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
        let steps: Steps = spray.steps(time).into_par_iter().map(step).collect();
        locked(&self.exact).clone_from(&steps);
        steps
    }
}

/// Returns the births of a step, at which the sea is `frame`.
fn births(spray: &Spray, frame: &SeaFrame, step: i64, level: f64, doubt: f64) -> Arc<[Birth]> {
    let mut born = Vec::new();
    for (cell, jacobian) in spray.cells().iter().zip(jacobians(spray, frame)) {
        if jacobian - doubt >= spray.threshold {
            continue;
        }
        let mut exact = None;
        spray.candidates(cell, step, |candidate, needed| {
            // A value that is not a number is in doubt, too.
            let is_certain = (jacobian - needed).abs() > doubt;
            let mut folded = || *exact.get_or_insert_with(|| frame.evaluate(spray.middle(cell), spray.cell).jacobian());
            if if is_certain { jacobian < needed } else { folded() < needed } {
                born.push(candidate);
            }
        });
    }
    let sum = PlainSum::new(frame, spray.cell);
    let births = born.chunks(LANES).flat_map(|born| {
        let rests: Vec<[f64; 2]> = born.iter().map(|candidate| candidate.rest(spray)).collect();
        let waters = sum.at(&rests, level);
        born.iter().zip(waters).map(|(candidate, water)| spray.birth(candidate, &water)).collect::<Vec<Birth>>()
    });
    births.collect()
}

/// Most cells along each side of a square that is summed at once.
const SIDE: usize = 64;

/// Returns det J at the middles of all cells, in their order, within [`doubt`].
fn jacobians(spray: &Spray, frame: &SeaFrame) -> Vec<f64> {
    let Cells { first, columns, rows } = spray.cells();
    let mut jacobians = vec![0.0; columns * rows];
    // Rows lie along z, and columns along x.
    let sea = FramedSea::new(frame, [0.0, 0.0], [0.0, 1.0]);
    let starts = |count: usize| (0..count).step_by(SIDE);
    let offsets: Vec<f64> = (0..columns.min(SIDE)).map(|column| -(column as f64) * spray.cell).collect();
    let across = sea.columns(&offsets, 0..sea.waves().len());
    for row in starts(rows) {
        let places = row..(row + SIDE).min(rows);
        let places = places.map(|row| (spray.middle([0, first[1] + row as i64])[1], spray.cell));
        let along = sea.strain_rows(&places.collect::<Vec<_>>());
        let mut strains = vec![[0.0; 3]; offsets.len() * (rows - row).min(SIDE)];
        for column in starts(columns) {
            sea.squares(&along, &across, &[-spray.middle([first[0] + column as i64, 0])[0]], &mut strains);
            for (part, strains) in strains.chunks_exact(offsets.len()).enumerate() {
                let out = &mut jacobians[(row + part) * columns + column..(row + part + 1) * columns];
                for (out, [zz, xz, xx]) in out.iter_mut().zip(strains) {
                    *out = (1.0 + xx) * (1.0 + zz) - xz * xz;
                }
            }
        }
    }
    jacobians
}

/// Returns by how much det J at the middle of any cell may differ between sums over squares and the plain one.
///
/// If no strain exceeds s, and none differs by more than δ, then det J = (1 + xx)(1 + zz) − xz² differs by
/// 2δ(1 + s) + 2δs + 2δ² at most, and its own rounding is below 4 units of the last place of (1 + s)².
fn doubt(spray: &Spray, sea: &Sea) -> f64 {
    let Cells { first, columns, rows } = spray.cells();
    let last = [first[0] + columns as i64, first[1] + rows as i64];
    let [a, b] = [first, last].map(|cell| spray.middle(cell));
    let away: f64 = (0..2).map(|axis| a[axis].abs().max(b[axis].abs()).max(spray.cell)).sum();
    let (framed, (mut strain, mut off)) = (FramedSea::new(&sea.at(0.0), [0.0; 2], [0.0, 1.0]), (0.0, 0.0));
    for wave in framed.waves() {
        let [x, _, z] = wave.amplitudes;
        let size = libm::hypot(x, z) * wave.number;
        strain += size;
        off += size * (framed.rounding() + wave.phase_error(away));
    }
    let off = off + f64::EPSILON;
    4.0 * (off + off * off + 4.0 * f64::EPSILON) * (1.0 + strain) * (1.0 + strain)
}

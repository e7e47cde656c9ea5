//! Births of one step after another, with the sea evaluated on the whole grid at once.

use super::birth::{Birth, Candidate, Water};
use super::{MAX_DROPS, Spray, SprayError};
use crate::{FieldSet, Fields, Grid, GridPlan, Points, Sea, SeaFrame};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Sufficient accuracy of the sea on the grid; cases that it leaves in doubt are decided in f64.
const TOLERANCE: f64 = 1e-5;
/// Factor by which a strain may exceed its method's error before a decision could be wrong.
const DOUBT: f64 = 4.0;

/// Number of cells, and of drops, that a thread takes at a time.
const CHUNK: usize = 512;

/// State for computing births over a sea, kept from step to step.
pub(crate) struct Breeder<'a> {
    spray: &'a Spray,
    sea: &'a Sea,
    level: f64,
    plan: GridPlan,
    fields: Fields,
    /// Largest error of a strain on the grid, without its own rounding.
    error: f64,
}

impl<'a> Breeder<'a> {
    /// Prepares for a spray that has been checked.
    pub(crate) fn new(spray: &'a Spray, sea: &'a Sea, level: f64) -> Self {
        let cells = spray.cells();
        let grid = Grid {
            origin: spray.middle(cells.first),
            step: [spray.cell; 2],
            columns: cells.columns,
            rows: cells.rows,
            footprint: spray.cell,
        };
        let wanted = FieldSet { derivatives: true, ..FieldSet::default() };
        let plan = match GridPlan::new(grid, wanted, sea.waves().len(), TOLERANCE) {
            Ok(plan) => plan,
            Err(error) => unreachable!("a checked spray has a grid: {error}"),
        };
        let square = |wave: &crate::Wave| wave.compression() * wave.compression() / 2.0;
        let rms = libm::sqrt(sea.waves().iter().map(square).sum());
        let error = DOUBT * plan.method().error() * rms;
        Self { spray, sea, level, plan, fields: Fields::default(), error }
    }

    /// Returns the drops born in a step, cell by cell.
    pub(crate) fn step(&mut self, step: i64, stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Birth>, SprayError> {
        let spray = self.spray;
        let frame = self.sea.at(spray.moment(step));
        self.plan.evaluate_unless(&frame, &mut self.fields, stop);
        // After a stop the result is useless.
        if stop() {
            return Err(SprayError::Stopped);
        }
        let cells: Vec<[i64; 2]> = spray.cells().iter().collect();
        let total = AtomicUsize::new(0);
        let chosen: Result<Vec<Vec<Candidate>>, SprayError> = cells
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, cells)| {
                if stop() {
                    return Err(SprayError::Stopped);
                }
                let chosen = self.chosen(&frame, step, chunk * CHUNK, cells);
                // Counted on the way, so that too many drops are never held.
                let before = total.fetch_add(chosen.len(), Ordering::Relaxed);
                if before + chosen.len() > MAX_DROPS { Err(SprayError::Drops) } else { Ok(chosen) }
            })
            .collect();
        let chosen = chosen?.concat();
        // Each drop is the same whichever other drops are in its chunk.
        Ok(chosen.par_chunks(CHUNK).flat_map_iter(|chosen| self.births(&frame, chosen)).collect())
    }

    /// Returns the candidates that are born in some cells; `first` is the index of the first cell.
    fn chosen(&self, frame: &SeaFrame, step: i64, first: usize, cells: &[[i64; 2]]) -> Vec<Candidate> {
        let spray = self.spray;
        let mut chosen = Vec::new();
        for (index, cell) in (first..).zip(cells) {
            let (jacobian, doubt) = self.jacobian(index);
            if jacobian - doubt >= spray.threshold {
                continue;
            }
            let mut exact = None;
            spray.candidates(*cell, step, |candidate, needed| {
                // A value that is not a number is in doubt too.
                let certain = (jacobian - needed).abs() > doubt;
                let born = if certain {
                    jacobian < needed
                } else {
                    *exact.get_or_insert_with(|| frame.evaluate(spray.middle(*cell), spray.cell).jacobian()) < needed
                };
                if born {
                    chosen.push(candidate);
                }
            });
        }
        chosen
    }

    /// Returns det J at a cell's middle, and a bound on its error.
    fn jacobian(&self, index: usize) -> (f64, f64) {
        let [xx, xz, zz] = [0, 1, 2].map(|sum| f64::from(self.fields.strain[sum][index]));
        let most = 1.0 + xx.abs().max(xz.abs()).max(zz.abs());
        let error = self.error + 1e-6 * most;
        ((1.0 + xx) * (1.0 + zz) - xz * xz, error * (4.0 * most + error))
    }

    fn births(&self, frame: &SeaFrame, chosen: &[Candidate]) -> Vec<Birth> {
        let rests: Vec<[f64; 2]> = chosen.iter().map(|candidate| candidate.rest(self.spray)).collect();
        let [x, z]: [Vec<f64>; 2] = [0, 1].map(|axis| rests.iter().map(|rest| rest[axis]).collect());
        let footprint = vec![self.spray.cell; rests.len()];
        let wanted = FieldSet { displacement: true, velocity: true, ..FieldSet::default() };
        let mut fields = Fields::default();
        frame.direct(Points { x: &x, z: &z, footprint: &footprint }, wanted, &mut fields);
        let three = |planes: &[Vec<f32>; 3], index: usize| [0, 1, 2].map(|axis| f64::from(planes[axis][index]));
        chosen
            .iter()
            .enumerate()
            .map(|(index, candidate)| {
                let [dx, dy, dz] = three(&fields.displacement, index);
                let position = [x[index] + dx, self.level + dy, z[index] + dz];
                self.spray.birth(candidate, &Water { position, velocity: three(&fields.velocity, index) })
            })
            .collect()
    }
}

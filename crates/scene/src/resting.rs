//! Surfaces over a resting plane, evaluated by rest point instead of through a camera.

use rayon::prelude::*;
use trochoid_sea::{FieldSet, Fields, Grid, GridError, GridPlan, Sample};

use crate::grid_values::Number;
use crate::{GridSurface, SeaSurface};

/// A surface whose points rest on a plane, with the properties of each point by its rest point.
///
/// `on_grid` and `at` describe the same surface: the first is fast, on a grid and in f32, the second is in f64.
pub trait Resting {
    /// Returns the wanted quantities at every point of a grid, row by row, with an error of at most `tolerance` times
    /// each quantity's root mean square, or as exact as possible. Must not depend on the number of threads. When told
    /// to stop, it ends as soon as it can, and its result is useless.
    ///
    /// # Errors
    /// The grid has too many points, or a number is not finite.
    fn on_grid(
        &self,
        grid: Grid,
        wanted: FieldSet,
        tolerance: f64,
        out: &mut Fields,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), GridError>;

    /// Returns the displaced surface at a rest point (x₀, z₀) under a footprint in meters, in f64.
    fn at(&self, rest: [f64; 2], footprint: f64) -> Sample;
}

impl Resting for SeaSurface {
    fn on_grid(
        &self,
        grid: Grid,
        wanted: FieldSet,
        tolerance: f64,
        out: &mut Fields,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), GridError> {
        GridPlan::new(grid, wanted, self.frame.len(), tolerance)?.evaluate_unless(&self.frame, out, stop);
        Ok(())
    }

    fn at(&self, rest: [f64; 2], footprint: f64) -> Sample {
        self.frame.evaluate(rest, footprint)
    }
}

/// Points only move up and down, whatever the footprint; outside of the surface they stay at rest.
impl<T: Number> Resting for GridSurface<T> {
    fn on_grid(
        &self,
        grid: Grid,
        wanted: FieldSet,
        _tolerance: f64,
        out: &mut Fields,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), GridError> {
        grid.validate()?;
        out.reset(wanted, grid.columns * grid.rows);
        let columns = grid.columns.max(1);
        let at = |row: usize, column: usize| {
            let [column, row] = [column, row].map(|place| place as f64);
            self.at([grid.origin[0] + column * grid.step[0], grid.origin[1] + row * grid.step[1]], grid.footprint)
        };
        let fill = |out: &mut Vec<f32>, value: &(dyn Fn(Sample) -> f64 + Sync)| {
            out.par_chunks_mut(columns).enumerate().filter(|_| !stop()).for_each(|(row, out)| {
                out.iter_mut().enumerate().for_each(|(column, out)| *out = value(at(row, column)) as f32);
            });
        };
        fill(&mut out.displacement[1], &|sample| sample.displacement[1]);
        for (axis, slope) in out.slope.iter_mut().enumerate() {
            fill(slope, &|sample| sample.slope[axis]);
        }
        Ok(())
    }

    fn at(&self, [x, z]: [f64; 2], _footprint: f64) -> Sample {
        let [height, dx, dz] = self.height(x, z).unwrap_or_default();
        Sample { displacement: [0.0, height, 0.0], slope: [dx, dz], ..Sample::default() }
    }
}

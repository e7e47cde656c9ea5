use fearless_simd::{Level, dispatch, prelude::*};
use rayon::prelude::*;

use super::splat::flushed;
use super::{Basin, Boundary, Mixing};

/// Velocities below this count as 0. Heights count as 0 from far larger ones on, so that none is left without a velocity.
const REST: f32 = 1e-36;

/// Number of rows that one task steps.
const ROWS: usize = 32;

/// Heights and their velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// h in meters, row by row.
    pub height: Vec<f32>,
    /// v, the change of h in the last step, in meters.
    pub velocity: Vec<f32>,
}

impl Field {
    /// Returns a field at rest.
    pub fn at_rest(basin: &Basin) -> Self {
        Self { height: vec![0.0; basin.cells()], velocity: vec![0.0; basin.cells()] }
    }

    /// Does one literal step without bursts: h' = c₁(2·Lm(h) − h₋) + c₂·h, see [`accelerate`](Self::accelerate).
    ///
    /// # Panics
    /// The field does not have the basin's size.
    pub fn step(&mut self, mixing: Mixing, basin: &Basin) {
        self.accelerate(mixing, basin);
        let chunks = self.height.par_chunks_mut(basin.columns * ROWS);
        chunks.zip(self.velocity.par_chunks(basin.columns * ROWS)).for_each(|(height, velocity)| {
            for (height, velocity) in height.iter_mut().zip(velocity) {
                *height = moved(*height, *velocity);
            }
        });
    }

    /// Does the first part of a literal step: v' = c₁·(v + ½Σ(neighbor − h)) − (1 − c₁ − c₂)·h, while the heights stay.
    /// Then bursts change the velocities, and h' = h + v' ([`ToonSea::inject`](super::ToonSea::inject)).
    ///
    /// With v = h − h₋, this is h' = c₁(2·Lm(h) − h₋) + c₂·h. That form would lose or gain (fl c₁ + fl c₂ − 1)/(1 − c₁)
    /// of a level sea at each step, and take the rounding of heights for velocities, which persist if c₁ is near 1.
    ///
    /// # Panics
    /// The field does not have the basin's size.
    pub fn accelerate(&mut self, mixing: Mixing, basin: &Basin) {
        let (columns, cells) = (basin.columns, basin.cells());
        assert!(self.height.len() == cells && self.velocity.len() == cells, "the field is of the basin's size");
        let zeros = if basin.boundary == Boundary::Fixed { vec![0.0; columns] } else { Vec::new() };
        let level = Level::new();
        let height = &self.height;
        let row_at = |row: usize| &height[row * columns..(row + 1) * columns];
        self.velocity.par_chunks_mut(columns * ROWS).enumerate().for_each(|(task, out)| {
            dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                for (index, out) in out.chunks_exact_mut(columns).enumerate() {
                    let row = task * ROWS + index;
                    let last = basin.rows - 1;
                    let (up, down) = match basin.boundary {
                        Boundary::Replicate => (row_at(row.saturating_sub(1)), row_at((row + 1).min(last))),
                        Boundary::Periodic => (
                            row_at(if row == 0 { last } else { row - 1 }),
                            row_at(if row == last { 0 } else { row + 1 }),
                        ),
                        Boundary::Fixed => (
                            if row == 0 { &zeros[..] } else { row_at(row - 1) },
                            if row == last { &zeros[..] } else { row_at(row + 1) },
                        ),
                    };
                    step_row(mixing, basin.boundary, row_at(row), up, down, out);
                }
            }));
        });
    }
}

/// Returns h' = h + v'.
#[inline(always)]
pub(crate) fn moved(height: f32, velocity: f32) -> f32 {
    flushed(height + velocity)
}

/// Steps one row: `out` holds v and receives v'.
#[inline(always)]
fn step_row(mixing: Mixing, boundary: Boundary, row: &[f32], up: &[f32], down: &[f32], out: &mut [f32]) {
    let (c1, loss) = (mixing.c1 as f32, mixing.loss() as f32);
    let next = |left: f32, right: f32, up: f32, down: f32, h: f32, v: f32| {
        let bend = 0.5 * (((left - h) + (right - h)) + ((up - h) + (down - h)));
        let next = c1 * (v + bend) - loss * h;
        if next.abs() < REST { 0.0 } else { next }
    };
    let n = row.len();
    let (first, last) = match boundary {
        Boundary::Replicate => (row[0], row[n - 1]),
        Boundary::Periodic => (row[n - 1], row[0]),
        Boundary::Fixed => (0.0, 0.0),
    };
    out[0] = next(first, row[1], up[0], down[0], row[0], out[0]);
    let inner = n - 2;
    let (left, right) = (&row[..inner], &row[2..][..inner]);
    let (h, up_inner, down_inner) = (&row[1..][..inner], &up[1..][..inner], &down[1..][..inner]);
    let out_inner = &mut out[1..][..inner];
    #[allow(clippy::needless_range_loop, reason = "six rows side by side")]
    for i in 0..inner {
        out_inner[i] = next(left[i], right[i], up_inner[i], down_inner[i], h[i], out_inner[i]);
    }
    out[n - 1] = next(row[n - 2], last, up[n - 1], down[n - 1], row[n - 1], out[n - 1]);
}

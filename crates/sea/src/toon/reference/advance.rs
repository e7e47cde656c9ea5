//! The change of a sea over an interval.

use rayon::prelude::*;

use super::basis::Basis;
use crate::toon::propagator::{Transfer, transfer};
use crate::toon::{Basin, Boundary, LITERAL_HZ, Mixing, Motion};

/// The change of heights and velocities over an interval: in cells if it is a literal step, else in modes.
#[derive(Clone, Debug)]
pub(crate) struct Advance {
    basin: Basin,
    method: Method,
}

#[derive(Clone, Debug)]
enum Method {
    Cells(Mixing),
    Modes(Box<Modes>),
}

/// Modes, and their transfers over the interval.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub(super) basis: Basis,
    pub(super) transfers: Vec<Transfer>,
}

impl Modes {
    pub(super) fn new(motion: &Motion, basin: &Basin, seconds: f64) -> Self {
        let basis = Basis::new(basin);
        let of_mode = |mode: usize| transfer(motion, basin.spacing, basis.gap(mode), seconds);
        let transfers = (0..basin.cells()).into_par_iter().map(of_mode).collect();
        Self { basis, transfers }
    }

    /// Advances coefficients over the interval under those of a constant force.
    pub(super) fn step(&self, force: &[f64], a: &mut [f64], b: &mut [f64]) {
        a.par_iter_mut().zip(b).zip(force).zip(&self.transfers).for_each(|(((a, b), f), m)| {
            (*a, *b) = (m[0] * *a + m[1] * *b + m[4] * f, m[2] * *a + m[3] * *b + m[5] * f);
        });
    }
}

/// Returns the coefficients of the recurrence if the motion does a literal step in this time.
pub(super) fn recurrence(motion: &Motion, seconds: f64) -> Option<Mixing> {
    match *motion {
        Motion::Literal(mixing) => Some(mixing),
        Motion::Resampled { mixing, rate } => (rate == LITERAL_HZ && seconds == 1.0 / rate).then_some(mixing),
        Motion::Physical { .. } => None,
    }
}

impl Advance {
    pub(crate) fn new(motion: &Motion, basin: &Basin, seconds: f64) -> Self {
        let method = match recurrence(motion, seconds) {
            Some(mixing) => Method::Cells(mixing),
            None => Method::Modes(Box::new(Modes::new(motion, basin, seconds))),
        };
        Self { basin: *basin, method }
    }

    /// Advances heights and velocities over the interval under a constant force.
    pub(crate) fn step(&self, force: &[f64], height: &mut Vec<f64>, velocity: &mut Vec<f64>) {
        match &self.method {
            Method::Cells(mixing) => {
                accelerate(*mixing, &self.basin, force, height, velocity);
                height.iter_mut().zip(velocity).for_each(|(height, velocity)| *height += *velocity);
            }
            Method::Modes(modes) => {
                let (mut a, mut b) = (modes.basis.forward(height), modes.basis.forward(velocity));
                modes.step(&modes.basis.forward(force), &mut a, &mut b);
                *height = modes.basis.backward(&a);
                *velocity = modes.basis.backward(&b);
            }
        }
    }
}

/// Does the first part of a literal step: v' = c₁·(v + ½Σ(neighbor − h)) − (1 − c₁ − c₂)·h + force. Returns the largest
/// difference between neighbors.
pub(super) fn accelerate(mixing: Mixing, basin: &Basin, force: &[f64], height: &[f64], velocity: &mut [f64]) -> f64 {
    let loss = mixing.loss();
    let rows = velocity.par_chunks_mut(basin.columns).enumerate();
    let steepest = rows.map(|(row, velocity)| {
        let mut steepest = 0.0_f64;
        for (column, velocity) in velocity.iter_mut().enumerate() {
            let cell = row * basin.columns + column;
            let h = height[cell];
            let [left, right, up, down] = neighbors(basin, height, cell).map(|neighbor| neighbor - h);
            steepest = steepest.max(left.abs()).max(right.abs()).max(up.abs()).max(down.abs());
            let bend = ((left + right) + (up + down)) / 2.0;
            *velocity = mixing.c1 * (*velocity + bend) - loss * h + force[cell];
        }
        steepest
    });
    steepest.reduce(|| 0.0, f64::max)
}

/// Returns the four neighbors of a cell.
fn neighbors(basin: &Basin, h: &[f64], cell: usize) -> [f64; 4] {
    let (columns, rows) = (basin.columns, basin.rows);
    let (x, z) = (cell % columns, cell / columns);
    let at = |x: usize, z: usize| h[z * columns + x];
    let (first_x, last_x, first_z, last_z) = (x == 0, x == columns - 1, z == 0, z == rows - 1);
    // Beyond the edge: the edge again, the opposite edge, or water at rest.
    let beyond = |opposite: f64| match basin.boundary {
        Boundary::Replicate => h[cell],
        Boundary::Periodic => opposite,
        Boundary::Fixed => 0.0,
    };
    [
        if first_x { beyond(at(columns - 1, z)) } else { at(x - 1, z) },
        if last_x { beyond(at(0, z)) } else { at(x + 1, z) },
        if first_z { beyond(at(x, rows - 1)) } else { at(x, z - 1) },
        if last_z { beyond(at(x, 0)) } else { at(x, z + 1) },
    ]
}

/// Returns the mean of the four neighbors of a cell.
pub(crate) fn mean(basin: &Basin, h: &[f64], cell: usize) -> f64 {
    neighbors(basin, h, cell).iter().sum::<f64>() / 4.0
}

//! A literal step on all cells, eight at a time: the same numbers as the plain loops.

use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use rayon::prelude::*;

use super::doubt::CellPeaks;
use super::rows::{Step, Sums, load, store};
use crate::kernel64::LANES;
use crate::toon::{Basin, Boundary, Mixing};

/// Takes a literal step under bursts, whose force it stores. Returns the largest values.
pub(super) fn step(
    mixing: Mixing,
    bursts: &Step<'_>,
    basin: &Basin,
    force: &mut [f64],
    height: &mut [f64],
    velocity: &mut [f64],
) -> CellPeaks {
    let (level, columns) = (Level::new(), basin.columns);
    let before = &*height;
    let rows = force.par_chunks_mut(columns).zip(velocity.par_chunks_mut(columns)).enumerate();
    let pushed = rows.map_init(Sums::default, |sums, (row, (force, velocity))| {
        let largest = bursts.force(level, row, sums, force);
        let peaks = dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || accelerate(simd, mixing, basin, row, before, force, velocity)
        ));
        CellPeaks { force: largest, ..peaks }
    });
    let pushed = pushed.reduce(CellPeaks::default, CellPeaks::joined);
    let rows = height.par_chunks_mut(columns).zip(velocity.par_chunks(columns));
    let raised = rows.map(|(height, velocity)| {
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || raise(simd, height, velocity)))
    });
    let raised = raised.reduce(|| 0.0, f64::max);
    CellPeaks { height: raised, ..pushed }
}

/// Adds velocities to heights. Returns the largest height.
#[inline(always)]
fn raise<S: Simd>(simd: S, height: &mut [f64], velocity: &[f64]) -> f64 {
    let mut most = f64x8::splat(simd, 0.0);
    for at in (0..height.len()).step_by(LANES) {
        let raised = load(simd, &height[at..]) + load(simd, &velocity[at..]);
        most = most.max(raised.abs());
        store(raised, &mut height[at..]);
    }
    most.reduce_max()
}

/// Changes the velocities of a row. Returns the largest velocity, and the largest difference between neighbors.
#[inline(always)]
fn accelerate<S: Simd>(
    simd: S,
    mixing: Mixing,
    basin: &Basin,
    row: usize,
    height: &[f64],
    force: &[f64],
    velocity: &mut [f64],
) -> CellPeaks {
    let (columns, last) = (basin.columns, basin.rows - 1);
    let row_at = |row: usize| &height[row * columns..(row + 1) * columns];
    let here = row_at(row);
    // Beyond the edge: the edge again, the opposite edge, or water at rest.
    let beyond = |opposite: usize| match basin.boundary {
        Boundary::Replicate => Some(here),
        Boundary::Periodic => Some(row_at(opposite)),
        Boundary::Fixed => None,
    };
    let up = if row == 0 { beyond(last) } else { Some(row_at(row - 1)) };
    let down = if row == last { beyond(0) } else { Some(row_at(row + 1)) };
    let end = |near: usize, opposite: usize| match basin.boundary {
        Boundary::Replicate => here[near],
        Boundary::Periodic => here[opposite],
        Boundary::Fixed => 0.0,
    };
    let ends = [end(0, columns - 1), end(columns - 1, 0)];
    let loss = mixing.loss();
    let zero = f64x8::splat(simd, 0.0);
    let (mut fastest, mut steepest) = (zero, zero);
    for at in (0..columns).step_by(LANES) {
        let h = load(simd, &here[at..]);
        let mut left = if at > 0 { load(simd, &here[at - 1..]) } else { zero.slide::<7>(h) };
        let mut right = load(simd, &here[at + 1..]);
        // The first and the last cell have neighbors beyond the row; lanes beyond it are 0.
        if at == 0 {
            left[0] = ends[0];
        }
        if at + LANES >= columns {
            right[columns - 1 - at] = ends[1];
        }
        if at + LANES > columns {
            left[columns - at] = 0.0;
        }
        let beside = |row: Option<&[f64]>| row.map_or(zero, |row| load(simd, &row[at..]));
        let differences = [left - h, right - h, beside(up) - h, beside(down) - h];
        for difference in differences {
            steepest = steepest.max(difference.abs());
        }
        let [left, right, up, down] = differences;
        let bend = ((left + right) + (up + down)) / 2.0;
        let next = (load(simd, &velocity[at..]) + bend) * mixing.c1 - h * loss + load(simd, &force[at..]);
        fastest = fastest.max(next.abs());
        store(next, &mut velocity[at..]);
    }
    CellPeaks { velocity: fastest.reduce_max(), steepest: steepest.reduce_max(), ..CellPeaks::default() }
}

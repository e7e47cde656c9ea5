//! Spreads a frequency over a regular grid, and corrects for it.

use std::f64::consts::TAU;

use crate::spread::Kernel;

/// Number of grid cells over which a frequency is spread.
pub(crate) const WIDTH: usize = 8;

/// Number of these cells before the one that contains the frequency.
pub(crate) const BEFORE: usize = WIDTH / 2 - 1;

/// Degree of the polynomials that approximate the kernel, to within 1e-7.
const DEGREE: usize = 12;

pub(crate) fn kernel() -> Kernel {
    Kernel::new(WIDTH, 2.0)
}

/// Spreads frequencies over a grid with at least twice as many cells as there are points.
pub(crate) struct Spreader {
    cells: usize,
    /// Coefficients of each neighbor's weight, by power of the position within a cell, from 0 on.
    weights: [[f32; WIDTH]; DEGREE + 1],
    /// Factor by which the transform of the spread values is multiplied, by point.
    corrections: Vec<f32>,
}

impl Spreader {
    /// Prepares for `count` points; the point at `count`/2 has the phase of the frequencies themselves.
    pub(crate) fn new(count: usize) -> Self {
        let cells = fast_length((2 * count).max(2 * WIDTH));
        let corrections: Vec<f64> = (0..=count / 2).map(|away| 1.0 / kernel().transform(away as f64, cells)).collect();
        let corrections = (0..count).map(|point| corrections[point.abs_diff(count / 2)] as f32).collect();
        Self { cells, weights: polynomials(), corrections }
    }

    /// Returns the number of cells of the grid.
    pub(crate) fn cells(&self) -> usize {
        self.cells
    }

    /// Returns the factors that turn the transform at each point into the sum of waves.
    pub(crate) fn corrections(&self) -> &[f32] {
        &self.corrections
    }

    /// Returns the first of the cells over which a frequency, in turns per point, is spread, counted from [`BEFORE`]
    /// cells before the grid, and the weight of each cell.
    #[inline(always)]
    pub(crate) fn place(&self, turns: f64) -> (usize, [f32; WIDTH]) {
        let at = (turns - turns.floor()) * self.cells as f64;
        let cell = (at as usize).min(self.cells - 1);
        // −1 to 1 from cell to cell.
        let within = (2.0 * (at - cell as f64) - 1.0) as f32;
        let mut weights = self.weights[DEGREE];
        for power in (0..DEGREE).rev() {
            for (weight, coefficient) in weights.iter_mut().zip(&self.weights[power]) {
                *weight = *weight * within + coefficient;
            }
        }
        (cell, weights)
    }
}

/// Returns for every neighbor the polynomial in y, −1 to 1 from cell to cell, that interpolates the kernel at
/// Chebyshev points.
fn polynomials() -> [[f32; WIDTH]; DEGREE + 1] {
    const POINTS: usize = DEGREE + 1;
    let node = |index: usize| libm::cos(TAU / 4.0 * (2 * index + 1) as f64 / POINTS as f64);
    let mut found = [[0.0; WIDTH]; POINTS];
    for neighbor in 0..WIDTH {
        // Neighbor n is n − BEFORE cells after the cell that contains the frequency.
        let value = |y: f64| kernel().value(neighbor as f64 - BEFORE as f64 - (y + 1.0) / 2.0);
        let values: Vec<f64> = (0..POINTS).map(|index| value(node(index))).collect();
        // Chebyshev coefficients, then powers by the recurrence Tₙ₊₁ = 2y·Tₙ − Tₙ₋₁.
        let (mut before, mut current) = ([0.0; POINTS], [0.0; POINTS]);
        before[0] = 1.0;
        current[1] = 1.0;
        let mut powers = [0.0; POINTS];
        for degree in 0..POINTS {
            let angle = |index: usize| libm::cos(TAU / 4.0 * degree as f64 * (2 * index + 1) as f64 / POINTS as f64);
            let sum: f64 = (0..POINTS).map(|index| values[index] * angle(index)).sum();
            let coefficient = sum * if degree == 0 { 1.0 } else { 2.0 } / POINTS as f64;
            for (power, t) in powers.iter_mut().zip(before) {
                *power += coefficient * t;
            }
            let mut next = [0.0; POINTS];
            for power in 0..POINTS {
                let shifted = if power == 0 { 0.0 } else { current[power - 1] };
                next[power] = 2.0 * shifted - before[power];
            }
            (before, current) = (current, next);
        }
        for (row, power) in found.iter_mut().zip(powers) {
            row[neighbor] = power as f32;
        }
    }
    found
}

/// Returns the least length ≥ `length` of the form 2ⁿ or 3·2ⁿ, for which transforms are fast.
pub(crate) fn fast_length(length: usize) -> usize {
    let power = length.next_power_of_two();
    if power / 4 * 3 >= length { power / 4 * 3 } else { power }
}

//! Measures the behavior of a motion on a small grid by powers of its own step. No formula of the spectrum is used,
//! so that [`Forecast`](super::Forecast) can be checked against it.

use super::reference::{Advance, mean};
use super::{Basin, Motion};

/// The f64 step of a motion on a small grid as a matrix, made by stepping every unit state.
///
/// A state consists of the heights and the velocities; one more number carries a constant level force.
#[derive(Clone, Debug)]
pub struct Probe {
    basin: Basin,
    matrix: Matrix,
}

/// Most cells along each side.
const SIDE: usize = 8;
/// The power that gives the spectral radius is 2 to this. ‖Aⁿ‖ grows like ρⁿ, at worst like n·ρⁿ, so that the
/// remaining error of the root is ln 2/n.
const SQUARINGS: u32 = 30;

impl Probe {
    /// Returns a grid like this one, with at most 8 cells along each side; the parity of its sides, which affects its
    /// spectrum, is kept.
    pub fn basin_like(basin: &Basin) -> Basin {
        let side = |cells: usize| if cells > SIDE { SIDE - cells % 2 } else { cells };
        Basin { columns: side(basin.columns), rows: side(basin.rows), ..*basin }
    }

    /// Steps every unit state of [`basin_like`](Self::basin_like) once. The motion may be unstable.
    pub fn new(motion: &Motion, basin: &Basin) -> Self {
        let basin = Self::basin_like(basin);
        let advance = Advance::new(motion, &basin, 1.0 / motion.rate());
        Self::of(basin, |force, height, other| advance.step(force, height, other))
    }

    /// Makes the explicit second-order scheme for the wave equation of a physical motion, to show what an ordinary
    /// solver does with its stiffness; `None` for other motions.
    pub fn explicit(motion: &Motion, basin: &Basin) -> Option<Self> {
        let Motion::Physical { physics, rate } = *motion else { return None };
        let (basin, dt) = (Self::basin_like(basin), 1.0 / rate);
        let square = |value: f64| value * value;
        let (drag, pull, courant) =
            (physics.damping * dt, square(physics.frequency * dt), square(physics.speed * dt / basin.spacing));
        // Here the other half of the state is the heights of the step before.
        Some(Self::of(basin, |force, height, other| {
            let next = |cell: usize| {
                let (h, before) = (height[cell], other[cell]);
                let bend = 4.0 * courant * (mean(&basin, height, cell) - h);
                (2.0 * h - before + drag * before + bend - pull * h + force[cell]) / (1.0 + drag)
            };
            let next = (0..height.len()).map(next).collect();
            *other = std::mem::replace(height, next);
        }))
    }

    fn of(basin: Basin, step: impl Fn(&[f64], &mut Vec<f64>, &mut Vec<f64>)) -> Self {
        let cells = basin.cells();
        let size = 2 * cells + 1;
        let mut matrix = Matrix { size, values: vec![0.0; size * size] };
        for unit in 0..size {
            let state = |from: usize| -> Vec<f64> { (from..from + cells).map(|at| f64::from(at == unit)).collect() };
            let (mut height, mut other) = (state(0), state(cells));
            step(&vec![f64::from(unit == 2 * cells); cells], &mut height, &mut other);
            let last = f64::from(unit == 2 * cells);
            for (row, value) in height.into_iter().chain(other).chain([last]).enumerate() {
                matrix.values[row * size + unit] = value;
            }
        }
        Self { basin, matrix }
    }

    /// Returns the grid that is stepped.
    pub fn basin(&self) -> &Basin {
        &self.basin
    }

    /// Returns the spectral radius by Gelfand's formula, lim ‖Aⁿ‖^(1/n), from the norms of two powers, to about 1e-8.
    pub fn radius(&self) -> f64 {
        let mut power = self.matrix.without_last();
        // A^n is the power times e^scale.
        let (mut scale, mut before) = (0.0, 0.0);
        for squaring in 0..=SQUARINGS {
            let norm = power.norm();
            if norm == 0.0 {
                return 0.0;
            }
            power.values.iter_mut().for_each(|value| *value /= norm);
            scale += libm::log(norm);
            if squaring < SQUARINGS {
                before = scale;
                power = power.times(&power);
                scale *= 2.0;
            }
        }
        // The difference ln‖A²ⁿ‖ − ln‖Aⁿ‖, divided by n.
        libm::exp((scale - before) / f64::from(1u32 << (SQUARINGS - 1)))
    }

    /// Returns ‖A^(2ᵏ)‖ for k = 0…`doublings`: bounded if the motion is, growing like 2ᵏ if a root of modulus 1 is
    /// double.
    pub fn norms(&self, doublings: u32) -> Vec<f64> {
        let mut power = self.matrix.without_last();
        let mut norms = vec![power.norm()];
        for _ in 0..doublings {
            power = power.times(&power);
            norms.push(power.norm());
        }
        norms
    }

    /// Returns the heights after `steps` steps from heights and the other half of the state, under a constant level
    /// force.
    ///
    /// # Panics
    /// The fields do not have the grid's size.
    pub fn heights_after(&self, steps: u64, height: &[f64], other: &[f64], force: f64) -> Vec<f64> {
        let cells = self.basin.cells();
        assert!(height.len() == cells && other.len() == cells, "the fields are of the grid's size");
        let mut state = [height, other, &[force]].concat();
        let (mut power, mut left) = (self.matrix.clone(), steps);
        while left > 0 {
            if left % 2 == 1 {
                state = power.apply(&state);
            }
            left /= 2;
            if left > 0 {
                power = power.times(&power);
            }
        }
        state.truncate(cells);
        state
    }
}

/// A square matrix, row by row.
#[derive(Clone, Debug)]
struct Matrix {
    size: usize,
    values: Vec<f64>,
}

impl Matrix {
    fn without_last(&self) -> Self {
        let size = self.size - 1;
        let values = self.values.chunks_exact(self.size).take(size).flat_map(|row| &row[..size]).copied().collect();
        Self { size, values }
    }

    fn times(&self, other: &Self) -> Self {
        let size = self.size;
        let mut values = vec![0.0; size * size];
        for (out, row) in values.chunks_exact_mut(size).zip(self.values.chunks_exact(size)) {
            for (&factor, other) in row.iter().zip(other.values.chunks_exact(size)) {
                if factor != 0.0 {
                    out.iter_mut().zip(other).for_each(|(out, value)| *out += factor * value);
                }
            }
        }
        Self { size, values }
    }

    fn apply(&self, vector: &[f64]) -> Vec<f64> {
        let row = |row: &[f64]| row.iter().zip(vector).map(|(a, b)| a * b).sum();
        self.values.chunks_exact(self.size).map(row).collect()
    }

    /// Returns √Σ a²; infinite if a power has overflowed.
    fn norm(&self) -> f64 {
        if self.values.iter().any(|value| !value.is_finite()) {
            return f64::INFINITY;
        }
        // Squares of large powers would overflow.
        let largest = self.values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if largest == 0.0 {
            return 0.0;
        }
        largest * libm::sqrt(self.values.iter().map(|value| (value / largest) * (value / largest)).sum())
    }
}

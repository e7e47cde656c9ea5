//! Modes of a basin as matrices.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::ROUNDING;
use crate::toon::{Basin, Boundary};

/// The modes of a basin as matrices: `axes[i][k][x]` is the kth function of axis i at x, with unit norm.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    size: [usize; 2],
    axes: [Vec<Vec<f64>>; 2],
    /// The same by x, then k.
    turned: [Vec<Vec<f64>>; 2],
    gaps: [Vec<f64>; 2],
}

impl Basis {
    pub(super) fn new(basin: &Basin) -> Self {
        let size = [basin.columns, basin.rows];
        let axis = |n: usize| -> Vec<Vec<f64>> {
            // Whole turns are left out, so that angles are small.
            let turn = |part: usize, whole: usize| 2.0 * PI * (part % whole) as f64 / whole as f64;
            let function = |k: usize, x: usize| match basin.boundary {
                Boundary::Replicate => libm::cos(turn(k * (2 * x + 1), 4 * n)),
                Boundary::Fixed => libm::sin(turn((k + 1) * (x + 1), 2 * (n + 1))),
                Boundary::Periodic => {
                    let (sin, cos) = libm::sincos(turn(k * x, n));
                    cos + sin
                }
            };
            let functions = (0..n).map(|k| {
                let values: Vec<f64> = (0..n).map(|x| function(k, x)).collect();
                let norm = libm::sqrt(values.iter().map(|value| value * value).sum());
                values.iter().map(|value| value / norm).collect()
            });
            functions.collect()
        };
        let axes = size.map(axis);
        let turned = axes
            .each_ref()
            .map(|axis| (0..axis.len()).map(|x| axis.iter().map(|function| function[x]).collect()).collect());
        Self { size, axes, turned, gaps: size.map(|n| basin.axis_gaps(n)) }
    }

    /// Returns 1 − λ of a mode.
    pub(super) fn gap(&self, mode: usize) -> f64 {
        (self.gaps[0][mode % self.size[0]] + self.gaps[1][mode / self.size[0]]) / 2.0
    }

    pub(super) fn forward(&self, field: &[f64]) -> Vec<f64> {
        self.apply(field, &self.turned)
    }

    pub(super) fn backward(&self, coefficients: &[f64]) -> Vec<f64> {
        self.apply(coefficients, &self.axes)
    }

    /// Sums along both axes in a fixed order; `matrices` hold, by axis and input, the factors of each output.
    fn apply(&self, values: &[f64], matrices: &[Vec<Vec<f64>>; 2]) -> Vec<f64> {
        let [columns, rows] = self.size;
        let add = |to: &mut [f64], factors: &[f64], factor: f64| {
            to.iter_mut().zip(factors).for_each(|(to, value)| *to += value * factor);
        };
        let mut half = vec![0.0; values.len()];
        half.par_chunks_exact_mut(columns).enumerate().for_each(|(row, half)| {
            for x in 0..columns {
                add(half, &matrices[0][x], values[row * columns + x]);
            }
        });
        let mut full = vec![0.0; values.len()];
        full.par_chunks_exact_mut(columns).enumerate().for_each(|(out, full)| {
            for z in 0..rows {
                add(full, &half[z * columns..][..columns], matrices[1][z][out]);
            }
        });
        full
    }

    /// Returns the largest norm of what rounding does to a transform, relative to the norm of what is transformed.
    ///
    /// Along an axis of n cells a sum of n products, whose factors are off by n/2 + 10 roundings themselves, is off by
    /// at most (2n + 16) roundings of the sum of absolute products, and the matrix of absolute factors has a norm of at
    /// most √n.
    pub(super) fn rounding(&self) -> f64 {
        self.size.iter().map(|&n| (2.0 * n as f64 + 16.0) * libm::sqrt(n as f64)).sum::<f64>() * ROUNDING * 1.01
    }
}

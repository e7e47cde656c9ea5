//! Points of a sea within squares of many cells, from fewer sums than the cells' own.
//!
//! A polynomial of high degree needs fewer points for its area than many of a low degree do: with 32 points a side, a
//! square holds 6 cells a side of 9 points each, which are its values. What the square's polynomial is off, the cells
//! are off in addition.

use super::bernstein::{SIDE, nodes};
use super::footprints::Footprints;
use super::remainder::Remainder;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use std::sync::OnceLock;
use trochoid_sea::{ColumnFactors, FramedSea, RowFactors};

/// Number of cells along each side of a square.
pub const PARTS: usize = 6;
/// Number of points along each side of a square, even: they stand to both sides of its middle.
pub const POINTS: usize = 32;
/// Lebesgue constant of interpolation in as many Chebyshev points: 2/π·ln n + 1.
pub(super) const LEBESGUE: f64 = 3.3;
/// Rounding error of values between the points, relative to the largest one: both sums of 32 products, and the factors.
///
/// A factor is a quotient of a term and a sum of terms, each of which is rounded thrice, and the places are rounded; by
/// Markov's inequality, that moves a value by 2·32² units at most.
pub const ROUNDING: f64 = 2.0 * LEBESGUE * LEBESGUE * 4096.0 * f64::EPSILON;

/// Number of the cells' points along each side of a square.
pub const FINE: usize = PARTS * SIDE;

/// Number of vectors that hold as many values, and some zeros.
const VECTORS: usize = FINE.div_ceil(8);

/// Values along one axis between the points of a square: for each of these points its factors at the cells' points.
type Factors = [[f64; 8 * VECTORS]; POINTS];

fn factors() -> &'static Factors {
    static FACTORS: OnceLock<Factors> = OnceLock::new();
    FACTORS.get_or_init(|| {
        let (own, points) = (nodes::<SIDE>(), nodes::<POINTS>());
        let mut factors = [[0.0; 8 * VECTORS]; POINTS];
        for index in 0..FINE {
            let (part, node) = (index / SIDE, index % SIDE);
            let at = ((2 * part + 1) as f64 - PARTS as f64 + own[node]) / PARTS as f64;
            // The barycentric formula of Lagrange's polynomials in Chebyshev points of the first kind (Trefethen,
            // *Approximation Theory and Approximation Practice*, chapter 5).
            let terms: [f64; POINTS] = std::array::from_fn(|point| {
                let sign = if point % 2 == 0 { 1.0 } else { -1.0 };
                sign * libm::sin(std::f64::consts::PI * (point as f64 + 0.5) / POINTS as f64) / (at - points[point])
            });
            let sum: f64 = terms.iter().sum();
            for (factors, term) in factors.iter_mut().zip(terms) {
                factors[index] = term / sum;
            }
        }
        factors
    })
}

/// Makes the points of cells of squares side by side across the heading, all of one size.
pub(super) struct Squares<'a> {
    waves: &'a FramedSea,
    rows: RowFactors,
    columns: ColumnFactors,
    level: Level,
}

/// Displacements in one square, for each of the cells' points along u and along v: along u, up, and along v.
pub(super) struct Displacements {
    values: Vec<[[f64; FINE]; FINE]>,
    /// What rounding makes of them between the square's points.
    pub(super) rounding: Remainder,
}

impl<'a> Squares<'a> {
    /// Prepares squares of half side `half` around a place ahead of the camera; only the first waves matter.
    pub(super) fn new(waves: &'a FramedSea, footprints: &Footprints, middle: f64, half: f64, left: usize) -> Self {
        let offsets = nodes::<POINTS>().map(|node| half * node);
        let places = offsets.map(|offset| (middle + offset, libm::sqrt(footprints.square(middle + offset))));
        Self {
            waves,
            rows: waves.rows(&places, left),
            columns: waves.columns(&offsets[POINTS / 2..]),
            level: Level::new(),
        }
    }

    /// Returns the displacements in the square around a place across the heading.
    pub(super) fn displacements(&self, middle: f64) -> Displacements {
        let mut points = vec![[0.0; 3]; POINTS * POINTS];
        self.waves.mirrored(&self.rows, &self.columns, middle, &mut points);
        let mut values = vec![[[0.0; FINE]; FINE]; 3];
        let mut rounding = Remainder::default();
        for axis in 0..3 {
            let own: [[f64; POINTS]; POINTS] =
                std::array::from_fn(|row| std::array::from_fn(|column| points[POINTS * row + column][axis]));
            let largest = own.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            rounding.off[axis] = ROUNDING * largest;
            dispatch!(self.level, simd => simd.vectorize(
                #[inline(always)]
                || between(simd, &own, &mut values[axis])
            ));
        }
        Displacements { values, rounding }
    }
}

impl Displacements {
    /// Returns those at the points of a cell, row by row, by its place among the square's.
    #[inline(always)]
    pub(super) fn of_cell(&self, [along, across]: [usize; 2]) -> [[f64; 3]; SIDE * SIDE] {
        let mut points = [[0.0; 3]; SIDE * SIDE];
        for (axis, values) in self.values.iter().enumerate() {
            for (points, values) in points.chunks_exact_mut(SIDE).zip(&values[SIDE * along..]) {
                for (point, value) in points.iter_mut().zip(&values[SIDE * across..]) {
                    point[axis] = *value;
                }
            }
        }
        points
    }
}

/// Interpolates the values at a square's points at those of its cells.
#[inline(always)]
pub(super) fn between<S: Simd>(simd: S, own: &[[f64; POINTS]; POINTS], values: &mut [[f64; FINE]; FINE]) {
    let factors = factors();
    // First along v, for which the points are columns.
    let mut across = [[0.0; 8 * VECTORS]; POINTS];
    for (across, own) in across.iter_mut().zip(own) {
        *across = combined(simd, own, factors);
    }
    for (row, values) in values.iter_mut().enumerate() {
        let mut along = [0.0; POINTS];
        for (along, factors) in along.iter_mut().zip(factors) {
            *along = factors[row];
        }
        values.copy_from_slice(&combined(simd, &along, &across)[..FINE]);
    }
}

/// Returns the sum of some rows times their weights.
#[inline(always)]
fn combined<S: Simd>(simd: S, weights: &[f64; POINTS], rows: &Factors) -> [f64; 8 * VECTORS] {
    let mut total = [f64x8::splat(simd, 0.0); VECTORS];
    for (weight, row) in weights.iter().zip(rows) {
        for (vector, total) in total.iter_mut().enumerate() {
            *total += f64x8::from_slice(simd, &row[8 * vector..][..8]) * *weight;
        }
    }
    let mut sums = [0.0; 8 * VECTORS];
    for (vector, total) in total.iter().enumerate() {
        total.store_slice(&mut sums[8 * vector..][..8]);
    }
    sums
}

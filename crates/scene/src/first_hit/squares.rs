//! Points of a sea within squares of many cells, from fewer sums than the cells' own.
//!
//! A polynomial of high degree needs fewer points for its area than many of a low degree do: with 32 points a side, a
//! square holds 6 cells a side of 9 points each, which are its values. Waves that turn little across the square need only
//! 16 points a side; what these make of the 32 points is added to the sums of the other waves. What the square's
//! polynomial is off, the cells are off in addition.

use super::bernstein::{SIDE, nodes};
use super::footprints::Footprints;
use super::remainder::Remainder;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use std::ops::Range;
use std::sync::OnceLock;
use trochoid_sea::{ColumnFactors, FramedSea, RowFactors};

/// Number of cells along each side of a square.
pub const PARTS: usize = 6;
/// Number of points along each side of a square, even: they stand to both sides of its middle.
pub const POINTS: usize = 32;
/// Lebesgue constant of interpolation in as many Chebyshev points: 2/π·ln n + 1.
pub(super) const LEBESGUE: f64 = 3.3;
/// The same for long waves.
pub const LONG_POINTS: usize = 16;
pub(super) const LONG_LEBESGUE: f64 = 2.8;
/// Rounding error of values between the points, relative to the largest one: both sums of 32 products, and the factors.
///
/// A factor is a quotient of a term and a sum of terms, each of which is rounded thrice, and the places are rounded; by
/// Markov's inequality, that moves a value by 2·32² units at most.
pub const ROUNDING: f64 = 2.0 * LEBESGUE * LEBESGUE * 4096.0 * f64::EPSILON;

/// The same for values between the points for long waves, which are sums of 16 products.
pub const LONG_ROUNDING: f64 = 2.0 * LONG_LEBESGUE * LONG_LEBESGUE * 1024.0 * f64::EPSILON;

/// Number of the cells' points along each side of a square.
pub const FINE: usize = PARTS * SIDE;

/// Number of vectors that hold as many values, and some zeros, and as many as a square's points.
const VECTORS: usize = FINE.div_ceil(8);
const OWN_VECTORS: usize = POINTS.div_ceil(8);

/// Interpolation along one axis: for each of some points, its factors at all places.
type Factors<const FROM: usize, const VECTORS: usize> = [[[f64; 8]; VECTORS]; FROM];

/// Returns the factors of Chebyshev points at some places in −1…1.
///
/// This is the barycentric formula of Lagrange's polynomials in Chebyshev points of the first kind (Trefethen,
/// *Approximation Theory and Approximation Practice*, chapter 5).
fn factors<const FROM: usize, const VECTORS: usize>(places: &[f64]) -> Factors<FROM, VECTORS> {
    let points = nodes::<FROM>();
    let mut factors = [[[0.0; 8]; VECTORS]; FROM];
    for (index, at) in places.iter().enumerate() {
        let terms: [f64; FROM] = std::array::from_fn(|point| {
            let sign = if point % 2 == 0 { 1.0 } else { -1.0 };
            sign * libm::sin(std::f64::consts::PI * (point as f64 + 0.5) / FROM as f64) / (at - points[point])
        });
        let sum: f64 = terms.iter().sum();
        for (factors, term) in factors.iter_mut().zip(terms) {
            factors.as_flattened_mut()[index] = term / sum;
        }
    }
    factors
}

/// Returns the factors of a square's points at those of its cells.
fn at_cells() -> &'static Factors<POINTS, VECTORS> {
    static FACTORS: OnceLock<Factors<POINTS, VECTORS>> = OnceLock::new();
    FACTORS.get_or_init(|| {
        let own = nodes::<SIDE>();
        let place = |index: usize| ((2 * (index / SIDE) + 1) as f64 - PARTS as f64 + own[index % SIDE]) / PARTS as f64;
        factors(&std::array::from_fn::<_, FINE, _>(place))
    })
}

/// Returns the factors of the points for long waves at all points of a square.
fn at_points() -> &'static Factors<LONG_POINTS, OWN_VECTORS> {
    static FACTORS: OnceLock<Factors<LONG_POINTS, OWN_VECTORS>> = OnceLock::new();
    FACTORS.get_or_init(|| factors(&nodes::<POINTS>()))
}

/// Makes the points of cells of squares side by side across the heading, all of one size.
pub(super) struct Squares<'a> {
    waves: &'a FramedSea,
    long: WaveSums<LONG_POINTS>,
    short: WaveSums<POINTS>,
    level: Level,
}

/// Factors of some waves at N points along each side of a square.
struct WaveSums<const N: usize> {
    rows: RowFactors,
    columns: ColumnFactors,
    is_empty: bool,
}

/// Displacements in one square, for each of the cells' points along u and along v: along u, up, and along v.
pub(super) struct Displacements {
    values: Vec<[[f64; FINE]; FINE]>,
    /// What rounding makes of them between the square's points.
    pub(super) rounding: Remainder,
}

impl<const N: usize> WaveSums<N> {
    fn new(waves: &FramedSea, footprints: &Footprints, middle: f64, half: f64, own: Range<usize>) -> Self {
        let offsets = nodes::<N>().map(|node| half * node);
        let places = offsets.map(|offset| (middle + offset, libm::sqrt(footprints.square(middle + offset))));
        Self {
            is_empty: own.is_empty(),
            rows: waves.rows(&places, own.clone()),
            columns: waves.columns(&offsets[N / 2..], own),
        }
    }

    /// Returns the sums at the points of the square around a place across the heading, axis by axis.
    fn at(&self, waves: &FramedSea, middle: f64) -> [[[f64; N]; N]; 3] {
        let mut values = [[[0.0; N]; N]; 3];
        if self.is_empty {
            return values;
        }
        let mut points = vec![[0.0; 3]; N * N];
        waves.mirrored(&self.rows, &self.columns, middle, &mut points);
        for (axis, values) in values.iter_mut().enumerate() {
            for (value, point) in values.as_flattened_mut().iter_mut().zip(&points) {
                *value = point[axis];
            }
        }
        values
    }
}

impl<'a> Squares<'a> {
    /// Prepares squares of half side `half` around a place ahead of the camera, given their remainder.
    pub(super) fn new(
        waves: &'a FramedSea,
        footprints: &Footprints,
        middle: f64,
        half: f64,
        remainder: &Remainder,
    ) -> Self {
        Self {
            waves,
            long: WaveSums::new(waves, footprints, middle, half, 0..remainder.long),
            short: WaveSums::new(waves, footprints, middle, half, remainder.long..remainder.waves),
            level: Level::new(),
        }
    }

    /// Returns the displacements in the square around a place across the heading.
    pub(super) fn displacements(&self, middle: f64) -> Displacements {
        let (long, mut points) = (self.long.at(self.waves, middle), self.short.at(self.waves, middle));
        let mut values = vec![[[0.0; FINE]; FINE]; 3];
        let mut rounding = Remainder::default();
        for axis in 0..3 {
            let (long, own) = (&long[axis], &mut points[axis]);
            if !self.long.is_empty {
                // The points' own polynomial contains that of fewer points, so that only rounding is enlarged.
                rounding.off[axis] = LEBESGUE * LEBESGUE * LONG_ROUNDING * largest(long);
                doubled(self.level, long, own);
            }
            rounding.off[axis] += ROUNDING * largest(own);
            between(self.level, own, &mut values[axis]);
        }
        Displacements { values, rounding }
    }
}

fn largest<const N: usize>(values: &[[f64; N]; N]) -> f64 {
    values.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()))
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
pub(super) fn between(level: Level, own: &[[f64; POINTS]; POINTS], values: &mut [[f64; FINE]; FINE]) {
    dispatch!(level, simd => simd.vectorize(
        #[inline(always)]
        || add_between(simd, own, at_cells(), values)
    ));
}

/// Interpolates the values at the points for long waves at all points of a square.
pub(super) fn doubled(level: Level, long: &[[f64; LONG_POINTS]; LONG_POINTS], values: &mut [[f64; POINTS]; POINTS]) {
    dispatch!(level, simd => simd.vectorize(
        #[inline(always)]
        || add_between(simd, long, at_points(), values)
    ));
}

/// Interpolates the values at some points at others, and adds them to what is there.
#[inline(always)]
fn add_between<S: Simd, const FROM: usize, const TO: usize, const VECTORS: usize>(
    simd: S,
    own: &[[f64; FROM]; FROM],
    factors: &Factors<FROM, VECTORS>,
    values: &mut [[f64; TO]; TO],
) {
    // First along v, for which the points are columns.
    let mut across = [[[0.0; 8]; VECTORS]; FROM];
    for (across, own) in across.iter_mut().zip(own) {
        *across = combined(simd, own, factors);
    }
    for (row, values) in values.iter_mut().enumerate() {
        let mut along = [0.0; FROM];
        for (along, factors) in along.iter_mut().zip(factors) {
            *along = factors[row / 8][row % 8];
        }
        let sums = combined(simd, &along, &across);
        for (value, sum) in values.iter_mut().zip(sums.as_flattened()) {
            *value += sum;
        }
    }
}

/// Returns the sum of some rows times their weights.
#[inline(always)]
fn combined<S: Simd, const FROM: usize, const VECTORS: usize>(
    simd: S,
    weights: &[f64; FROM],
    rows: &Factors<FROM, VECTORS>,
) -> [[f64; 8]; VECTORS] {
    let mut total = [f64x8::splat(simd, 0.0); VECTORS];
    for (weight, row) in weights.iter().zip(rows) {
        for (total, part) in total.iter_mut().zip(row) {
            *total += f64x8::load_array_ref(simd, part) * *weight;
        }
    }
    let mut sums = [[0.0; 8]; VECTORS];
    for (sums, total) in sums.iter_mut().zip(total) {
        total.store_slice(sums);
    }
    sums
}

//! Polynomials of two variables over the unit square in Bézier form.

use fearless_simd::{Simd, f64x8, prelude::*};
use std::sync::OnceLock;

/// Degree in each variable.
pub(super) const DEGREE: usize = 8;
/// Number of coefficients along each side.
pub const SIDE: usize = DEGREE + 1;

/// Coefficients, by the first variable s, then the second variable t. The polynomial lies in their convex hull.
pub type Net = [[f64; SIDE]; SIDE];

/// Returns the Chebyshev points of −1…1, at which polynomials are determined.
pub fn nodes<const N: usize>() -> [f64; N] {
    std::array::from_fn(|index| -libm::cos(std::f64::consts::PI * (index as f64 + 0.5) / N as f64))
}

/// Returns the Bernstein polynomials at a place in 0…1.
pub(super) fn basis(at: f64) -> [f64; SIDE] {
    let mut values = [0.0; SIDE];
    values[0] = 1.0;
    for degree in 1..SIDE {
        for index in (0..=degree).rev() {
            let from = if index > 0 { values[index - 1] * at } else { 0.0 };
            values[index] = values[index] * (1.0 - at) + from;
        }
    }
    values
}

/// Lebesgue constant of interpolation in the [`nodes`]: 2/π·ln n + 1 for n nodes.
pub(super) const LEBESGUE: f64 = 2.4;
/// Rounding error of a value at two nodes, relative to the largest coefficient. Bernstein polynomials are sums of positive
/// products that are rounded three times for each degree, and two sums of nine products follow: 33 units for either side.
/// Nodes are rounded, too, and by Markov's inequality, that moves a value by 2·8² units at most.
const EVALUATION: f64 = 256.0 * f64::EPSILON;

/// A matrix and its transpose.
type Both = [Net; 2];

fn both(matrix: Net) -> Both {
    [matrix, std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]))]
}

/// Returns the values of all Bernstein polynomials at each of the nodes.
fn bases() -> &'static Both {
    static BASES: OnceLock<Both> = OnceLock::new();
    BASES.get_or_init(|| both(nodes::<SIDE>().map(|node| basis(0.5 + 0.5 * node))))
}

/// The coefficients of polynomials by their values at the Chebyshev points.
struct Interpolation {
    matrix: Both,
    off: f64,
}

fn interpolation() -> &'static Interpolation {
    static INTERPOLATION: OnceLock<Interpolation> = OnceLock::new();
    INTERPOLATION.get_or_init(|| {
        let [bases, _] = bases();
        let matrix = inverse(*bases);
        let mut rest = combined(bases, &matrix);
        for (index, row) in rest.iter_mut().enumerate() {
            row[index] -= 1.0;
        }
        let sums = |matrix: &Net| matrix.map(|row| row.iter().map(|value| value.abs()).sum::<f64>());
        let most = |matrix: &Net| sums(matrix).into_iter().fold(0.0, larger);
        let size = most(&matrix);
        let rest = most(&rest) + 10.0 * f64::EPSILON * size;
        let known = 2.0 * rest + rest * rest + 20.0 * f64::EPSILON * size * size;
        Interpolation { matrix: both(matrix), off: LEBESGUE * LEBESGUE * (1.01 * known + EVALUATION) }
    })
}

/// Bounds how far the polynomial of an [`interpolated`] net lies, anywhere in the unit square, from the one that has exactly
/// the given values at the Chebyshev points, relative to the largest coefficient.
///
/// The difference is a polynomial as well, so that its values at these points bound it. Let M be the matrix of the
/// interpolation, B that of the Bernstein polynomials' values, R = BM − 1, and norms the largest row sums of sizes. From
/// values V the net M·V·Mᵀ is made, whose own values (1 + R)·V·(1 + R)ᵀ differ from V by (2|R| + |R|²)·|V| at most. Each
/// coefficient is two sums of nine products, which round by 10 units of |M|²·|V| each, and R itself, by 10 units of |M|.
/// |V| is at most the largest coefficient, up to the same share, because the rows of B are weights.
#[inline(always)]
pub fn off() -> f64 {
    interpolation().off
}

/// Combines the rows of a net by the factors in each row of a matrix.
#[inline(always)]
fn combined(matrix: &Net, net: &Net) -> Net {
    let mut combined = [[0.0; SIDE]; SIDE];
    for (combined, factors) in combined.iter_mut().zip(matrix) {
        for (factor, row) in factors.iter().zip(net) {
            combined.iter_mut().zip(row).for_each(|(sum, value)| *sum += factor * value);
        }
    }
    combined
}

/// Combines the rows of a net by the factors in each row of a matrix, and then its columns.
#[inline(always)]
fn on_both_sides([matrix, transpose]: &Both, net: &Net) -> Net {
    combined(&combined(matrix, net), transpose)
}

/// Returns the coefficients of the polynomial that has these values at the Chebyshev points.
#[inline(always)]
pub fn interpolated(values: &Net) -> Net {
    on_both_sides(&interpolation().matrix, values)
}

/// Inverts a matrix by elimination with pivots.
fn inverse(mut a: Net) -> Net {
    let mut inverse: Net = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for column in 0..SIDE {
        let pivot = (column..SIDE).fold(
            column,
            |best, row| {
                if a[row][column].abs() > a[best][column].abs() { row } else { best }
            },
        );
        a.swap(column, pivot);
        inverse.swap(column, pivot);
        let divisor = a[column][column];
        for matrix in [&mut a, &mut inverse] {
            matrix[column].iter_mut().for_each(|value| *value /= divisor);
        }
        for row in (0..SIDE).filter(|row| *row != column) {
            let factor = a[row][column];
            for matrix in [&mut a, &mut inverse] {
                let from = matrix[column];
                matrix[row].iter_mut().zip(from).for_each(|(value, from)| *value -= factor * from);
            }
        }
    }
    inverse
}

/// Returns the Bernstein polynomials at a place in 0…1, and those of one degree less.
#[inline(always)]
fn bases_at(at: f64) -> ([f64; SIDE], [f64; DEGREE]) {
    let (mut values, mut lower) = ([0.0; SIDE], [0.0; DEGREE]);
    values[0] = 1.0;
    for degree in 1..SIDE {
        if degree == DEGREE {
            lower.copy_from_slice(&values[..DEGREE]);
        }
        for index in (0..=degree).rev() {
            let from = if index > 0 { values[index - 1] * at } else { 0.0 };
            values[index] = values[index] * (1.0 - at) + from;
        }
    }
    (values, lower)
}

/// Returns the Bernstein polynomials at a place in 0…1, and their first and second derivatives.
pub fn bent_bases_at(at: f64) -> [[f64; SIDE]; 3] {
    let mut bases = [[0.0; SIDE]; 3];
    // Those of two degrees less, and what becomes of them.
    let mut values = [0.0; SIDE];
    values[0] = 1.0;
    for degree in 1..SIDE {
        for (order, bases) in bases.iter_mut().enumerate().skip(1) {
            if degree + order == SIDE {
                *bases = values;
            }
        }
        for index in (0..=degree).rev() {
            let from = if index > 0 { values[index - 1] * at } else { 0.0 };
            values[index] = values[index] * (1.0 - at) + from;
        }
    }
    bases[0] = values;
    // A derivative is the degree times the difference of neighbors of one degree less.
    for (order, bases) in bases.iter_mut().enumerate() {
        for step in 0..order {
            let degree = (DEGREE - step) as f64;
            for index in (0..SIDE).rev() {
                let from = if index > 0 { bases[index - 1] } else { 0.0 };
                bases[index] = degree * (from - bases[index]);
            }
        }
    }
    bases
}

/// Returns the values of some nets at a point of the unit square, and their derivatives by s and by t.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "loops over neighbors")]
pub(super) fn evaluate<const N: usize>(nets: &[Net; N], [s, t]: [f64; 2]) -> [(f64, [f64; 2]); N] {
    let ((by_s, lower_s), (by_t, lower_t)) = (bases_at(s), bases_at(t));
    let mut found = [(0.0, [0.0; 2]); N];
    for (net, (value, slopes)) in nets.iter().zip(&mut found) {
        let (mut across, mut along) = ([0.0; SIDE], [0.0; SIDE]);
        for (row, (factor, along)) in net.iter().zip(by_s.into_iter().zip(&mut along)) {
            for column in 0..SIDE {
                across[column] += factor * row[column];
                *along += by_t[column] * row[column];
            }
        }
        *value = along.iter().zip(by_s).map(|(value, factor)| value * factor).sum();
        for i in 0..DEGREE {
            slopes[0] += DEGREE as f64 * (along[i + 1] - along[i]) * lower_s[i];
            slopes[1] += DEGREE as f64 * (across[i + 1] - across[i]) * lower_t[i];
        }
    }
    found
}

/// Divides a net into halves along s or along t: returns the lower one if `takes_low`, otherwise the upper one, and leaves
/// the other one in its place.
#[inline(always)]
pub(super) fn split<S: Simd>(simd: S, net: &mut Net, along_s: bool, takes_low: bool) -> Net {
    // De Casteljau's algorithm leaves the half at which it ends in the place of the whole.
    let mut other = if along_s { lower_along_s(net) } else { lower_along_t(simd, net) };
    if !takes_low {
        std::mem::swap(net, &mut other);
    }
    other
}

/// Returns the lower half along s, and leaves the upper one.
#[inline(always)]
fn lower_along_s(net: &mut Net) -> Net {
    let mut lower = [[0.0; SIDE]; SIDE];
    for (step, lower) in lower.iter_mut().enumerate() {
        *lower = net[0];
        // All rows that are left, as one.
        let all = net.as_flattened_mut();
        for index in 0..SIDE * (DEGREE - step) {
            all[index] = 0.5 * (all[index] + all[index + SIDE]);
        }
    }
    lower
}

/// Returns the lower half along t, and leaves the upper one. Written in vectors, because loops become gathers and
/// scatters of single numbers, which take several times as long.
#[inline(always)]
fn lower_along_t<S: Simd>(simd: S, net: &mut Net) -> Net {
    let places = f64x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let mut lower = [[0.0; SIDE]; SIDE];
    for (row, lower) in net.iter_mut().zip(&mut lower) {
        let last = f64x8::splat(simd, row[DEGREE]);
        let mut line = f64x8::from_slice(simd, &row[..DEGREE]);
        lower[0] = row[0];
        for (step, lower) in lower.iter_mut().enumerate().skip(1) {
            let means = (line + line.slide::<1>(last)) * 0.5;
            // Coefficients of the upper half are ready and stay.
            let changes = simd.simd_lt_f64x8(places, f64x8::splat(simd, (SIDE - step) as f64));
            line = simd.select_f64x8(changes, means, line);
            *lower = line.to_array()[0];
        }
        line.store_slice(&mut row[..DEGREE]);
    }
    lower
}

/// Returns the part of a net over a rectangle of the unit square.
#[inline(always)]
pub fn part(net: &Net, start: [f64; 2], size: [f64; 2]) -> Net {
    let mut part = *net;
    cut(&mut part, start[0], start[0] + size[0]);
    let mut part = transposed(&part);
    cut(&mut part, start[1], start[1] + size[1]);
    transposed(&part)
}

#[inline(always)]
fn transposed(net: &Net) -> Net {
    let mut transposed = [[0.0; SIDE]; SIDE];
    for (row, values) in net.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            transposed[column][row] = *value;
        }
    }
    transposed
}

/// Leaves the coefficients of a part along s: first those up to its end, then, of these, those from its start.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "loops over neighbors")]
fn cut(net: &mut Net, from: f64, to: f64) {
    for step in 1..SIDE {
        for row in (step..SIDE).rev() {
            for column in 0..SIDE {
                net[row][column] = net[row - 1][column] + to * (net[row][column] - net[row - 1][column]);
            }
        }
    }
    let share = from / to;
    for step in 1..SIDE {
        for row in 0..SIDE - step {
            for column in 0..SIDE {
                net[row][column] += share * (net[row + 1][column] - net[row][column]);
            }
        }
    }
}

/// Returns the least and the greatest coefficient.
///
/// It compares and selects: `f64::min` and `f64::max` over rows that do not fill vectors lost coefficients in code for
/// AVX-512, so that rays passed through parts of the sea.
#[inline(always)]
pub fn range(net: &Net) -> [f64; 2] {
    let (blocks, rest) = net.as_flattened().as_chunks::<8>();
    let (mut low, mut high) = (blocks[0], blocks[0]);
    for block in &blocks[1..] {
        for lane in 0..8 {
            low[lane] = smaller(low[lane], block[lane]);
            high[lane] = larger(high[lane], block[lane]);
        }
    }
    // Halves against halves: eight numbers one after another take longer than all blocks.
    for half in [4, 2, 1] {
        for lane in 0..half {
            low[lane] = smaller(low[lane], low[lane + half]);
            high[lane] = larger(high[lane], high[lane + half]);
        }
    }
    [smaller(rest[0], low[0]), larger(rest[0], high[0])]
}

/// Returns the larger of two numbers, in one instruction; infinite coefficients, which make NaN, do not occur.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Returns the smaller of two numbers, in the same way.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

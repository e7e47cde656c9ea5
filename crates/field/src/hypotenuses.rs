//! Lengths of several vectors side by side, with the bits of `libm::hypot`.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

/// 2²⁷ + 1, which splits a number into halves of its digits.
const SPLIT: f64 = 134_217_729.0;
/// Exponents, as they are stored, beyond which squares would overflow or lose digits.
const LEAST: u64 = 0x3ff - 450;
const MOST: u64 = 0x3ff + 510;
/// Difference of exponents from which on the sum of both is the length.
const APART: u64 = 64;

/// Returns the square of a number, and what its rounding lost.
#[inline(always)]
fn squared(x: f64) -> [f64; 2] {
    let part = x * SPLIT;
    let high = x - part + part;
    let low = x - high;
    let square = x * x;
    [square, high * high - square + 2.0 * high * low + low * low]
}

/// Returns √(x² + y²) of each pair: the steps of `libm::hypot` for all pairs, with choices by masks, so that loops become
/// vectors where the caller compiles them for these. Very small and very large numbers, infinities and NaN take longer.
///
/// Source: `hypot.c` of musl, which `libm` follows.
///
/// ```
/// let [five, one] = trochoid_field::hypotenuses([3.0, -1.0], [4.0, 0.0]);
/// assert_eq!([five, one], [5.0, 1.0]);
/// ```
#[inline(always)]
pub fn hypotenuses<const N: usize>(x: [f64; N], y: [f64; N]) -> [f64; N] {
    let mut lengths = [0.0; N];
    let mut strange = 0;
    for lane in 0..N {
        let (a, b) = (x[lane].abs(), y[lane].abs());
        let (large, small) = if a < b { (b, a) } else { (a, b) };
        let [upper, lower] = [large, small].map(|number| number.to_bits() >> 52);
        let is_zero = u64::from(small.to_bits() == 0);
        strange |= u64::from(upper > MOST) | u64::from(lower > MOST) | (u64::from(lower < LEAST) & (1 - is_zero));
        let ([square, lost], [other, other_lost]) = (squared(large), squared(small));
        let length = (other_lost + lost + other + square).sqrt();
        let length = if upper.wrapping_sub(lower) > APART { large + small } else { length };
        lengths[lane] = if is_zero == 1 { large } else { length };
    }
    if strange != 0 {
        for lane in 0..N {
            lengths[lane] = libm::hypot(x[lane], y[lane]);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bits_are_those_of_single_lengths() {
        let ends =
            [0.0, 5e-324, f64::MIN_POSITIVE, 2f64.powi(-451), 2f64.powi(-450), 1.0, 2f64.powi(64), 2f64.powi(65)];
        let ends = ends.into_iter().chain([2f64.powi(510), 2f64.powi(511), f64::MAX, f64::INFINITY, f64::NAN]);
        let ends: Vec<f64> = ends.flat_map(|end| [end, -end]).collect();
        let mut pairs: Vec<[f64; 2]> = ends.iter().flat_map(|x| ends.iter().map(|y| [*x, *y])).collect();
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..200_000 {
            pairs.push([next() - 0.5, next() - 0.5]);
            pairs.push([2f64.powf(80.0 * next() - 40.0), 2f64.powf(80.0 * next() - 40.0)]);
        }
        for pairs in pairs.as_chunks::<4>().0 {
            let lengths = hypotenuses(pairs.map(|[x, _]| x), pairs.map(|[_, y]| y));
            for ([x, y], length) in pairs.iter().zip(lengths) {
                let alone = libm::hypot(*x, *y);
                assert!(alone.to_bits() == length.to_bits() || alone.is_nan() && length.is_nan(), "{x:e} {y:e}");
            }
        }
    }
}

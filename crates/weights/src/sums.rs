//! Weights from outside, which sum to 1 only up to their rounding: all of them are divided by their sum here.
//!
//! The quotients in f64 are what the weights mean. Kernels get each of them rounded to f32.

use trochoid_memory::Scratch;

/// Largest difference of a sum of weights from 1 that counts as rounding: that of weights stored in half precision.
pub const SUM_TOLERANCE: f64 = 1e-3;

/// Adds up weights ≥ 0 pixel by pixel: `planes[i][x]` is weight i at pixel x.
#[must_use]
pub fn sums(planes: &[&[f32]]) -> Scratch<f64> {
    let mut sums = Scratch::of(0.0, planes.first().map_or(0, |plane| plane.len()));
    for plane in planes {
        sums.iter_mut().zip(*plane).for_each(|(sum, weight)| *sum += f64::from(*weight));
    }
    sums
}

/// Returns whether a sum differs from 1 by more than [`SUM_TOLERANCE`].
#[must_use]
pub fn is_off(sum: f64) -> bool {
    let differs = (sum - 1.0).abs() > SUM_TOLERANCE;
    differs || sum.is_nan()
}

/// Divides one of `count` weights by their sum; if all are 0, each is 1/count.
///
/// The result is in [0, 1], since no weight ≥ 0 exceeds a sum that contains it. It is the exact quotient up to one
/// rounding in f64 and those of the sum, so that all of them sum to 1 within 2·`count`·2⁻⁵³.
#[inline]
#[must_use]
pub fn part(weight: f32, sum: f64, count: usize) -> f64 {
    if sum > 0.0 { f64::from(weight) / sum } else { 1.0 / count as f64 }
}

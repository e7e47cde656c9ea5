//! Bilinear weights, whose rounded sum is exactly 1, and blends of four pixels by them.

use trochoid_weights::arithmetic;

/// Returns the weights of the upper left, upper right, lower left and lower right pixel for a point at the given
/// fractions across and down: multiples of 2⁻²⁴ that sum to exactly 1.
#[inline]
pub(crate) fn weights(across: f64, down: f64) -> [f32; 4] {
    let (u, v) = (across, down);
    let mut weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v].map(|w| w as f32);
    arithmetic::round_partition(&mut weights);
    weights
}

/// Returns the blend of four pixels, which lies between the values whose weight is above 0. +∞ and −∞ have no mean;
/// then the upper left pixel is returned.
#[inline]
pub(crate) fn blended(values: [f32; 4], weights: &[f32; 4]) -> f32 {
    let blended = arithmetic::blend(&values, weights);
    if blended.is_nan() { values[0] } else { blended }
}

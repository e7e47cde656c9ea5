//! Numbers of documents, rounded for kernels.

use crate::LITERAL;

/// Largest difference of a sum of literal weights from 1: the rounding of decimal fractions.
pub const LITERAL_SUM_TOLERANCE: f64 = 1e-6;

/// Divides literal weights by their sum; `None` unless they are ≥ 0 and sum to 1 within [`LITERAL_SUM_TOLERANCE`].
pub(crate) fn parts(numbers: &[f64]) -> Option<Vec<f64>> {
    let sum: f64 = numbers.iter().sum();
    let sound = numbers.iter().all(|w| *w >= 0.0) && (sum - 1.0).abs() <= LITERAL_SUM_TOLERANCE;
    sound.then(|| numbers.iter().map(|w| w / sum).collect())
}

/// Rounds a number of a document to f32, the type of all kernels. Only 0 becomes 0: a number that is closer to 0 than
/// any other f32 becomes the smallest f32 of its sign.
///
/// ```
/// use trochoid_graph::{literal, literal_error};
///
/// for number in [0.1, -3.0e-42, 1e-60, 0.0] {
///     let rounded = literal(number);
///     assert!((f64::from(rounded) - number).abs() <= literal_error(rounded));
///     assert_eq!(rounded == 0.0, number == 0.0);
/// }
/// ```
pub fn literal(number: f64) -> f32 {
    let near = number as f32;
    if near == 0.0 && number != 0.0 { f32::from_bits(1).copysign(near) } else { near }
}

/// Bounds the distance of a number from what [`literal`] makes of it, and from what a few f64 operations make of the
/// number before.
///
/// With u = 2⁻²⁴ and r = rounded ≠ 0: a normal r lies within u·|r| of the number, since half the spacing at r is at most
/// that; a subnormal one within its spacing, 2⁻¹⁴⁹. 0 is exact. [`LITERAL`] exceeds u by what f64 operations round.
pub fn literal_error(rounded: f32) -> f64 {
    let subnormal = if rounded == 0.0 { 0.0 } else { f64::from(f32::from_bits(1)) };
    f64::from(rounded.abs()) * LITERAL + subnormal
}

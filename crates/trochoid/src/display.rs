//! Errors of colors as a display shows them.

use trochoid_image::{WorkingSpace, srgb_encode, srgb_fall};

/// Relative and absolute error of a conversion: one rounding to f32, and the error of a library's power function.
pub(crate) const ROUNDING: (f64, f64) = (1.0 / 16_777_216.0, 1e-12);

/// Widens a range by the errors of a conversion.
pub(crate) fn rounded((low, high): (f64, f64)) -> (f64, f64) {
    let slack = |value: f64| value.abs() * ROUNDING.0 + ROUNDING.1;
    (low - slack(low), high + slack(high))
}

/// Returns the errors of linear sRGB colors for errors of the channels in a working space.
pub(crate) fn linear_errors(space: WorkingSpace, errors: &[f64]) -> [f64; 3] {
    let columns = [0, 1, 2].map(|j| space.to_linear_srgb([0, 1, 2].map(|i| f64::from(u8::from(i == j)))));
    // A factor of 0 hides even an infinite error.
    let part =
        |i: usize, (column, error): (&[f64; 3], &f64)| if column[i] == 0.0 { 0.0 } else { column[i].abs() * error };
    [0, 1, 2].map(|i| columns.iter().zip(errors).map(|each| part(i, each)).sum())
}

/// Bounds how far a displayed color lies from that of the reference, given the ranges of its channels in linear sRGB and
/// bounds of their errors. Displays show channels from 0 to 1.
///
/// The display value of linear light v is enc(v), which is concave for v ≥ 0, and increasing. Over all v from `low`
/// to `high` and all references within e of v, the reference's value exceeds enc(v) most at `low`, where enc is
/// steepest. It falls short of it most at the v nearest to e: below e, references reach 0, which nothing falls
/// short of, and above e, enc becomes flatter.
pub(crate) fn near(linear: [(f64, f64); 3], errors: [f64; 3]) -> f64 {
    let of = |(low, high): (f64, f64), error: f64| {
        let shown = |linear: f64| srgb_encode(linear.clamp(0.0, 1.0));
        let (low, high) = rounded((low, high));
        let (low, high) = (low.max(0.0), high.max(0.0));
        let near = error.clamp(low, high);
        let most = (shown(low + error) - shown(low)).max(shown(near) - shown(near - error));
        most + srgb_fall(low - error, high + error)
    };
    let most = [0, 1, 2].map(|c| of(linear[c], errors[c])).into_iter().fold(0.0, f64::max);
    (most + 4.0 * ROUNDING.1).min(1.0)
}

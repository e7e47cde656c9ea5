//! Runs of values from four places, by lane.

use fearless_simd::{f32x4, prelude::*};

/// Returns the values `first` to `first` + 3 of four slices, each with one lane for each slice.
#[inline(always)]
pub(crate) fn transposed<S: Simd>(simd: S, slices: &[&[f32]; 4], first: usize) -> [f32x4<S>; 4] {
    let row = |lane: usize| f32x4::from_slice(simd, &slices[lane][first..first + 4]);
    let (a, b, c, d) = (row(0), row(1), row(2), row(3));
    let (low, high) = (a.zip_low(c), a.zip_high(c));
    let (other_low, other_high) = (b.zip_low(d), b.zip_high(d));
    [low.zip_low(other_low), low.zip_high(other_low), high.zip_low(other_high), high.zip_high(other_high)]
}

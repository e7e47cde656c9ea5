//! Bilinear weights, whose rounded sum is exactly 1, and blends of four pixels by them.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use trochoid_weights::arithmetic;

/// Number of points whose pixels are blended together.
pub(crate) const LANES: usize = 16;

/// Returns the weights of the upper left, upper right, lower left and lower right pixel for a point at the given
/// fractions across and down: multiples of 2⁻²⁴ that sum to exactly 1.
#[cfg(feature = "io")]
#[inline]
pub(crate) fn weights(across: f64, down: f64) -> [f32; 4] {
    let mut weights = shares(across, down);
    arithmetic::round_partition(&mut weights);
    weights
}

/// Returns the same before rounding.
#[inline(always)]
fn shares(u: f64, v: f64) -> [f32; 4] {
    [((1.0 - u) * (1.0 - v)) as f32, (u * (1.0 - v)) as f32, ((1.0 - u) * v) as f32, (u * v) as f32]
}

/// Returns the [weights] of several points, by pixel.
// Plain loops: closures would not be compiled for the vectors of the caller.
#[inline(always)]
pub(crate) fn weights_together(across: &[f64; LANES], down: &[f64; LANES]) -> [[f32; LANES]; 4] {
    let mut weights = [[0.0; LANES]; 4];
    let (mut best, mut owner, mut sum) = ([f32::NEG_INFINITY; LANES], [0_u32; LANES], [0.0_f64; LANES]);
    for lane in 0..LANES {
        let shares = shares(across[lane], down[lane]);
        for pixel in 0..4 {
            let larger = shares[pixel] > best[lane];
            owner[lane] = if larger { pixel as u32 } else { owner[lane] };
            best[lane] = if larger { shares[pixel] } else { best[lane] };
            weights[pixel][lane] = arithmetic::round_weight(shares[pixel]);
            sum[lane] += f64::from(weights[pixel][lane]);
        }
    }
    for pixel in 0..4 {
        for lane in 0..LANES {
            let weight = weights[pixel][lane];
            let settled = (f64::from(weight) + (1.0 - sum[lane])) as f32;
            weights[pixel][lane] = if owner[lane] == pixel as u32 { settled } else { weight };
        }
    }
    weights
}

/// Returns the blend of four pixels, which lies between the values whose weight is above 0. +∞ and −∞ have no mean;
/// then the upper left pixel is returned.
#[cfg(feature = "io")]
#[inline]
pub(crate) fn blended(values: [f32; 4], weights: &[f32; 4]) -> f32 {
    let blended = arithmetic::blend(&values, weights);
    if blended.is_nan() { values[0] } else { blended }
}

/// Returns the [blends](blended) at several points.
#[inline(always)]
pub(crate) fn blended_together(values: &[[f32; LANES]; 4], weights: &[[f32; LANES]; 4]) -> [f32; LANES] {
    let mut blends = [0.0; LANES];
    for lane in 0..LANES {
        let mut sum = 0.0_f64;
        for pixel in 0..4 {
            sum = arithmetic::accumulate(sum, weights[pixel][lane], values[pixel][lane]);
        }
        let blended = sum as f32;
        blends[lane] = if blended.is_nan() { values[0][lane] } else { blended };
    }
    blends
}

//! Gradient noise: random slopes at the corners of a lattice, blended into each other.

use super::cells::Cells;
use super::{GOLDEN, LANES, MOST, extend, key, mixed};
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};

/// 1/255 in two parts: the product of a byte with the first is exact, so that the sum of both products is rounded as the
/// quotient would be.
const PARTS: [f32; 2] = [514.0 / 131_072.0, (1.0 / 255.0 - 514.0 / 131_072.0) as f32];

/// Returns the component of a corner's gradient along an axis: −1 to 1 by steps of 2/255.
#[inline(always)]
pub(crate) fn gradient(hash: u32, axis: usize) -> f32 {
    let part = (2 * ((hash >> (8 * axis)) & 255) as i32 - 255) as f32;
    part * PARTS[0] + part * PARTS[1]
}

/// Amplitude of gradient noise by the number of axes, chosen such that its standard deviation at a cell's center is
/// about 0.3 and fewer than one sample in a thousand is clamped.
pub(crate) const AMPLITUDE: [f32; MOST + 1] = [0.0, 0.0, 1.5, 1.7, 2.1];

/// Returns t³(6t² − 15t + 10).
#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Returns gradient noise of one octave at a point, in [−1, 1].
pub(super) fn gradient_noise<const D: usize>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> f32 {
    let (mut hashes, mut weights) = ([seed; 1 << MOST], [1.0f32; 1 << MOST]);
    for axis in 0..D {
        let (half, s) = (1 << axis, fade(fraction[axis]));
        for corner in 0..half {
            let (hash, weight) = (hashes[corner], weights[corner]);
            hashes[corner] = extend(hash, cell[axis]);
            hashes[corner + half] = extend(hash, cell[axis].wrapping_add(1));
            weights[corner] = weight * (1.0 - s);
            weights[corner + half] = weight * s;
        }
    }
    let mut sum = 0.0;
    for corner in 0..1 << D {
        let mut dot = 0.0;
        for (axis, inside) in fraction.iter().enumerate() {
            dot += gradient(hashes[corner], axis) * (inside - ((corner >> axis) & 1) as f32);
        }
        sum += weights[corner] * dot;
    }
    (AMPLITUDE[D] * sum).clamp(-1.0, 1.0)
}

/// Numbers of lanes and corners.
const NUMBERS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Most runs of a block whose cells are hashed one by one, rather than the cells of all points.
const MOST_RUNS: u32 = 3;

/// Returns the same at a block of points, bit for bit. Neighboring points mostly lie in the same cell, whose corners are
/// then hashed once for all of them, unless they were just before.
#[inline(always)]
pub(super) fn gradient_noises<S: Simd, const D: usize>(
    simd: S,
    seed: u32,
    block: &Cells<S, D>,
    corners: &mut Corners<D>,
) -> f32x16<S> {
    let weights = weights(simd, &block.fractions);
    let mut starts = block.starts();
    let sums = if starts.count_ones() > MOST_RUNS {
        let hashes = hashes(simd, seed, block);
        blended(
            simd,
            &weights,
            &block.fractions,
            #[inline(always)]
            |corner, axis| gradients(hashes[corner], axis),
        )
    } else {
        let lanes = u32x16::from_slice(simd, &NUMBERS);
        let mut sums = f32x16::splat(simd, 0.0);
        while starts != 0 {
            let first = starts.trailing_zeros();
            starts &= starts - 1;
            let cell = block.cell(first as usize);
            if corners.cell != Some(cell) {
                corners.hash(simd, seed, cell);
            }
            let slopes = &corners.slopes;
            let found = blended(
                simd,
                &weights,
                &block.fractions,
                #[inline(always)]
                |corner, axis| f32x16::splat(simd, slopes[axis][corner]),
            );
            let mask: mask32x16<S> = lanes.simd_ge(first);
            sums = mask.select(found, sums);
        }
        sums
    };
    (sums * AMPLITUDE[D]).max(-1.0).min(1.0)
}

/// Returns the weights of a block's corners.
#[inline(always)]
fn weights<S: Simd, const D: usize>(simd: S, fractions: &[f32x16<S>; D]) -> [f32x16<S>; 1 << MOST] {
    let mut weights = [f32x16::splat(simd, 1.0); 1 << MOST];
    for (axis, t) in fractions.iter().copied().enumerate() {
        let share = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        for corner in 0..1 << axis {
            let weight = weights[corner];
            weights[corner] = weight * (f32x16::splat(simd, 1.0) - share);
            weights[corner + (1 << axis)] = weight * share;
        }
    }
    weights
}

/// Returns the hashes of the corners of each point's cell. Corners share the hashes of the preceding axes.
#[inline(always)]
fn hashes<S: Simd, const D: usize>(simd: S, seed: u32, block: &Cells<S, D>) -> [u32x16<S>; 1 << MOST] {
    let mut hashes = [u32x16::splat(simd, seed); 1 << MOST];
    for axis in 0..D {
        let (lower, upper) = (block.keys(axis, 0), block.keys(axis, 1));
        for corner in 0..1 << axis {
            let hash = hashes[corner];
            hashes[corner] = mixed((hash ^ lower) + GOLDEN);
            hashes[corner + (1 << axis)] = mixed((hash ^ upper) + GOLDEN);
        }
    }
    hashes
}

/// Returns [`gradient`] of each hash.
#[inline(always)]
fn gradients<S: Simd>(hashes: u32x16<S>, axis: usize) -> f32x16<S> {
    let byte = (hashes >> (8 * axis as u32)) & 255;
    let part: f32x16<S> = ((byte + byte).bitcast::<i32x16<S>>() - 255).to_float();
    part * PARTS[0] + part * PARTS[1]
}

/// The cell that was hashed last.
pub(super) struct Corners<const D: usize> {
    cell: Option<[i64; D]>,
    /// Gradients at its corners, by axis and corner.
    slopes: [[f32; 1 << MOST]; D],
}

impl<const D: usize> Default for Corners<D> {
    fn default() -> Self {
        Self { cell: None, slopes: [[0.0; 1 << MOST]; D] }
    }
}

impl<const D: usize> Corners<D> {
    /// Hashes the corners of a cell.
    #[inline(always)]
    fn hash<S: Simd>(&mut self, simd: S, seed: u32, cell: [i64; D]) {
        let corners = u32x16::from_slice(simd, &NUMBERS);
        let mut hashes = u32x16::splat(simd, seed);
        for (axis, cell) in cell.into_iter().enumerate() {
            let is_lower: mask32x16<S> = (corners & (1 << axis)).simd_eq(0);
            let (lower, upper) = (u32x16::splat(simd, key(cell)), u32x16::splat(simd, key(cell.wrapping_add(1))));
            hashes = mixed((hashes ^ is_lower.select(lower, upper)) + GOLDEN);
        }
        for (axis, slopes) in self.slopes.iter_mut().enumerate() {
            gradients(hashes, axis).store_slice(slopes);
        }
        self.cell = Some(cell);
    }
}

/// Returns Σ weight · gradient · offset over the corners, from the gradients' components of a corner along an axis.
#[inline(always)]
fn blended<S: Simd, const D: usize>(
    simd: S,
    weights: &[f32x16<S>; 1 << MOST],
    fractions: &[f32x16<S>; D],
    gradients: impl Fn(usize, usize) -> f32x16<S>,
) -> f32x16<S> {
    let mut sums = f32x16::splat(simd, 0.0);
    for (corner, weight) in weights.iter().copied().enumerate().take(1 << D) {
        let mut dot = f32x16::splat(simd, 0.0);
        for (axis, inside) in fractions.iter().copied().enumerate() {
            let offset = if (corner >> axis) & 1 == 1 { inside - 1.0 } else { inside };
            dot += gradients(corner, axis) * offset;
        }
        sums += weight * dot;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_255ths() {
        for byte in 0..=255 {
            let quotient = (2 * byte as i32 - 255) as f32 / 255.0;
            assert_eq!(gradient(byte << 16, 2).to_bits(), quotient.to_bits());
        }
    }
}

//! Blocks of points in the cells of an octave.

use super::GOLDEN;
use fearless_simd::{Simd, f32x16, f64x8, i32x16, mask64x8, prelude::*, u32x16};

/// Points of a block, by the cells of an octave in which they lie, fewer than 2³⁰ cells from the origin.
pub(super) struct Cells<S: Simd, const D: usize> {
    /// Number of the cell along each axis, modulo 2³².
    numbers: [u32x16<S>; D],
    /// Fraction within the cell along each axis, in [0, 1].
    pub(super) fractions: [f32x16<S>; D],
}

/// Near this number, the steps of f64 are 1, and the last bits count them.
const COUNTED: f64 = 1.5 * (1u64 << 52) as f64;

impl<S: Simd, const D: usize> Cells<S, D> {
    /// Returns the cells of a block of points along the axes; `None` if a point is far from the origin.
    #[inline(always)]
    pub(super) fn of(simd: S, along: &[[f64x8<S>; 2]; D]) -> Option<Self> {
        let mut is_near = mask64x8::splat(simd, true);
        for half in along.as_flattened() {
            is_near &= half.abs().simd_lt((1u64 << 30) as f64);
        }
        if !is_near.all_true() {
            return None;
        }
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let mut cells = Self { numbers: [u32x16::splat(simd, 0); D], fractions: [f32x16::splat(simd, 0.0); D] };
        for (axis, along) in along.iter().enumerate() {
            let [mut low, mut high] = *along;
            for floor in [&mut low, &mut high] {
                let nearest = (*floor + COUNTED) - COUNTED;
                *floor = nearest - nearest.simd_gt(*floor).select(one, zero);
            }
            let (counts, high_counts): (u32x16<S>, u32x16<S>) = ((low + COUNTED).bitcast(), (high + COUNTED).bitcast());
            cells.numbers[axis] = counts.unzip_low(high_counts);
            cells.fractions[axis] = (along[0] - low).narrow(along[1] - high);
        }
        Some(cells)
    }

    /// Returns the lanes, as bits, whose cell is not that of the lane before, and the first.
    #[inline(always)]
    pub(super) fn starts(&self) -> u32 {
        let first = self.numbers[0];
        let mut differ = first.simd_ne(first.rotate_elements_right::<1>());
        for numbers in &self.numbers[1..] {
            differ |= numbers.simd_ne(numbers.rotate_elements_right::<1>());
        }
        differ.to_bitmask() as u32 | 1
    }

    /// Returns the cell of a lane.
    #[inline(always)]
    pub(super) fn cell(&self, lane: usize) -> [i64; D] {
        self.numbers.map(|numbers| i64::from(numbers.as_slice()[lane] as i32))
    }

    /// Returns the [`key`]s of the cells that lie `step` further along an axis.
    #[inline(always)]
    pub(super) fn keys(&self, axis: usize, step: u32) -> u32x16<S> {
        let numbers = self.numbers[axis] + step;
        // The upper half of a negative number is all ones.
        let signs: u32x16<S> = (numbers.bitcast::<i32x16<S>>() >> 31).bitcast();
        numbers ^ (signs & 0u32.wrapping_sub(GOLDEN))
    }
}

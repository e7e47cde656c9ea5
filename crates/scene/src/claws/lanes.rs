//! Samples side by side in a ribbon, found together with the bits of [`Ribbon::at`](super::Ribbon::at).

use fearless_simd::{Simd, f64x4, mask64x4, prelude::*};

use super::ribbon::{RibbonPoint, STEPS, Segment};

/// Number of samples side by side.
pub(super) const LANES: usize = 4;

/// The deepest position found so far for each of the samples. The numbers of a sample lie side by side with those of
/// its neighbors.
#[derive(Clone, Copy)]
pub(super) struct Deepest {
    /// Position along the ribbon in segments.
    along: [f64; LANES],
    /// As in [`RibbonPoint`]; infinite where none is found.
    across: [f64; LANES],
    half_width: [f64; LANES],
}

impl Deepest {
    pub(super) const NONE: Self =
        Self { along: [0.0; LANES], across: [f64::INFINITY; LANES], half_width: [0.0; LANES] };

    /// Returns the position of one of the samples.
    #[inline]
    pub(super) fn at(&self, lane: usize) -> Option<RibbonPoint> {
        let [along, across, half_width] = [&self.along, &self.across, &self.half_width].map(|values| values[lane]);
        (across != f64::INFINITY).then(|| RibbonPoint { along: along / STEPS as f64, across, half_width })
    }

    /// Takes the positions in a segment where they are deeper. Every lane performs the operations of
    /// [`Segment::at`] in the same order.
    #[inline(always)]
    pub(super) fn deepen<S: Simd>(&mut self, simd: S, segment: &Segment, x: &[f64; LANES], y: f64) {
        let Segment { from: [ax, ay], way: [dx, dy], squared, widths: [width, wider], step } = *segment;
        let (zero, one) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, 1.0));
        let px = f64x4::load_array_ref(simd, x) - ax;
        let py = f64x4::splat(simd, y - ay);
        let t = if squared > 0.0 {
            let t = (px * dx + py * dy) / squared;
            let t = t.simd_lt(zero).select(zero, t);
            t.simd_gt(one).select(one, t)
        } else {
            zero
        };
        let (ox, oy) = (px - t * dx, py - t * dy);
        let half_width = t * wider + width;
        let distance = (ox * ox + oy * oy).sqrt();
        let inside = distance.simd_le(half_width) & half_width.simd_gt(zero);
        let depth = distance / inside.select(half_width, one);
        let before = f64x4::load_array_ref(simd, &self.across);
        let deeper = inside & depth.simd_lt(before.abs());
        if !deeper.any_true() {
            return;
        }
        let is_left = (oy * dx - ox * dy).simd_lt(zero);
        put(simd, deeper, &mut self.along, t + step);
        put(simd, deeper, &mut self.across, is_left.select(-depth, depth));
        put(simd, deeper, &mut self.half_width, half_width);
    }
}

/// Replaces some values by those found there.
#[inline(always)]
fn put<S: Simd>(simd: S, there: mask64x4<S>, values: &mut [f64; LANES], found: f64x4<S>) {
    there.select(found, f64x4::load_array_ref(simd, values)).store_slice(values);
}

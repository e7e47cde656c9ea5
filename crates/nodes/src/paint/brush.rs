//! A stroke as it is painted: what its rows share, computed once for all samples of a block.

use super::stroke::HAIRS;
use super::{Stroke, ceiling, floor};
use trochoid_image::Window;

/// Pixels of a row that are computed side by side.
pub(crate) const LANES: usize = 8;

/// A stroke, and the numbers that its coverage of all pixels shares.
#[derive(Clone, Copy)]
pub(crate) struct Brush {
    stroke: Stroke,
    /// Half its width with the bend.
    aside: f64,
    /// Change of the positions along and across per pixel.
    steps: [f32; 2],
    bend: f32,
    opacity: f32,
    bristle: f32,
    hairs: [f32; 2],
    /// Surface and depth of the stroke, and what depths may differ by; ignored if edges do not cut it.
    own: f32,
    far: f32,
    far_step: f32,
    step: f32,
    is_free: bool,
}

impl Brush {
    /// Returns the brush of a stroke.
    pub(crate) fn new(stroke: &Stroke) -> Self {
        let ([cos, sin], half) = (stroke.along, stroke.half);
        let (own, far) = stroke.edge.unwrap_or((0.0, 1.0));
        let (far, step) = (far as f32, stroke.step as f32);
        Self {
            stroke: *stroke,
            aside: (1.0 + stroke.bend.abs()) * half[1],
            steps: [(cos / half[0]) as f32, (-sin / half[1]) as f32],
            bend: stroke.bend as f32,
            opacity: stroke.opacity as f32,
            bristle: stroke.bristle as f32,
            hairs: stroke.hairs.map(|hair| hair as f32),
            own: own as f32,
            far,
            far_step: far * step,
            step,
            is_free: stroke.edge.is_none(),
        }
    }

    /// Returns the stroke's center relative to samples that are shifted against those it was found for.
    #[inline(always)]
    pub(crate) fn seen_from(&self, shift: [f64; 2]) -> [f64; 2] {
        [self.stroke.at[0] - shift[0], self.stroke.at[1] - shift[1]]
    }

    /// Returns the pixels that it may cover from a center.
    pub(crate) fn bounds(&self, at: [f64; 2]) -> Window {
        let ([cos, sin], half) = (self.stroke.along, self.stroke.half);
        let across = half[0] * cos.abs() + self.aside * sin.abs() + 1e-3;
        let down = half[0] * sin.abs() + self.aside * cos.abs();
        let window = |axis: usize, reach: f64| (ceiling(at[axis] - reach), floor(at[axis] + reach) + 1);
        let ((x0, x1), (y0, y1)) = (window(0, across), window(1, down));
        Window::new(x0, y0, x1, y1)
    }

    /// Returns the columns that it may cover in a row: the intersection of the row with two strips, along and across.
    #[inline(always)]
    pub(crate) fn columns(&self, at: [f64; 2], y: i64) -> [i64; 2] {
        let ([cos, sin], half) = (self.stroke.along, self.stroke.half);
        let dy = y as f64 - at[1];
        let reach = half[0] * cos.abs() + self.aside * sin.abs();
        let ([slope, other], [offset, beside]) = ([cos, -sin], [dy * sin, dy * cos]);
        // Side by side, since divisions take long.
        let mut ends = [-half[0] - offset, half[0] - offset, -self.aside - beside, self.aside - beside];
        for (end, slope) in ends.iter_mut().zip([slope, slope, other, other]) {
            *end /= slope;
        }
        let (mut low, mut high) = (-reach, reach);
        for (slope, [one, other], is_beside) in [
            (slope, [ends[0], ends[1]], offset.abs() > half[0]),
            (other, [ends[2], ends[3]], beside.abs() > self.aside),
        ] {
            if slope.abs() > 1e-9 {
                (low, high) = (low.max(one.min(other)), high.min(one.max(other)));
            } else if is_beside {
                return [0, -1];
            }
        }
        [ceiling(at[0] + low - 1e-3), floor(at[0] + high + 1e-3)]
    }

    /// Fills the coverage of pixels in a row, in f32, as [`Stroke::covers`] tells it. `[dx, dy]` is the offset of the row's
    /// first covered pixel from the center, and `skipped` the number of pixels from there to the first of `parts` and
    /// `depths`; counting from the same pixel gives the same bits for whatever part of the row is filled. `out` is filled in
    /// whole groups of lanes, beyond the row with 0.
    #[inline(always)]
    pub(crate) fn cover_row(
        &self,
        [dx, dy]: [f64; 2],
        skipped: i64,
        parts: &[f32],
        depths: &[f32],
        out: &mut [[f32; LANES]],
    ) {
        let ([cos, sin], half) = (self.stroke.along, self.stroke.half);
        let mut begin = [dx * cos + dy * sin, dy * cos - dx * sin];
        for (begin, half) in begin.iter_mut().zip(half) {
            *begin /= half;
        }
        let begin = begin.map(|begin| begin as f32);
        let Some(last) = parts.len().checked_sub(1) else { return };
        for (group, out) in out.iter_mut().enumerate() {
            let start = group * LANES;
            let first = skipped as usize + start;
            let [known, far] = [parts, depths].map(|row| row.get(start..).and_then(<[f32]>::first_chunk));
            if let (Some(parts), Some(depths)) = (known, far) {
                *out = self.cover(begin, first, *parts, *depths);
                continue;
            }
            let (mut known, mut far) = ([0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let at = (start + lane).min(last);
                (known[lane], far[lane]) = (parts[at], depths[at]);
            }
            let covers = self.cover(begin, first, known, far);
            for lane in 0..LANES {
                out[lane] = if start + lane <= last { covers[lane] } else { 0.0 };
            }
        }
    }

    /// Returns the coverage of a group of pixels, of which the first is the one with this number from the beginning. All
    /// numbers are copies: what may share memory with the results is not computed in vectors.
    #[inline(always)]
    fn cover(&self, [a0, b0]: [f32; 2], first: usize, parts: [f32; LANES], depths: [f32; LANES]) -> [f32; LANES] {
        let Self { steps: [a1, b1], bend, opacity, bristle, hairs: [h0, h1], own, far, far_step, step, .. } = *self;
        // Adding and subtracting this rounds to the nearest integer.
        const WHOLE: f32 = 12_582_912.0;
        let hair = |x: f32| 2.0 * (x - ((x + WHOLE) - WHOLE)).abs();
        let free = u32::from(self.is_free);
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            let (part, depth) = (parts[lane], depths[lane]);
            let x = (first + lane) as i32 as f32;
            let a = a1.mul_add(x, a0);
            let b = (-bend * a).mul_add(a, b1.mul_add(x, b0));
            let (aa, bb) = (1.0 - a * a, 1.0 - b * b);
            let body = (2.2 * aa * bb).min(1.0);
            let hair = 0.5 * (hair((HAIRS[0] as f32).mul_add(b, h0)) + hair((HAIRS[1] as f32).mul_add(b, h1)));
            let dry = 1.0 - 0.55 * bristle * (1.0 - hair);
            let end = 1.0 - 0.8 * bristle * a.max(0.0) * hair;
            let same = u32::from(part == own) & u32::from(depth <= far_step) & u32::from(far <= depth * step);
            let covers = u32::from(aa >= 0.0) & u32::from(bb >= 0.0) & (same | free);
            // A mask of bits instead of a choice, which would be a jump at each pixel.
            let value = opacity * body * dry * end;
            out[lane] = f32::from_bits(value.to_bits() & 0u32.wrapping_sub(covers));
        }
        out
    }
}

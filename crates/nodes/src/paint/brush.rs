//! A stroke as it is painted: what its rows share, computed once for all samples of a block.

use super::Stroke;
use super::stroke::HAIRS;
use super::{ceiling, floor};
use trochoid_image::Window;

/// Pixels of a row, and rows of a stroke, that are computed side by side.
pub(crate) const LANES: usize = 8;

/// The numbers of a stroke that its coverage of all pixels shares.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Brush {
    at: [f64; 2],
    along: [f64; 2],
    half: [f64; 2],
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
    step: f32,
    is_free: bool,
}

/// What a group of pixels in a row sees.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub(crate) struct Ground {
    /// Indices of the surfaces; −1 where none is seen.
    pub(crate) parts: [f32; LANES],
    pub(crate) depths: [f32; LANES],
}

/// Rows of a stroke, each with the columns that it may cover: those of the intersection of the row with two strips, along
/// and across. Columns are counted from the first one of a window.
#[derive(Clone, Copy)]
pub(crate) struct Rows {
    /// The first column, and the one behind the last, within the window.
    pub(crate) from: [i32; LANES],
    pub(crate) to: [i32; LANES],
    /// Number of columns from the first one, also beyond the window, to the window's first.
    ahead: [f32; LANES],
    /// Positions along and across at the first column. All columns count from there, so that their bits do not depend on
    /// the window.
    starts: [[f32; LANES]; 2],
}

impl Brush {
    /// Returns the brush of a stroke.
    pub(crate) fn new(stroke: &Stroke) -> Self {
        let ([cos, sin], half) = (stroke.along, stroke.half);
        let (own, far) = stroke.edge.unwrap_or((0.0, 1.0));
        Self {
            at: stroke.at,
            along: stroke.along,
            half,
            aside: (1.0 + stroke.bend.abs()) * half[1],
            steps: [(cos / half[0]) as f32, (-sin / half[1]) as f32],
            bend: stroke.bend as f32,
            opacity: stroke.opacity as f32,
            bristle: stroke.bristle as f32,
            hairs: stroke.hairs.map(|hair| hair as f32),
            own: own as f32,
            far: far as f32,
            step: stroke.step as f32,
            is_free: stroke.edge.is_none(),
        }
    }

    /// Returns the stroke's center relative to samples that are shifted against those it was found for.
    #[inline(always)]
    pub(crate) fn seen_from(&self, shift: [f64; 2]) -> [f64; 2] {
        [self.at[0] - shift[0], self.at[1] - shift[1]]
    }

    /// Returns the pixels that it may cover from a center.
    pub(crate) fn bounds(&self, at: [f64; 2]) -> Window {
        let ([cos, sin], half) = (self.along, self.half);
        let across = half[0] * cos.abs() + self.aside * sin.abs() + 1e-3;
        let down = half[0] * sin.abs() + self.aside * cos.abs();
        let window = |axis: usize, reach: f64| (ceiling(at[axis] - reach), floor(at[axis] + reach) + 1);
        let ((x0, x1), (y0, y1)) = (window(0, across), window(1, down));
        Window::new(x0, y0, x1, y1)
    }

    /// Returns the rows from `y` on, for the columns from `x0` up to `x0 + width`.
    #[inline(always)]
    pub(crate) fn rows(&self, at: [f64; 2], y: i64, x0: i64, width: usize) -> Rows {
        let ([cos, sin], half, aside) = (self.along, self.half, self.aside);
        let reach = half[0] * cos.abs() + aside * sin.abs();
        // A row along a strip lies within it or beside it.
        let (is_steep, is_flat) = (cos.abs() > 1e-9, sin.abs() > 1e-9);
        let (y, x0, width) = (y as f64, x0 as f64, width as f64);
        let mut rows = Rows { from: [0; LANES], to: [0; LANES], ahead: [0.0; LANES], starts: [[0.0; LANES]; 2] };
        for lane in 0..LANES {
            let dy = y + lane as f64 - at[1];
            let (offset, beside) = (dy * sin, dy * cos);
            let (mut low, mut high) = (-reach, reach);
            let [one, other] = [(-half[0] - offset) / cos, (half[0] - offset) / cos];
            low = if is_steep { larger(low, smaller(one, other)) } else { low };
            high = if is_steep { smaller(high, larger(one, other)) } else { high };
            let [one, other] = [(-aside - beside) / -sin, (aside - beside) / -sin];
            low = if is_flat { larger(low, smaller(one, other)) } else { low };
            high = if is_flat { smaller(high, larger(one, other)) } else { high };
            let is_beside = (!is_steep & (offset.abs() > half[0])) | (!is_flat & (beside.abs() > aside));
            // Adding 0 turns −0 to 0.
            let begin = (at[0] + low - 1e-3).ceil() + 0.0;
            let end = (at[0] + high + 1e-3).floor() + 1.0;
            let dx = begin - at[0];
            rows.starts[0][lane] = ((dx * cos + offset) / half[0]) as f32;
            rows.starts[1][lane] = ((beside - dx * sin) / half[1]) as f32;
            rows.ahead[lane] = (x0 - begin) as f32;
            rows.from[lane] = whole(smaller(larger(begin - x0, 0.0), width));
            rows.to[lane] = if is_beside { 0 } else { whole(larger(smaller(end - x0, width), 0.0)) };
        }
        rows
    }

    /// Returns the coverage of a group of pixels in a row from a column on, in f32, as [`Stroke::covers`] tells it. All
    /// numbers are copies: what may share memory with the results is not computed in vectors.
    #[inline(always)]
    pub(crate) fn cover(&self, rows: &Rows, row: usize, column: usize, ground: Ground) -> [f32; LANES] {
        let Self { steps: [a1, b1], bend, opacity, bristle, hairs: [h0, h1], own, far, step, .. } = *self;
        let ([a0, b0], ahead) = ([rows.starts[0][row], rows.starts[1][row]], rows.ahead[row]);
        let (from, to) = (rows.from[row], rows.to[row]);
        // Adding and subtracting this rounds to the nearest integer.
        const WHOLE: f32 = 12_582_912.0;
        let hair = |x: f32| 2.0 * (x - ((x + WHOLE) - WHOLE)).abs();
        let (free, far_step) = (u32::from(self.is_free), far * step);
        let (Ground { parts, depths }, mut out) = (ground, [0.0; LANES]);
        for lane in 0..LANES {
            let (part, depth) = (parts[lane], depths[lane]);
            let column = (column + lane) as i32;
            let x = ahead + column as f32;
            let a = a1.mul_add(x, a0);
            let b = (-bend * a).mul_add(a, b1.mul_add(x, b0));
            let (aa, bb) = (1.0 - a * a, 1.0 - b * b);
            let body = (2.2 * aa * bb).min(1.0);
            let hair = 0.5 * (hair((HAIRS[0] as f32).mul_add(b, h0)) + hair((HAIRS[1] as f32).mul_add(b, h1)));
            let dry = 1.0 - 0.55 * bristle * (1.0 - hair);
            let end = 1.0 - 0.8 * bristle * a.max(0.0) * hair;
            let same = u32::from(part == own) & u32::from(depth <= far_step) & u32::from(far <= depth * step);
            let inside = u32::from(aa >= 0.0) & u32::from(bb >= 0.0);
            let covers = inside & u32::from(from <= column) & u32::from(column < to) & (same | free);
            // A mask of bits instead of a choice, which would be a jump at each pixel.
            let value = opacity * body * dry * end;
            out[lane] = f32::from_bits(value.to_bits() & 0u32.wrapping_sub(covers));
        }
        out
    }
}

/// Returns the larger of two numbers, which are not NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns the smaller of two numbers, which are not NaN.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Converts a whole number ≥ 0 by its bits: the machine has no vectors for a conversion of any number.
#[inline(always)]
fn whole(x: f64) -> i32 {
    (x + (1u64 << 52) as f64).to_bits() as i32
}

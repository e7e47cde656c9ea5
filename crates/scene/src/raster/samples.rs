//! The samples of a window's pixels, and the nearest triangle of each so far.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use trochoid_image::Window;

use super::batch::{Batch, SampleGrid};
use crate::edges::{Edges, Whole};

/// Part of a pixel by which rounding may misplace the end of a span.
const SLACK: f64 = 1e-6;

/// Samples of each pixel of a window.
pub(super) struct PixelSamples<'a, const N: usize> {
    window: Window,
    /// Positions within their pixel, in fixed point.
    shifts: [[i32; 2]; N],
    grid: SampleGrid,
    /// The sample of each row of samples.
    by_row: [usize; N],
    triangles: &'a mut [[u64; N]],
    /// Keys of the visible triangles.
    keys: &'a mut [[f64; N]],
}

impl<'a, const N: usize> PixelSamples<'a, N> {
    pub(super) fn new(
        window: Window,
        shifts: [[i32; 2]; N],
        bits: u32,
        triangles: &'a mut [[u64; N]],
        keys: &'a mut [[f64; N]],
    ) -> Self {
        let along = |axis: usize| {
            let mut along = shifts.map(|shift| shift[axis]);
            along.sort_unstable();
            along
        };
        let outer = [0, 1].map(|axis| [along(axis)[0], along(axis)[N - 1]]);
        // With the samples of a format, every row and column of an even subdivision of the pixel holds a sample;
        // other samples may be anywhere.
        let rows = bits.saturating_sub(N.ilog2());
        let even = |axis: usize| along(axis).windows(2).all(|pair| pair[1] - pair[0] == 1 << rows);
        let apart = if bits >= N.ilog2() && even(0) && even(1) { rows } else { 0 };
        let mut by_row: [usize; N] = std::array::from_fn(|sample| sample);
        by_row.sort_unstable_by_key(|sample| shifts[*sample][1]);
        Self { window, shifts, grid: SampleGrid { outer, apart, bits }, by_row, triangles, keys }
    }

    /// Assigns the number of each triangle of a batch to every sample of `part` that it covers and that sees nothing
    /// nearer, and empties the batch.
    #[inline(always)]
    pub(super) fn cover(&mut self, batch: &mut Batch, part: Window) {
        batch.set_up(self.grid, part);
        let bits = self.grid.bits;
        let mut left = batch.seen;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let (number, [[x0, x1], [y0, y1]]) = (batch.numbers[lane], batch.pixels(lane));
            let pixels = Window::new(x0.into(), y0.into(), i64::from(x1) + 1, i64::from(y1) + 1);
            // For small triangles the edge functions fit in half the width.
            if batch.few & 1 << lane != 0 {
                self.cover_few(batch, lane, pixels);
            } else if batch.small & 1 << lane != 0 {
                let edges = batch.edges.at(lane);
                let [x, y] = batch.from(lane);
                let change = edges.change((x0 << bits) - x, (y0 << bits) - y);
                let first = [0, 1, 2].map(|edge| edges.first[edge] + change[edge]);
                self.cover_by(&edges, first, number, pixels);
            } else {
                let corners = batch.corners(lane);
                let from = [pixels.x0 << bits, pixels.y0 << bits];
                if batch.fits_floats(lane, bits) {
                    self.cover_from(Edges::<f64>::new(corners, from), number, pixels);
                } else {
                    self.cover_from(Edges::<i64>::new(corners, from), number, pixels);
                }
            }
        }
        batch.clear();
    }

    /// Covers samples of some pixels with a triangle within whose bounds there are few samples: looks only at these.
    #[inline(always)]
    fn cover_few(&mut self, batch: &Batch, lane: usize, pixels: Window) {
        let SampleGrid { outer, apart, bits } = self.grid;
        let ([left, right], [top, bottom]) = (batch.bounds(lane, 0), batch.bounds(lane, 1));
        let (edges, from, number) = (batch.edges.at(lane), batch.from(lane), batch.numbers[lane]);
        let up = (1 << bits) - 1;
        let row = |y: i32| (y - outer[1][0]) >> apart;
        for row in row(top - 1) + 1..row(bottom) + 1 {
            let (y, sample) = (row >> N.ilog2(), self.by_row[row as usize & (N - 1)]);
            let [right_of, below] = self.shifts[sample];
            let first = (left - right_of + up) >> bits;
            let last = (right - right_of) >> bits;
            for x in first..last + 1 {
                let pixel = [i64::from(x), i64::from(y)];
                if pixel[0] < pixels.x0 || pixel[0] >= pixels.x1 || pixel[1] < pixels.y0 || pixel[1] >= pixels.y1 {
                    continue;
                }
                let change = edges.change((x << bits) + right_of - from[0], (y << bits) + below - from[1]);
                let at = [edges.first[0] + change[0], edges.first[1] + change[1], edges.first[2] + change[2]];
                if Edges::inside(at) < 0 {
                    continue;
                }
                let column = (pixel[0] - self.window.x0) as usize;
                let index = (pixel[1] - self.window.y0) as usize * self.window.width() + column;
                let (nearest, seen) = (&mut self.keys[index][sample], &mut self.triangles[index][sample]);
                see(edges.key(at), number, nearest, seen);
            }
        }
    }

    /// Covers samples of pixels by functions that start at the first of these.
    #[inline(always)]
    fn cover_from<I: Whole>(&mut self, edges: Option<Edges<I>>, number: u64, pixels: Window) {
        if let Some(edges) = edges {
            self.cover_by(&edges, edges.first, number, pixels);
        }
    }

    /// Covers samples of pixels by functions with the values `left` at the upper left corner of the first of these.
    #[inline(always)]
    fn cover_by<I: Whole>(&mut self, edges: &Edges<I>, mut left: [I; 3], number: u64, pixels: Window) {
        // By edge and sample, the difference of the functions from their value at the pixel's corner. Loops instead
        // of closures, which are not always inlined into code for an instruction set.
        let mut beyond = [[I::of(0); N]; 3];
        for sample in 0..N {
            let [x, y] = self.shifts[sample];
            let change = edges.change(I::of(i64::from(x)), I::of(i64::from(y)));
            for edge in 0..3 {
                beyond[edge][sample] = change[edge];
            }
        }
        let pixel = I::of(1 << self.grid.bits);
        let (right, down) = (edges.change(pixel, I::of(0)), edges.change(I::of(0), pixel));
        let spans = Spans::new(right, &beyond, pixels.width());
        for y in pixels.y0..pixels.y1 {
            let (from, to) = spans.of(left);
            let row = (y - self.window.y0) as usize * self.window.width() + (pixels.x0 - self.window.x0) as usize;
            let mut corner = left;
            for edge in 0..3 {
                corner[edge] = corner[edge] + right[edge] * I::of(from);
            }
            for index in row + from as usize..row + to as usize {
                let mut at = [[I::of(0); N]; 3];
                for edge in 0..3 {
                    for sample in 0..N {
                        at[edge][sample] = corner[edge] + beyond[edge][sample];
                    }
                    corner[edge] = corner[edge] + right[edge];
                }
                let mut inside = [I::of(0); N];
                let mut some = I::of(-1);
                for sample in 0..N {
                    inside[sample] = Edges::inside([at[0][sample], at[1][sample], at[2][sample]]);
                    some = some.either(inside[sample]);
                }
                if some < I::of(0) {
                    continue;
                }
                // By masks of bits: which samples a triangle covers is not predictable.
                let (mut nearest, mut seen) = (self.keys[index], self.triangles[index]);
                for sample in 0..N {
                    let key = edges.key([at[0][sample], at[1][sample], at[2][sample]]);
                    let first = u64::from(key == nearest[sample]) & u64::from(number < seen[sample]);
                    let is_seen = u64::from(inside[sample] >= I::of(0)) & (u64::from(key > nearest[sample]) | first);
                    let mask = 0_u64.wrapping_sub(is_seen);
                    nearest[sample] = f64::from_bits(key.to_bits() & mask | nearest[sample].to_bits() & !mask);
                    seen[sample] = number & mask | seen[sample] & !mask;
                }
                (self.keys[index], self.triangles[index]) = (nearest, seen);
            }
            for edge in 0..3 {
                left[edge] = left[edge] + down[edge];
            }
        }
    }
}

/// Finds the pixels of a row that a triangle may cover.
struct Spans<I, const N: usize> {
    /// Greatest differences of the functions at a sample from those at its pixel's corner.
    most: [I; 3],
    /// Pixels over which each function grows by 1; 0 if it does not change.
    inverse: [f64; 3],
    width: f64,
}

impl<I: Whole, const N: usize> Spans<I, N> {
    #[inline(always)]
    fn new(right: [I; 3], beyond: &[[I; N]; 3], width: usize) -> Self {
        let mut spans = Self { most: [I::of(0); 3], inverse: [0.0; 3], width: width as f64 };
        for edge in 0..3 {
            let mut most = beyond[edge][0];
            for sample in 1..N {
                most = if beyond[edge][sample] > most { beyond[edge][sample] } else { most };
            }
            spans.most[edge] = most;
            let step = right[edge].float();
            spans.inverse[edge] = if step == 0.0 { 0.0 } else { 1.0 / step };
        }
        spans
    }

    /// Returns the first pixel and the one after the last, given the functions at the row's first corner. Rounding may add
    /// a pixel, but leaves out none: places within a row are far more exact than the slack.
    #[inline(always)]
    fn of(&self, left: [I; 3]) -> (i64, i64) {
        let (mut from, mut to) = (0.0_f64, self.width);
        for edge in 0..3 {
            let (value, inverse) = ((left[edge] + self.most[edge]).float(), self.inverse[edge]);
            let zero = -value * inverse;
            from = if inverse > 0.0 { from.max(zero - SLACK) } else { from };
            to = if inverse < 0.0 { to.min(zero + SLACK + 1.0) } else { to };
            to = if inverse == 0.0 && value < 0.0 { 0.0 } else { to };
        }
        // The first one is rounded up, since the function must have reached 0.
        let from = from.ceil().min(self.width) as i64;
        (from, (to.floor() as i64).max(from))
    }
}

/// Notes that a sample sees a triangle, unless it sees a nearer one.
#[inline(always)]
fn see(key: f64, number: u64, nearest: &mut f64, seen: &mut u64) {
    if key > *nearest || (key == *nearest && number < *seen) {
        (*nearest, *seen) = (key, number);
    }
}

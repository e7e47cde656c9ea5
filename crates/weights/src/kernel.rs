//! One-dimensional kernels, and separable filtering by one across and one down.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use std::ops::Range;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Shape of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// exp(−k²/2σ²), cut off at four σ.
    Gaussian,
    /// 1 up to the half width; the next pixel has the remaining fraction.
    Box,
}

impl Shape {
    /// Returns the distance of the farthest pixel that a kernel of a size reaches.
    pub fn radius(self, size: f64) -> i64 {
        match self {
            Self::Gaussian => (REACH * size).ceil() as i64,
            Self::Box => size.ceil() as i64,
        }
    }

    /// Returns the weights of the pixels at distances from 0 to the radius, before they are normalized.
    fn raw(self, size: f64) -> impl Iterator<Item = f64> {
        (0..=self.radius(size)).map(move |k| {
            let k = k as f64;
            match self {
                Self::Gaussian if k == 0.0 => 1.0,
                Self::Gaussian => libm::exp(-0.5 * (k / size) * (k / size)),
                Self::Box => (size + 1.0 - k).clamp(0.0, 1.0),
            }
        })
    }

    /// Returns the offsets and normalized weights from the farthest pixel on one side to that on the other, in f64.
    pub fn reference(self, size: f64) -> Vec<(i64, f64)> {
        let half: Vec<f64> = self.raw(size).collect();
        let total = 2.0 * half.iter().skip(1).sum::<f64>() + half[0];
        let radius = self.radius(size);
        (-radius..=radius).map(|k| (k, half[k.unsigned_abs() as usize] / total)).collect()
    }
}

/// Radius of a Gaussian in standard deviations. All pixels beyond it together would weigh less than a ten-thousandth.
const REACH: f64 = 4.0;

/// 1 as a multiple of the smallest weight, 2⁻²⁴.
const ONE: f64 = 16_777_216.0;

/// Weights of a symmetric kernel from one side to the other: multiples of 2⁻²⁴ that sum to exactly 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    pub(crate) weights: Scratch<f32>,
}

impl Kernel {
    /// Creates the kernel of a shape and size.
    ///
    /// The running sums from the center outward are rounded, and each weight is the difference of two of them.
    /// Therefore no weight is negative, both sides are equal, the sum is exact for any number of weights, and what
    /// rounding takes from one pixel goes to the next.
    pub fn new(shape: Shape, size: f64) -> Self {
        let half: Vec<f64> = shape.raw(size).collect();
        let total = 2.0 * half.iter().skip(1).sum::<f64>() + half[0];
        let mut side = Vec::with_capacity(half.len());
        let (mut sum, mut before) = (0.0, 0.0);
        for weight in &half[1..] {
            sum += weight;
            // One side has at most half of the total, even if rounding has made the sum larger.
            let rounded = (sum / total * ONE).round().min(ONE / 2.0);
            side.push(((rounded - before) / ONE) as f32);
            before = rounded;
        }
        while side.last() == Some(&0.0) {
            side.pop();
        }
        let center = ((ONE - 2.0 * before) / ONE) as f32;
        Self { weights: side.iter().rev().copied().chain([center]).chain(side.iter().copied()).collect() }
    }

    /// Returns the distance of the farthest pixel that has a weight.
    fn radius(&self) -> usize {
        self.weights.len() / 2
    }

    /// Returns the kernel for an image that is `length` pixels long. Everything farther away is the repeated pixel at
    /// the border, which takes those weights too. So no kernel is longer than twice the image.
    pub(crate) fn folded(&self, length: usize) -> Self {
        let cut = self.radius().saturating_sub(length.max(1) - 1);
        let (ends, rest) = self.weights.split_at(cut);
        let mut weights: Scratch<f32> = rest[..rest.len() - cut].iter().copied().collect();
        // Sums of multiples of 2⁻²⁴ up to 1 are exact.
        let beyond: f64 = ends.iter().map(|w| f64::from(*w)).sum();
        let last = weights.len() - 1;
        if last == 0 {
            weights[0] = (f64::from(weights[0]) + 2.0 * beyond) as f32;
        } else {
            for end in [0, last] {
                weights[end] = (f64::from(weights[end]) + beyond) as f32;
            }
        }
        Self { weights }
    }
}

/// Sums computed at a time: enough of them to hide the latency of an addition.
const LANES: usize = 32;
/// Rows in one task for a thread, across and down. Each task down reads all rows under its kernel.
const BATCH: [usize; 2] = [16, 64];
/// Columns that are summed at a time down, for some rows together: each value is read once for all of these, and their
/// sums fit into registers.
const COLUMNS: usize = 8;
const TOGETHER: usize = 4;
/// Bytes of a strip, and most blocks of columns in it.
const CACHE: usize = 192 << 10;
const MOST: usize = 32;

/// Filters the part `from` of an image and writes the part `to` of the result. Beyond the edge of `from`, the nearest
/// pixel repeats; `extent` is the window of the whole image.
///
/// Sums are in f64, in the order of the kernel, and each result is rounded to f32 once across and once down. The bits
/// therefore do not depend on where a tile begins, and no result lies outside the values under the kernel
/// ([`arithmetic::blend`](crate::arithmetic::blend)). When `stop` returns true, filtering ends early and the contents of `out`
/// are unspecified.
pub fn filter(
    kernels: [&Kernel; 2],
    from: Window,
    samples: &[f32],
    extent: Window,
    to: Window,
    stop: &(dyn Fn() -> bool + Sync),
    out: &mut [f32],
) {
    let across = kernels[0].folded(extent.width());
    let down = kernels[1].folded(extent.height());
    let (stride, width) = (from.width(), to.width());
    if width == 0 || stride == 0 {
        return;
    }
    let level = Level::new();
    let mut rows = Scratch::of(0.0, width * from.height());
    let first = to.x0 - across.radius() as i64 - from.x0;
    let batches = rows.par_chunks_mut(width * BATCH[0]).zip(samples.par_chunks(stride * BATCH[0]));
    batches.for_each(|(rows, samples)| {
        let mut line = Scratch::of(0.0f64, across.weights.len() - 1 + width.next_multiple_of(LANES));
        for (row, samples) in rows.chunks_mut(width).zip(samples.chunks(stride)) {
            if stop() {
                return;
            }
            widen(samples, first, &mut line);
            across.row(level, &line, row);
        }
    });
    let down = Down::new(&down);
    out.par_chunks_mut(width * BATCH[1]).enumerate().for_each_init(Strip::default, |strip, (batch, out)| {
        let top = to.y0 + (batch * BATCH[1]) as i64 - down.radius as i64 - from.y0;
        let under = top..top + (out.len() / width + 2 * down.radius) as i64;
        let wide = Strip::width(&under);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            for x in (0..width).step_by(wide) {
                if stop() {
                    return;
                }
                let columns = x..width.min(x + wide);
                strip.gather(&rows, width, columns.clone(), under.clone());
                for (y, out) in out.chunks_mut(width * TOGETHER).enumerate() {
                    for block in 0..strip.blocks.len() {
                        let start = x + block * COLUMNS;
                        let columns = start..columns.end.min(start + COLUMNS);
                        down.filter(strip, block, y * TOGETHER, columns, width, out);
                    }
                }
            }
        }));
    });
}

/// Fills a line with a row's samples from the one at `first` on. Beyond the row, its first and last samples repeat.
fn widen(samples: &[f32], first: i64, line: &mut [f64]) {
    let [left, right] = [-first, samples.len() as i64 - first].map(|end| end.clamp(0, line.len() as i64) as usize);
    line[..left].fill(f64::from(samples[0]));
    line[right..].fill(f64::from(samples[samples.len() - 1]));
    let inner = &mut line[left..right];
    for (value, sample) in inner.iter_mut().zip(samples.iter().skip(first.max(0) as usize)) {
        *value = f64::from(*sample);
    }
}

impl Kernel {
    /// Filters one row, from `line`, which begins one radius before it.
    fn row(&self, level: Level, line: &[f64], out: &mut [f32]) {
        let center = self.radius();
        // Values of 0 change no sum, whatever their weights.
        let used = line.iter().position(|value| *value != 0.0).unwrap_or(line.len())
            ..line.iter().rposition(|value| *value != 0.0).map_or(0, |last| last + 1);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            for (out, start) in out.chunks_mut(LANES).zip((0..).step_by(LANES)) {
                let mut sums = [0.0f64; LANES];
                let from = used.start.saturating_sub(start + LANES - 1).min(self.weights.len());
                let to = used.end.saturating_sub(start).clamp(from, self.weights.len());
                let weights = self.weights[from..to].iter().zip(start + from..);
                for (weight, k) in weights.filter(|(weight, _)| **weight != 0.0) {
                    let weight = f64::from(*weight);
                    for (sum, value) in sums.iter_mut().zip(&line[k..k + LANES]) {
                        *sum += weight * value;
                    }
                }
                for ((out, sum), value) in out.iter_mut().zip(sums).zip(&line[start + center..]) {
                    // +∞ and −∞ have no mean: keep the center.
                    *out = if sum.is_nan() { *value as f32 } else { sum as f32 };
                }
            }
        }));
    }
}

/// The rows of a block that has none, to which others are added.
const NO_ROWS: Range<usize> = Range { start: usize::MAX, end: 0 };

/// Columns of some rows, in blocks of a few columns.
#[derive(Default)]
struct Strip {
    rows: Scratch<[f64; COLUMNS]>,
    /// Number of rows.
    height: usize,
    /// Of each block, the rows outside of which all values are 0.
    blocks: Scratch<Range<usize>>,
}

impl Strip {
    /// Returns a number of columns that lie side by side in memory, as far as a strip of these rows stays in the cache.
    fn width(rows: &Range<i64>) -> usize {
        let bytes = (rows.end - rows.start) as usize * size_of::<[f64; COLUMNS]>();
        (CACHE / bytes.max(1)).clamp(1, MOST) * COLUMNS
    }

    /// Takes columns of rows of an image that is `width` wide. Above and below it, its first and last rows repeat.
    #[inline(always)]
    fn gather(&mut self, image: &[f32], width: usize, columns: Range<usize>, rows: Range<i64>) {
        let last = (image.len() / width) as i64 - 1;
        let count = columns.len().div_ceil(COLUMNS);
        self.height = (rows.end - rows.start) as usize;
        self.rows.resize(count * self.height, [0.0; COLUMNS]);
        self.blocks.clear();
        self.blocks.resize(count, NO_ROWS);
        // Plain loops: closures would not be compiled for the vectors of the caller.
        for (index, y) in rows.enumerate() {
            let row = &image[y.clamp(0, last) as usize * width..][columns.clone()];
            for (block, used) in self.blocks.iter_mut().enumerate() {
                let row = &row[block * COLUMNS..];
                let values = if let Some(values) = row.first_chunk() { *values } else { filled(row) };
                let mut wide = [0.0f64; COLUMNS];
                let mut is_used = false;
                for (wide, value) in wide.iter_mut().zip(&values) {
                    *wide = f64::from(*value);
                    is_used |= *value != 0.0;
                }
                if is_used {
                    *used = used.start.min(index)..index + 1;
                }
                self.rows[block * self.height + index] = wide;
            }
        }
    }
}

/// A kernel that filters strips down, some rows together.
struct Down {
    radius: usize,
    /// The weights between zeros, so that each row can begin one value later than the row before.
    weights: Scratch<f64>,
    /// The values, counted from the first that any row reads, whose weights in all rows are not 0.
    dense: Range<usize>,
}

impl Down {
    fn new(kernel: &Kernel) -> Self {
        let zeros = [0.0; TOGETHER - 1];
        let weights = kernel.weights.iter().map(|weight| f64::from(*weight));
        let is_dense = weights.clone().all(|weight| weight != 0.0) && kernel.weights.len() >= TOGETHER;
        let dense = if is_dense { TOGETHER - 1..kernel.weights.len() } else { 0..0 };
        Self { radius: kernel.radius(), weights: zeros.into_iter().chain(weights).chain(zeros).collect(), dense }
    }

    /// Fills columns of some rows, which are `width` long, from a block of a strip. It begins `y` rows and one radius
    /// above them.
    #[inline(always)]
    fn filter(&self, strip: &Strip, block: usize, y: usize, columns: Range<usize>, width: usize, out: &mut [f32]) {
        let rows = &strip.rows[block * strip.height..][y..strip.height];
        let mut sums = [[0.0f64; COLUMNS]; TOGETHER];
        // A value of 0 changes no sum, whatever its weight.
        let used = &strip.blocks[block];
        let used = used.start.saturating_sub(y)..used.end.saturating_sub(y);
        let part = |from: usize, to: usize| from.max(used.start)..to.min(used.end);
        let Range { start, end } = self.dense;
        self.add::<true>(part(0, start), rows, &mut sums);
        self.add::<false>(part(start, end), rows, &mut sums);
        self.add::<true>(part(end, usize::MAX), rows, &mut sums);
        for ((out, sums), center) in out.chunks_mut(width).zip(sums).zip(&rows[self.radius..]) {
            let mut means = [0.0f32; COLUMNS];
            let mut is_nan = false;
            for (mean, sum) in means.iter_mut().zip(&sums) {
                *mean = *sum as f32;
                is_nan |= sum.is_nan();
            }
            if is_nan {
                keep(&mut means, center);
            }
            let out = &mut out[columns.clone()];
            if let Some(out) = out.first_chunk_mut() {
                *out = means;
            } else {
                begin(out, &means);
            }
        }
    }

    /// Adds values with their weights to the sums of all rows. If `SPARSE`, some of the weights may be 0.
    #[inline(always)]
    fn add<const SPARSE: bool>(
        &self,
        values: Range<usize>,
        strip: &[[f64; COLUMNS]],
        sums: &mut [[f64; COLUMNS]; TOGETHER],
    ) {
        if values.is_empty() {
            return;
        }
        let last = self.weights.len() + 1 - TOGETHER;
        let values = values.start.min(last)..values.end.min(last).min(strip.len());
        let weights = self.weights[values.start..].array_windows::<TOGETHER>();
        for (weights, values) in weights.zip(&strip[values.start.min(values.end)..values.end]) {
            for (sums, weight) in sums.iter_mut().zip(weights.iter().rev()) {
                // 0 times infinity would have no value.
                if SPARSE && *weight == 0.0 {
                    continue;
                }
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
    }
}

/// Returns values followed by zeros.
// Not inlined, since all copies would then be of any length.
#[cold]
#[inline(never)]
fn filled(values: &[f32]) -> [f32; COLUMNS] {
    let mut all = [0.0; COLUMNS];
    all[..values.len()].copy_from_slice(values);
    all
}

/// Writes the first of some values.
#[cold]
#[inline(never)]
fn begin(out: &mut [f32], values: &[f32; COLUMNS]) {
    out.copy_from_slice(&values[..out.len()]);
}

/// Keeps the centers where there is no mean, as of +∞ and −∞.
#[cold]
#[inline(never)]
fn keep(means: &mut [f32; COLUMNS], centers: &[f64; COLUMNS]) {
    for (mean, center) in means.iter_mut().zip(centers).filter(|(mean, _)| mean.is_nan()) {
        *mean = *center as f32;
    }
}

//! One-dimensional kernels, and separable filtering by one across and one down.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use trochoid_image::Window;

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
    pub(crate) weights: Vec<f32>,
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
        let mut weights = rest[..rest.len() - cut].to_vec();
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
/// Rows in one task for a thread.
const BATCH: usize = 16;

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
    let mut rows = vec![0.0; width * from.height()];
    let first = to.x0 - across.radius() as i64 - from.x0;
    let batches = rows.par_chunks_mut(width * BATCH).zip(samples.par_chunks(stride * BATCH));
    batches.for_each(|(rows, samples)| {
        let mut line = vec![0.0f64; across.weights.len() - 1 + width.next_multiple_of(LANES)];
        for (row, samples) in rows.chunks_mut(width).zip(samples.chunks(stride)) {
            if stop() {
                return;
            }
            for (value, x) in line.iter_mut().zip(first..) {
                *value = f64::from(samples[x.clamp(0, stride as i64 - 1) as usize]);
            }
            across.row(level, &line, row);
        }
    });
    let last = from.height() as i64 - 1;
    out.par_chunks_mut(width * BATCH).enumerate().for_each(|(batch, out)| {
        let y0 = to.y0 + (batch * BATCH) as i64;
        let mut taps: Vec<(f64, &[f32])> = Vec::with_capacity(down.weights.len());
        for (out, y) in out.chunks_mut(width).zip(y0..) {
            if stop() {
                return;
            }
            let row = |y: i64| {
                let start = (y - from.y0).clamp(0, last) as usize * width;
                &rows[start..start + width]
            };
            taps.clear();
            let weights = down.weights.iter().zip(y - down.radius() as i64..);
            taps.extend(weights.filter(|(w, _)| **w != 0.0).map(|(w, y)| (f64::from(*w), row(y))));
            column(level, &taps, row(y), out);
        }
    });
}

impl Kernel {
    /// Filters one row, from `line`, which begins one radius before it.
    fn row(&self, level: Level, line: &[f64], out: &mut [f32]) {
        let center = self.radius();
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            for (out, start) in out.chunks_mut(LANES).zip((0..).step_by(LANES)) {
                let mut sums = [0.0f64; LANES];
                for (weight, k) in self.weights.iter().zip(start..).filter(|(weight, _)| **weight != 0.0) {
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

/// Fills one row with the weighted sum of others; `center` is the middle one.
fn column(level: Level, taps: &[(f64, &[f32])], center: &[f32], out: &mut [f32]) {
    let whole = out.len() / LANES * LANES;
    let (blocks, rest) = out.split_at_mut(whole);
    dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
        for (out, start) in blocks.chunks_exact_mut(LANES).zip((0..).step_by(LANES)) {
            let mut sums = [0.0f64; LANES];
            for (weight, row) in taps {
                for (sum, value) in sums.iter_mut().zip(&row[start..start + LANES]) {
                    *sum += weight * f64::from(*value);
                }
            }
            for ((out, sum), value) in out.iter_mut().zip(sums).zip(&center[start..]) {
                *out = if sum.is_nan() { *value } else { sum as f32 };
            }
        }
    }));
    for (out, x) in rest.iter_mut().zip(whole..) {
        let sum = taps.iter().fold(0.0, |sum, (weight, row)| sum + weight * f64::from(row[x]));
        *out = if sum.is_nan() { center[x] } else { sum as f32 };
    }
}

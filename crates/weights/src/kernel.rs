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
    weights: Vec<f32>,
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
        let weights = side.iter().rev().copied().chain([center]).chain(side.iter().copied()).collect();
        #[cfg(test)]
        let weights = faulty(weights);
        Self { weights }
    }

    /// Returns the distance of the farthest pixel that has a weight.
    fn radius(&self) -> usize {
        self.weights.len() / 2
    }

    /// Returns the kernel for an image that is `length` pixels long. Everything farther away is the repeated pixel at
    /// the border, which takes those weights too. So no kernel is longer than twice the image.
    fn folded(&self, length: usize) -> Self {
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

#[cfg(test)]
thread_local! {
    /// Gives new kernels a negative lobe, so that tests can show that such a fault is detected.
    static LOBE: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

#[cfg(test)]
fn faulty(mut weights: Vec<f32>) -> Vec<f32> {
    if LOBE.get()
        && let [first, .., last] = &mut weights[..]
    {
        let taken = *first + *last + 0.25;
        (*first, *last) = (-0.125, -0.125);
        let center = weights.len() / 2;
        weights[center] += taken;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kernel: &Kernel) -> f64 {
        kernel.weights.iter().map(|w| f64::from(*w)).sum()
    }

    #[test]
    fn kernels_are_partitions() {
        for shape in [Shape::Gaussian, Shape::Box] {
            for size in [0.0, 1e-9, 0.1, 0.5, 1.0, 1.5, 2.75, 10.0, 333.3, 5000.0] {
                let kernel = Kernel::new(shape, size);
                assert_eq!(sum(&kernel), 1.0, "{shape:?} {size}");
                assert!(kernel.weights.iter().all(|w| *w >= 0.0 && (f64::from(*w) * ONE).fract() == 0.0));
                assert!(kernel.weights.iter().eq(kernel.weights.iter().rev()), "{shape:?} {size} is symmetric");
                assert!(kernel.radius() as i64 <= shape.radius(size));
                let truth = shape.reference(size);
                let cut = (truth.len() - kernel.weights.len()) / 2;
                for ((k, truth), found) in truth.iter().skip(cut).zip(&kernel.weights) {
                    // The center takes what the sides leave of 1.
                    let slack = if *k == 0 { 3.0 } else { 1.0 };
                    assert!((truth - f64::from(*found)).abs() <= slack / ONE, "{shape:?} {size} at {k}");
                }
                for length in [1, 2, 3, 7, 100, 100_000] {
                    let folded = kernel.folded(length);
                    assert_eq!(sum(&folded), 1.0);
                    assert!(folded.radius() < length.max(1) && folded.weights.len() % 2 == 1);
                }
            }
        }
        assert_eq!(Kernel::new(Shape::Box, 1.0).weights.len(), 3);
        assert_eq!(Kernel::new(Shape::Box, 0.5).weights, [0.25, 0.5, 0.25]);
    }

    /// A few pixels of extreme values.
    fn hostile(width: usize, height: usize) -> Vec<f32> {
        let values = [0.0, 1.0, f32::MAX, f32::MIN_POSITIVE, 1e-45, 3.0e38, 0.1, 1.0 + f32::EPSILON];
        (0..width * height).map(|i| values[(i * 7 + i / 3) % values.len()]).collect()
    }

    #[test]
    fn results_stay_between_the_values_and_constants_are_kept() {
        let window = Window::sized(23, 9);
        let image = hostile(23, 9);
        for (shape, size) in [(Shape::Gaussian, 0.7), (Shape::Gaussian, 40.0), (Shape::Box, 2.5), (Shape::Box, 99.0)] {
            let kernel = Kernel::new(shape, size);
            let mut out = vec![f32::NAN; image.len()];
            filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
            let radius = shape.radius(size);
            for (index, value) in out.iter().enumerate() {
                let (x, y) = ((index % 23) as i64, (index / 23) as i64);
                let near = |at: i64, end: i64| (at - radius).max(0)..(at + radius + 1).min(end);
                let seen: Vec<f32> = near(y, 9)
                    .flat_map(|y| near(x, 23).map(move |x| (x, y)))
                    .map(|(x, y)| image[(y * 23 + x) as usize])
                    .collect();
                let (low, high) = seen.iter().fold((f32::MAX, 0.0f32), |(low, high), v| (low.min(*v), high.max(*v)));
                assert!((low..=high).contains(value), "{shape:?} {size}: {value} of {low}..={high}");
            }
            for constant in [0.1, f32::MAX, 1e-45, 0.0, -7.3] {
                let image = vec![constant; image.len()];
                filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
                assert!(out.iter().all(|v| v.to_bits() == constant.to_bits()), "{shape:?} {size} of {constant}");
            }
        }
    }

    #[test]
    fn parts_have_the_bits_of_the_whole() {
        let whole = Window::sized(40, 11);
        let image: Vec<f32> = (0..40 * 11).map(|i| (i as f32 * 0.37).sin()).collect();
        for (shape, size) in [(Shape::Gaussian, 1.3), (Shape::Box, 6.25), (Shape::Gaussian, 30.0)] {
            let (kernel, radius) = (Kernel::new(shape, size), shape.radius(size));
            let mut expected = vec![0.0; image.len()];
            filter([&kernel, &kernel], whole, &image, whole, whole, &|| false, &mut expected);
            for to in [Window::new(0, 0, 1, 1), Window::new(3, 2, 29, 3), Window::new(17, 5, 40, 11)] {
                let from = Window::new(to.x0 - radius, to.y0 - radius, to.x1 + radius, to.y1 + radius).intersect(whole);
                let part = |window: Window, image: &[f32]| -> Vec<f32> {
                    let at = |x: i64, y: i64| image[(y * 40 + x) as usize];
                    (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| at(x, y))).collect()
                };
                let mut found = vec![0.0; to.area()];
                filter([&kernel, &kernel], from, &part(from, &image), whole, to, &|| false, &mut found);
                assert_eq!(found, part(to, &expected), "{shape:?} {size} over {to}");
            }
        }
    }

    #[test]
    fn infinities_spread_and_opposite_ones_keep_the_center() {
        let window = Window::sized(5, 1);
        let kernel = Kernel::new(Shape::Box, 1.0);
        let inf = f32::INFINITY;
        let mut out = [0.0; 5];
        filter([&kernel, &kernel], window, &[1.0, 2.0, inf, 4.0, -inf], window, window, &|| false, &mut out);
        assert_eq!(out[1..], [inf, inf, 4.0, -inf]);
    }

    #[test]
    fn a_negative_lobe_is_noticed() {
        LOBE.set(true);
        let kernel = Kernel::new(Shape::Gaussian, 1.0);
        LOBE.set(false);
        assert_eq!(sum(&kernel), 1.0);
        let window = Window::sized(16, 4);
        let image: Vec<f32> = (0..64).map(|i| if i % 16 < 8 { 0.0 } else { 1.0 }).collect();
        let mut out = vec![0.0; 64];
        filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
        let hull = crate::Hull::new(&[[0.0; 3], [1.0; 3]]);
        let (exits, worst) = hull.exits(&out, &out, &out, hull.margin(2));
        assert!(exits > 0 && worst > 0.05, "{exits} pixels, by {worst}");
    }
}

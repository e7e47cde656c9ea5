//! Bounding boxes of control colors.

use fearless_simd::{Level, Simd, dispatch};
use trochoid_image::Rgb;

/// Number of pixels that are compared with the box together.
const BLOCK: usize = 128;

/// Bounding box of control colors, which per-channel operations cannot leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxHull {
    min: Rgb,
    max: Rgb,
}

impl Default for BoxHull {
    /// The empty box.
    fn default() -> Self {
        Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] }
    }
}

impl BoxHull {
    /// Makes the bounding box of a set of points, without those that are not finite.
    #[must_use]
    pub fn new(points: &[Rgb]) -> Self {
        let mut hull = Self::default();
        hull.add(points);
        hull
    }

    /// Extends the box to more points, without those that are not finite.
    pub fn add(&mut self, points: &[Rgb]) {
        for point in points.iter().filter(|point| point.iter().all(|v| v.is_finite())) {
            self.min = std::array::from_fn(|i| self.min[i].min(point[i]));
            self.max = std::array::from_fn(|i| self.max[i].max(point[i]));
        }
    }

    /// Returns the bounding box of two boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let merge = |a: Rgb, b: Rgb, pick: fn(f32, f32) -> f32| std::array::from_fn(|i| pick(a[i], b[i]));
        Self { min: merge(self.min, other.min, f32::min), max: merge(self.max, other.max, f32::max) }
    }

    /// Returns the smallest value of each channel; +∞ if the box is empty.
    #[must_use]
    pub fn min(&self) -> Rgb {
        self.min
    }

    /// Returns the largest value of each channel; −∞ if the box is empty.
    #[must_use]
    pub fn max(&self) -> Rgb {
        self.max
    }

    /// Returns the largest distance of any channel from the box, if it exceeds the margin (≥ 0).
    ///
    /// Exact at margin 0. A pixel that is not finite is an exit at distance +∞, and so is every pixel if the box is
    /// empty.
    #[must_use]
    pub fn exit(&self, pixel: &[f32; 3], margin: f64) -> Option<f64> {
        if !pixel.iter().all(|v| v.is_finite()) {
            return Some(f64::INFINITY);
        }
        let mut distance = 0.0_f64;
        for ((&v, &min), &max) in pixel.iter().zip(&self.min).zip(&self.max) {
            let (v, min, max) = (f64::from(v), f64::from(min), f64::from(max));
            distance = distance.max(min - v).max(v - max);
        }
        (distance > margin).then_some(distance)
    }

    /// Counts the pixels of a row that are outside by more than the margin (≥ 0), and returns the count and the largest
    /// distance (0 if the count is 0).
    ///
    /// # Panics
    ///
    /// If the three channels differ in length.
    #[must_use]
    pub fn exits(&self, r: &[f32], g: &[f32], b: &[f32], margin: f64) -> (u64, f64) {
        assert!(r.len() == g.len() && g.len() == b.len(), "channels of equal length");
        let level = Level::new();
        let mut count = 0;
        let mut worst = 0.0_f64;
        for ((r, g), b) in r.chunks(BLOCK).zip(g.chunks(BLOCK)).zip(b.chunks(BLOCK)) {
            if dispatch!(level, simd => self.holds(simd, [r, g, b])) {
                continue;
            }
            for ((&r, &g), &b) in r.iter().zip(g).zip(b) {
                if let Some(distance) = self.exit(&[r, g, b], margin) {
                    count += 1;
                    worst = worst.max(distance);
                }
            }
        }
        (count, worst)
    }

    /// Whether all pixels are inside of the box.
    fn holds<S: Simd>(&self, simd: S, channels: [&[f32]; 3]) -> bool {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut all = true;
                for ((channel, &min), &max) in channels.iter().zip(&self.min).zip(&self.max) {
                    for &v in *channel {
                        // False for NaN as well.
                        all &= (v >= min) & (v <= max);
                    }
                }
                all
            },
        )
    }
}

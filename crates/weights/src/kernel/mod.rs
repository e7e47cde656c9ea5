//! One-dimensional kernels, and separable filtering by one across and one down.

mod filter;
mod means;
mod runs;

pub use filter::filter;

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

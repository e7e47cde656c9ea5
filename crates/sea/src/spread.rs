//! The kernel of the non-uniform transform, and the lines over which it spreads waves.

use crate::lanes::Real;
use std::f64::consts::PI;

/// The exponential of a semicircle, φ(v) = exp(β(√(1−v²) − 1)) on |v| < 1.
///
/// Source: Barnett, Magland and af Klinteberg, *A parallel nonuniform fast Fourier transform library based on an
/// "exponential of semicircle" kernel*, 2019.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    /// Number of lines that it covers.
    pub(crate) width: usize,
    /// Least ratio of a transform's length to that of the output.
    pub(crate) oversampling: f64,
    beta: f64,
}

impl Kernel {
    /// Sets β from the bandwidth that oversampling leaves, 2 % below it, where errors are smallest: 2.31 w at 2.
    pub(crate) fn new(width: usize, oversampling: f64) -> Self {
        Self { width, oversampling, beta: 0.98 * PI * width as f64 * (1.0 - 0.5 / oversampling) }
    }

    /// Returns its value at a distance in lines from the center; beyond its edge, the value at the edge.
    pub(crate) fn value(&self, offset: f64) -> f64 {
        let v = offset / (self.width as f64 / 2.0);
        libm::exp(self.beta * (libm::sqrt((1.0 - v * v).max(0.0)) - 1.0))
    }

    /// Computes its values on the lines from `first` on, around `at`.
    pub(crate) fn weights<T: Real>(&self, first: i64, at: f64, out: &mut [T]) {
        for (line, out) in (first..).zip(out) {
            *out = T::of(self.value(line as f64 - at));
        }
    }

    /// Returns the Fourier transform of the kernel at the distance `offset` from the center of the outputs.
    ///
    /// v = sin α makes (w/2)∫φ(v) cos(πwv·offset/length) dv smooth up to its ends, where it is e^(−β), so that the
    /// midpoint rule converges faster than any power.
    pub(crate) fn transform(&self, offset: f64, length: usize) -> f64 {
        const NODES: usize = 64;
        let scale = PI * self.width as f64 * offset / length as f64;
        // Even in α: half the nodes.
        let sum: f64 = (0..NODES)
            .map(|node| {
                let (sin, cos) = libm::sincos((node as f64 + 0.5) * (PI / 2.0 / NODES as f64));
                libm::exp(self.beta * (cos - 1.0)) * cos * libm::cos(scale * sin)
            })
            .sum();
        self.width as f64 * sum * (PI / 2.0 / NODES as f64)
    }
}

/// A wave in terms of the lines of the transform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TransformWave {
    /// Index in the frame.
    pub(crate) wave: usize,
    /// Whether the wave was reversed, so that it travels toward +x; its amplitude is then the conjugate.
    pub(crate) turned: bool,
    /// Position among the lines, along x (≥ 0) and z.
    pub(crate) at: [f64; 2],
    /// First line of its kernel.
    pub(crate) first: [i64; 2],
    /// e^{iθ} at the center of the grid, times the share that the footprint leaves.
    pub(crate) phase: [f64; 2],
}

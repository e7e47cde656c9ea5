//! The kernel of the non-uniform transform, and where it puts waves.

use crate::lanes::Real;
use std::f64::consts::PI;

/// The exponential of a semicircle, φ(v) = exp(β(√(1−v²) − 1)) on |v| < 1.
///
/// Source: Barnett, Magland and af Klinteberg, *A parallel nonuniform fast Fourier transform library based on an
/// "exponential of semicircle" kernel*, 2019.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    /// Lines that it covers.
    pub(crate) width: usize,
    /// How many times as long as the output a transform is at least.
    pub(crate) oversampling: f64,
    beta: f64,
}

impl Kernel {
    /// β by the bandwidth that oversampling leaves, 2 % below it, which is where errors are least: 2.31 w at 2.
    pub(crate) fn new(width: usize, oversampling: f64) -> Self {
        Self { width, oversampling, beta: 0.98 * PI * width as f64 * (1.0 - 0.5 / oversampling) }
    }

    /// Its value so many lines away from the center; beyond its edge that there.
    pub(crate) fn value(&self, offset: f64) -> f64 {
        let v = offset / (self.width as f64 / 2.0);
        libm::exp(self.beta * (libm::sqrt((1.0 - v * v).max(0.0)) - 1.0))
    }

    /// Its values on the lines from `first` on, around `at`.
    pub(crate) fn weights<T: Real>(&self, first: i64, at: f64, out: &mut [T]) {
        for (line, out) in (first..).zip(out) {
            *out = T::of(self.value(line as f64 - at));
        }
    }

    /// Fourier transform of the kernel at the distance `offset` from the center of the outputs.
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

/// A wave as seen from the lines of the transform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    /// Its index in the frame.
    pub(crate) wave: usize,
    /// Whether the wave was turned round, so that it travels toward +x; its amplitude is then the conjugate.
    pub(crate) turned: bool,
    /// Where it lies among the lines, along x (≥ 0) and z.
    pub(crate) at: [f64; 2],
    /// First line of its kernel.
    pub(crate) first: [i64; 2],
    /// e^{iθ} at the center of the grid, times what the footprint leaves.
    pub(crate) phase: [f64; 2],
}

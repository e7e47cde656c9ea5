use std::f64::consts::TAU;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use super::Burst;

/// A guide for many bursts: copies side by side, with Gaussian noise on every parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guide {
    /// Burst that is copied.
    pub burst: Burst,
    /// Number of copies.
    pub count: usize,
    /// Width in meters over which they are placed side by side, across the line from the path's start to its end.
    pub width: f64,
    /// Standard deviation of each coordinate of each control point, in meters.
    pub jitter: f64,
    /// Standard deviation of offsets, in seconds. Small values make crest lines, large ones single cones.
    pub jitter_time: f64,
    /// Relative standard deviation of durations, peaks and both radii.
    pub jitter_size: f64,
    /// Random seed.
    pub seed: u64,
}

/// Least factor by which noise may scale a duration, a peak or a radius.
const LEAST: f64 = 0.1;

impl Guide {
    /// Returns the copies, each from its own random numbers: a larger count adds copies and changes only the lateral
    /// positions of the others.
    pub fn bursts(&self) -> Vec<Burst> {
        let [start, .., end] = self.burst.path;
        let (dx, dz) = (end[0] - start[0], end[1] - start[1]);
        let length = libm::hypot(dx, dz);
        let across = if length > 0.0 { [-dz / length, dx / length] } else { [0.0, 1.0] };
        (0..self.count)
            .map(|index| {
                let mut noise = Noise::new(self.seed, index as u64);
                let place = if self.count > 1 { index as f64 / (self.count - 1) as f64 - 0.5 } else { 0.0 };
                let lane = self.width * place;
                let path = self.burst.path.map(|[x, z]| {
                    let moved = [x + across[0] * lane, z + across[1] * lane];
                    moved.map(|value| value + self.jitter * noise.next())
                });
                let mut scaled = |value: f64| value * (1.0 + self.jitter_size * noise.next()).max(LEAST);
                Burst {
                    path,
                    duration: scaled(self.burst.duration),
                    peak: scaled(self.burst.peak),
                    influence: self.burst.influence.map(&mut scaled),
                    offset: self.burst.offset + self.jitter_time * noise.next(),
                    lane: self.burst.lane + lane,
                    ..self.burst
                }
            })
            .collect()
    }
}

/// Normally distributed numbers of one index.
struct Noise(Pcg64);

impl Noise {
    fn new(seed: u64, index: u64) -> Self {
        let state = (u128::from(seed) << 64) | u128::from(index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Self(Pcg64::new(state, u128::from(index)))
    }

    fn next(&mut self) -> f64 {
        let mut unit = || ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        libm::sqrt(-2.0 * libm::log(unit())) * libm::cos(TAU * unit())
    }
}

//! The plain f64 sum of waves at eight points at a time, with the same bits.

use super::birth::Water;
use super::functions::sincos;
use crate::SeaFrame;
use crate::kernel64::ROUNDER;
use crate::wave::attenuation;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use std::f64::consts::TAU;

/// Number of points.
pub(super) const LANES: usize = 8;

/// A sea at one time under one footprint: what [`SeaFrame::evaluate`] computes for each point anew is computed once.
pub(super) struct PlainSum {
    waves: Vec<PlainWave>,
    level: Level,
}

/// A wave under the footprint.
struct PlainWave {
    /// Turns per meter along x and z, and turns at the origin.
    turns: [f64; 3],
    /// Factors of sin θ in Δx, Δz and ∂Δy/∂t.
    sines: [f64; 3],
    /// Factors of cos θ in Δy, ∂Δx/∂t and ∂Δz/∂t.
    cosines: [f64; 3],
}

impl PlainSum {
    /// Prepares the sum for a footprint in meters.
    pub(super) fn new(frame: &SeaFrame, footprint: f64) -> Self {
        let wave = |(wave, turns): (&crate::Wave, [f64; 3])| {
            let share = attenuation(wave.wave_number(), footprint);
            let ([x, z], a, h) = (wave.direction, wave.amplitude * share, wave.horizontal * share);
            let speed = wave.angular_frequency;
            PlainWave { turns, sines: [h * x, h * z, a * speed], cosines: [a, h * x * speed, h * z * speed] }
        };
        Self { waves: frame.plain_waves().map(wave).collect(), level: Level::new() }
    }

    /// Returns the states at up to eight rest points of a sea that rests at world y = `level`.
    pub(super) fn at(&self, rests: &[[f64; 2]], level: f64) -> Vec<Water> {
        let lanes = |axis: usize| std::array::from_fn(|lane| rests.get(lane).map_or(0.0, |rest| rest[axis]));
        let [x, z]: [[f64; LANES]; 2] = [lanes(0), lanes(1)];
        let mut sums = [[0.0; LANES]; 6];
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || self.add(simd, x, z, &mut sums)));
        let water = |(lane, [x, z]): (usize, &[f64; 2])| {
            let [dx, dy, dz, vx, vy, vz] = sums.map(|sum| sum[lane]);
            Water { position: [x + dx, level + dy, z + dz], velocity: [vx, vy, vz] }
        };
        rests.iter().enumerate().map(water).collect()
    }

    /// Adds the waves in the order of the plain sum, and by its operations.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, x: [f64; LANES], z: [f64; LANES], sums: &mut [[f64; LANES]; 6]) {
        let (x, z) = (f64x8::load_array(simd, x), f64x8::load_array(simd, z));
        let mut total = [f64x8::splat(simd, 0.0); 6];
        for PlainWave { turns, sines, cosines } in &self.waves {
            let turns = x * turns[0] + z * turns[1] + turns[2];
            let reduced = turns - ((turns + ROUNDER) - ROUNDER);
            let [sin, cos] = sincos(simd, reduced * TAU);
            total[0] -= sin * sines[0];
            total[1] += cos * cosines[0];
            total[2] -= sin * sines[1];
            total[3] += cos * cosines[1];
            total[4] += sin * sines[2];
            total[5] += cos * cosines[2];
        }
        for (sum, total) in sums.iter_mut().zip(total) {
            *sum = total.to_array();
        }
    }
}

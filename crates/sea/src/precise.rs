//! The f64 sum of [`SeaFrame::evaluate`] in vectors over the waves, for those who ask at millions of points.

use crate::fields::Sample;
use crate::frame::SeaFrame;
use fearless_simd::{Level, Simd, dispatch};
use std::f64::consts::{LN_2, LOG2_E, TAU};

/// Waves that are summed side by side.
const LANES: usize = 8;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest whole number, ties to even, exactly.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Exponent from which on a wave is not added: 1e-17 of it is left.
const CUT: f64 = 40.0;

/// ln 2 in two parts, of which the first has so few bits that its multiples by whole numbers below 2²⁰ are exact.
const LN_2_HIGH: f64 = f64::from_bits(LN_2.to_bits() & !0x3_ffff_ffff);
const LN_2_LOW: f64 = 1.428_606_820_309_417_2e-6 - (LN_2_HIGH - 0.693_145_751_953_125);

/// One array for each factor, in the order of falling wavelength and filled up with waves of height 0.
#[derive(Clone, Debug)]
struct Waves {
    turns: [Vec<f64>; 2],
    origin: Vec<f64>,
    direction: [Vec<f64>; 2],
    amplitude: Vec<f64>,
    horizontal: Vec<f64>,
    number: Vec<f64>,
}

/// A sea at one time, as [`SeaFrame`], for fast evaluation in f64.
///
/// ```
/// use trochoid_sea::{GerstnerSpectrum, PreciseSea, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 200, ..GerstnerSpectrum::default() }.waves()?);
/// let frame = sea.at(3.0);
/// let (fast, slow) = (PreciseSea::new(&frame).evaluate([7.0, -2.0], 0.4), frame.evaluate([7.0, -2.0], 0.4));
/// assert!((fast.displacement[1] - slow.displacement[1]).abs() < 1e-13);
/// # Ok::<(), trochoid_sea::SpectrumError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PreciseSea {
    waves: Waves,
    level: Level,
}

/// The sums over the waves of one lane.
#[derive(Clone, Copy, Default)]
struct Sums {
    displacement: [f64; 3],
    slope: [f64; 2],
    strain: [f64; 3],
    variance: f64,
}

impl PreciseSea {
    /// The waves of a sea at its time.
    pub fn new(frame: &SeaFrame) -> Self {
        let count = frame.sorted.len().next_multiple_of(LANES);
        let column =
            |of: &dyn Fn(usize) -> f64| (0..count).map(|i| if i < frame.len() { of(i) } else { 0.0 }).collect();
        let waves = Waves {
            turns: [0, 1].map(|axis| column(&|i| frame.phases.turns(i)[axis])),
            origin: column(&|i| frame.phases.of(i, [0.0, 0.0])),
            direction: [0, 1].map(|axis| column(&|i| frame.sorted[i].direction[axis])),
            amplitude: column(&|i| frame.sorted[i].amplitude),
            horizontal: column(&|i| frame.sorted[i].horizontal),
            number: column(&|i| frame.sorted[i].wave_number()),
        };
        Self { waves, level: Level::new() }
    }

    /// The surface at a rest point (x₀, z₀) in meters under a footprint in meters; without velocities.
    ///
    /// Within 1e-14 of the sum of the waves' own sizes from [`SeaFrame::evaluate`].
    pub fn evaluate(&self, rest: [f64; 2], footprint: f64) -> Sample {
        let filter = footprint * footprint / 8.0;
        let numbers = &self.waves.number;
        let left = numbers.partition_point(|k| *k != 0.0 && k * k * filter <= CUT).next_multiple_of(LANES);
        let mut sums = [Sums::default(); LANES];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || self.waves.add(rest, filter, left, &mut sums)
        ));
        let mut sample = Sample::default();
        for sums in sums {
            for axis in 0..3 {
                sample.displacement[axis] += sums.displacement[axis];
                sample.strain[axis] += sums.strain[axis];
            }
            sample.slope[0] += sums.slope[0];
            sample.slope[1] += sums.slope[1];
            sample.slope_variance += sums.variance;
        }
        let rest = self.waves.amplitude[left..].iter().zip(&numbers[left..]);
        sample.slope_variance += rest.map(|(amplitude, k)| (amplitude * k) * (amplitude * k) / 2.0).sum::<f64>();
        sample
    }
}

impl Waves {
    #[inline(always)]
    fn add(&self, [x0, z0]: [f64; 2], filter: f64, left: usize, sums: &mut [Sums; LANES]) {
        let mut total = [[0.0; LANES]; 9];
        for start in (0..left).step_by(LANES) {
            let lanes = start..start + LANES;
            let (tx, tz) = (&self.turns[0][lanes.clone()], &self.turns[1][lanes.clone()]);
            let (dx, dz) = (&self.direction[0][lanes.clone()], &self.direction[1][lanes.clone()]);
            let (amplitude, horizontal) = (&self.amplitude[lanes.clone()], &self.horizontal[lanes.clone()]);
            let (number, origin) = (&self.number[lanes.clone()], &self.origin[lanes]);
            for i in 0..LANES {
                let turns = tx[i] * x0 + tz[i] * z0 + origin[i];
                let (sin, cos) = sincos(turns - ((turns + ROUNDER) - ROUNDER));
                let share = exp_neg(number[i] * number[i] * filter);
                let (a, h) = (amplitude[i] * share, horizontal[i] * share);
                let (hk, ak) = (h * number[i], a * number[i]);
                let whole = amplitude[i] * number[i];
                total[0][i] -= h * dx[i] * sin;
                total[1][i] += a * cos;
                total[2][i] -= h * dz[i] * sin;
                total[3][i] -= ak * dx[i] * sin;
                total[4][i] -= ak * dz[i] * sin;
                total[5][i] -= hk * dx[i] * dx[i] * cos;
                total[6][i] -= hk * dx[i] * dz[i] * cos;
                total[7][i] -= hk * dz[i] * dz[i] * cos;
                total[8][i] += whole * whole / 2.0 * (1.0 - share * share);
            }
        }
        for (i, sums) in sums.iter_mut().enumerate() {
            let of = |sum: usize| total[sum][i];
            sums.displacement = [of(0), of(1), of(2)];
            sums.slope = [of(3), of(4)];
            sums.strain = [of(5), of(6), of(7)];
            sums.variance = of(8);
        }
    }
}

/// sin and cos of −½…½ turn, to 1e-16: their series on an eighth of a turn to each side, in its quadrant.
#[inline(always)]
fn sincos(turns: f64) -> (f64, f64) {
    let quadrant = (4.0 * turns + ROUNDER) - ROUNDER;
    let x = (turns - 0.25 * quadrant) * TAU;
    let x2 = x * x;
    let mut sin = -1.0 / 1_307_674_368_000.0;
    for factor in SINE {
        sin = sin * x2 + factor;
    }
    let mut cos = 1.0 / 20_922_789_888_000.0;
    for factor in COSINE {
        cos = cos * x2 + factor;
    }
    let sin = sin * x;
    let is_odd = quadrant * quadrant == 1.0;
    let sign = 1.0 - quadrant.abs();
    (if is_odd { quadrant * cos } else { sign * sin }, if is_odd { -quadrant * sin } else { sign * cos })
}

/// ±1/n! for n = 13, 11, … 1, and for n = 14, 12, … 0.
const SINE: [f64; 7] =
    [1.0 / 6_227_020_800.0, -1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5_040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0];
const COSINE: [f64; 8] = [
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -0.5,
    1.0,
];

/// e⁻ˣ for 0 ≤ x ≤ 700, to 1e-15 of itself.
#[inline(always)]
fn exp_neg(x: f64) -> f64 {
    let halvings = (x * LOG2_E + ROUNDER) - ROUNDER;
    let rest = -((x - halvings * LN_2_HIGH) - halvings * LN_2_LOW);
    let mut power = 1.0 / 6_227_020_800.0;
    for factor in EXPONENTIAL {
        power = power * rest + factor;
    }
    // 2 to the power of −halvings: its exponent's bits are the lowest of the rounded sum.
    power * f64::from_bits((1023.0 - halvings + ROUNDER).to_bits() << 52)
}

/// 1/n! for n = 12, 11, … 0.
const EXPONENTIAL: [f64; 13] = [
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_exact_to_rounding() {
        for step in -5000..=5000 {
            let turns = f64::from(step) / 1e4;
            let (sin, cos) = sincos(turns);
            assert!((sin - libm::sin(TAU * turns)).abs() < 4e-16 && (cos - libm::cos(TAU * turns)).abs() < 4e-16);
        }
        for step in 0..7000 {
            let x = f64::from(step) / 10.0 + 0.013;
            assert!((exp_neg(x) / libm::exp(-x) - 1.0).abs() < 2e-15, "{x}");
        }
        assert_eq!(exp_neg(0.0), 1.0);
    }
}

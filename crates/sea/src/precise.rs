//! The f64 sum of [`SeaFrame::evaluate`], vectorized over the waves, for evaluation at millions of points.

use crate::fields::Sample;
use crate::frame::SeaFrame;
use fearless_simd::{Level, Simd, dispatch};
use std::f64::consts::{LN_2, LOG2_E, TAU};

/// Number of waves that are summed side by side.
const LANES: usize = 8;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest integer, ties to even, exactly.
pub(crate) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Exponent from which a wave is not added: 1e-17 of it is left.
const CUT: f64 = 40.0;

/// Largest exponent for which e⁻ˣ is computed.
pub(crate) const MOST: f64 = 700.0;

/// ln 2 in two parts; the first has so few bits that its multiples by integers below 2²⁰ are exact.
const LN_2_HIGH: f64 = f64::from_bits(LN_2.to_bits() & !0x3_ffff_ffff);
const LN_2_LOW: f64 = 1.428_606_820_309_417_2e-6 - (LN_2_HIGH - 0.693_145_751_953_125);

/// One array per factor, in the order of falling wavelength, padded with waves of height 0.
#[derive(Clone, Debug)]
struct Waves {
    turns: [Vec<f64>; 2],
    origin: Vec<f64>,
    direction: [Vec<f64>; 2],
    amplitude: Vec<f64>,
    horizontal: Vec<f64>,
    number: Vec<f64>,
}

/// A sea at one time, like [`SeaFrame`], for fast evaluation in f64.
///
/// ```
/// use trochoid_sea::{GerstnerSpectrum, PreciseSea, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 200, ..GerstnerSpectrum::default() }.waves()?);
/// let frame = sea.at(3.0);
/// let (fast, slow) = (PreciseSea::new(&frame).evaluate([7.0, -2.0], 0.4), frame.evaluate([7.0, -2.0], 0.4));
/// assert!((fast.sample.displacement[1] - slow.displacement[1]).abs() < 1e-13);
/// # Ok::<(), trochoid_sea::SpectrumError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PreciseSea {
    waves: Waves,
    level: Level,
}

/// The sea at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Precise {
    /// Same as in [`SeaFrame::evaluate`], without velocities.
    pub sample: Sample,
    /// Derivative of the displacement by the footprint, in meters per meter.
    pub by_footprint: [f64; 3],
}

/// Second derivatives of the displacement at a point, by the rest point x, z and the footprint f, in 1/m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bends {
    /// ∂²/∂x², ∂²/∂x∂z and ∂²/∂z².
    pub by_rest: [[f64; 3]; 3],
    /// ∂²/∂x∂f and ∂²/∂z∂f.
    pub by_footprint: [[f64; 3]; 2],
}

/// Number of sums of [`Precise`], and of these together with [`Bends`].
const SUMS: usize = 12;
const ALL_SUMS: usize = SUMS + 15;

impl PreciseSea {
    /// Prepares the waves of a sea at its time.
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

    /// Returns the surface at a rest point (x₀, z₀) in meters under a footprint in meters.
    ///
    /// It is within 1e-14 of the sum of the waves' own sizes from [`SeaFrame::evaluate`].
    pub fn evaluate(&self, rest: [f64; 2], footprint: f64) -> Precise {
        let (sums, left) = self.sums::<SUMS>(rest, footprint);
        self.precise(sums, footprint, left)
    }

    /// Returns the same with the second derivatives.
    pub fn bent(&self, rest: [f64; 2], footprint: f64) -> (Precise, Bends) {
        let (sums, left) = self.sums::<ALL_SUMS>(rest, footprint);
        let mut bends = Bends::default();
        let (by_rest, by_footprint) = sums[SUMS..].split_at(9);
        bends.by_rest.as_flattened_mut().copy_from_slice(by_rest);
        for (bend, sum) in bends.by_footprint.as_flattened_mut().iter_mut().zip(by_footprint) {
            *bend = -footprint / 4.0 * sum;
        }
        (self.precise(sums, footprint, left), bends)
    }

    /// Returns all sums, and how many waves the footprint leaves.
    fn sums<const N: usize>(&self, rest: [f64; 2], footprint: f64) -> ([f64; N], usize) {
        let filter = footprint * footprint / 8.0;
        let numbers = &self.waves.number;
        let left = numbers.partition_point(|k| *k != 0.0 && k * k * filter <= CUT).next_multiple_of(LANES);
        let mut sums = [[0.0; LANES]; N];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || self.waves.add(rest, filter, left, &mut sums)
        ));
        (sums.map(|lanes| lanes.iter().sum()), left)
    }

    fn precise<const N: usize>(&self, sums: [f64; N], footprint: f64, left: usize) -> Precise {
        let Waves { amplitude, number, .. } = &self.waves;
        let lost = amplitude[left..].iter().zip(&number[left..]).map(|(a, k)| (a * k) * (a * k) / 2.0).sum::<f64>();
        let sample = Sample {
            displacement: [sums[0], sums[1], sums[2]],
            slope: [sums[3], sums[4]],
            strain: [sums[5], sums[6], sums[7]],
            slope_variance: sums[8] + lost,
            ..Sample::default()
        };
        // The share is exp(−k²f²/8).
        Precise { sample, by_footprint: [9, 10, 11].map(|sum| -footprint / 4.0 * sums[sum]) }
    }

    /// Returns limits of the displacement and its first to fifth derivatives by the rest point, in any direction,
    /// under a footprint in meters and for all phases: Σ max(a, |h|)·kⁿ·exp(−k²f²/8), in m to 1/m⁴.
    pub fn most(&self, footprint: f64) -> [f64; 6] {
        let Waves { amplitude, horizontal, number, .. } = &self.waves;
        let mut most = [0.0; 6];
        for ((amplitude, horizontal), k) in amplitude.iter().zip(horizontal).zip(number) {
            let mut derivative =
                amplitude.abs().max(horizontal.abs()) * libm::exp(-k * k * footprint * footprint / 8.0);
            for most in &mut most {
                *most += derivative;
                derivative *= k;
            }
        }
        most
    }
}

impl Waves {
    #[inline(always)]
    fn add<const N: usize>(&self, [x0, z0]: [f64; 2], filter: f64, left: usize, total: &mut [[f64; LANES]; N]) {
        for start in (0..left).step_by(LANES) {
            let lanes = start..start + LANES;
            let (tx, tz) = (&self.turns[0][lanes.clone()], &self.turns[1][lanes.clone()]);
            let (dx, dz) = (&self.direction[0][lanes.clone()], &self.direction[1][lanes.clone()]);
            let (amplitude, horizontal) = (&self.amplitude[lanes.clone()], &self.horizontal[lanes.clone()]);
            let (number, origin) = (&self.number[lanes.clone()], &self.origin[lanes]);
            for i in 0..LANES {
                let turns = tx[i] * x0 + tz[i] * z0 + origin[i];
                let (sin, cos) = sincos(turns - ((turns + ROUNDER) - ROUNDER));
                // In the same vector as a wave that is left there may be one that is far too short.
                let share = exp_neg((number[i] * number[i] * filter).min(MOST));
                let (a, h) = (amplitude[i] * share, horizontal[i] * share);
                let (hk, ak) = (h * number[i], a * number[i]);
                let whole = amplitude[i] * number[i];
                let moved = [-h * dx[i] * sin, a * cos, -h * dz[i] * sin];
                for axis in 0..3 {
                    total[axis][i] += moved[axis];
                    total[9 + axis][i] += moved[axis] * number[i] * number[i];
                }
                total[3][i] -= ak * dx[i] * sin;
                total[4][i] -= ak * dz[i] * sin;
                total[5][i] -= hk * dx[i] * dx[i] * cos;
                total[6][i] -= hk * dx[i] * dz[i] * cos;
                total[7][i] -= hk * dz[i] * dz[i] * cos;
                total[8][i] += whole * whole / 2.0 * (1.0 - share * share);
                if N == ALL_SUMS {
                    // Two derivatives multiply by −k²; one derivative of the wave turned by a quarter multiplies by
                    // k.
                    let (kx, kz) = (number[i] * dx[i], number[i] * dz[i]);
                    let turned = [-h * dx[i] * cos, -a * sin, -h * dz[i] * cos];
                    let share = number[i] * number[i];
                    for axis in 0..3 {
                        for (sum, factor) in [kx * kx, kx * kz, kz * kz].into_iter().enumerate() {
                            total[SUMS + 3 * sum + axis][i] -= factor * moved[axis];
                        }
                        for (sum, factor) in [kx * share, kz * share].into_iter().enumerate() {
                            total[SUMS + 9 + 3 * sum + axis][i] += factor * turned[axis];
                        }
                    }
                }
            }
        }
    }
}

/// Returns sin and cos of −½…½ turn, to 1e-16: their series over an eighth of a turn to each side, in its quadrant.
#[inline(always)]
pub(crate) fn sincos(turns: f64) -> (f64, f64) {
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

/// Returns e⁻ˣ for 0 ≤ x ≤ [`MOST`], with a relative error of 1e-15.
#[inline(always)]
pub(crate) fn exp_neg(x: f64) -> f64 {
    let halvings = (x * LOG2_E + ROUNDER) - ROUNDER;
    let rest = -((x - halvings * LN_2_HIGH) - halvings * LN_2_LOW);
    let mut power = 1.0 / 6_227_020_800.0;
    for factor in EXPONENTIAL {
        power = power * rest + factor;
    }
    // 2 to the power of −halvings: the bits of its exponent are the lowest bits of the rounded sum.
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

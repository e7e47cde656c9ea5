//! The f64 sum of [`SeaFrame::evaluate`], vectorized over the waves, for evaluation at millions of points.

use crate::fields::Sample;
use crate::frame::SeaFrame;
use crate::kernel64::{LANES, halved, sincos};
use crate::wave::Wave;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use std::f64::consts::LOG2_E;

/// Exponent from which a wave is not added: 2e-15 of it is left.
const CUT: f64 = 34.0;

/// Factors of eight waves, or fewer and waves of height 0, side by side.
#[derive(Clone, Debug)]
struct Waves {
    /// Half turns per meter along x and z, and half turns at the origin.
    turns: [[f64; LANES]; 2],
    origin: [f64; LANES],
    amplitude: [f64; LANES],
    /// Horizontal amplitude along x and z.
    horizontal: [[f64; LANES]; 2],
    /// Wave number k along x and z, and k².
    numbers: [[f64; LANES]; 2],
    square: [f64; LANES],
    /// Slope variance (a·k)²/2.
    variance: [f64; LANES],
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
    /// By falling wavelength.
    waves: Vec<Waves>,
    /// Slope variance of all waves from each of these on, and 0 at the end.
    lost: Vec<f64>,
    /// Wave number of each wave, and the larger one of its amplitudes' sizes.
    numbers: Vec<f64>,
    sizes: Vec<f64>,
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

/// Number of sums of [`Precise`].
const SUMS: usize = 12;

impl PreciseSea {
    /// Prepares the waves of a sea at its time.
    pub fn new(frame: &SeaFrame) -> Self {
        let wave = |index: usize| &frame.sorted[index];
        let waves: Vec<Waves> = (0..frame.len())
            .step_by(LANES)
            .map(|first| {
                let lanes = |of: &dyn Fn(usize) -> f64| {
                    std::array::from_fn(|lane| if first + lane < frame.len() { of(first + lane) } else { 0.0 })
                };
                Waves {
                    turns: [0, 1].map(|axis| lanes(&|i| 2.0 * frame.phases.turns(i)[axis])),
                    origin: lanes(&|i| 2.0 * frame.phases.of(i, [0.0, 0.0])),
                    amplitude: lanes(&|i| wave(i).amplitude),
                    horizontal: [0, 1].map(|axis| lanes(&|i| wave(i).horizontal * wave(i).direction[axis])),
                    numbers: [0, 1].map(|axis| lanes(&|i| wave(i).wave_number() * wave(i).direction[axis])),
                    square: lanes(&|i| wave(i).wave_number() * wave(i).wave_number()),
                    variance: lanes(&|i| {
                        let steepness = wave(i).amplitude * wave(i).wave_number();
                        steepness * steepness / 2.0
                    }),
                }
            })
            .collect();
        let mut lost = vec![0.0; waves.len() + 1];
        for (index, waves) in waves.iter().enumerate().rev() {
            lost[index] = lost[index + 1] + waves.variance.iter().sum::<f64>();
        }
        let each = |of: fn(&Wave) -> f64| frame.sorted[..frame.len()].iter().map(of).collect();
        Self {
            waves,
            lost,
            numbers: each(Wave::wave_number),
            sizes: each(|wave| wave.amplitude.abs().max(wave.horizontal.abs())),
            level: Level::new(),
        }
    }

    /// Returns the surface at a rest point (x₀, z₀) in meters under a footprint in meters.
    ///
    /// It is within 1e-14 of the sum of the waves' own sizes from [`SeaFrame::evaluate`].
    pub fn evaluate(&self, rest: [f64; 2], footprint: f64) -> Precise {
        let filter = footprint * footprint / 8.0;
        let left = self.numbers.partition_point(|k| k * k * filter <= CUT).div_ceil(LANES);
        let mut sums = [[0.0; LANES]; SUMS];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || add(simd, &self.waves[..left], rest, filter * LOG2_E, &mut sums)
        ));
        let sums = sums.map(|lanes| lanes.iter().sum());
        let sample = Sample {
            displacement: [sums[0], sums[1], sums[2]],
            slope: [sums[3], sums[4]],
            strain: [sums[5], sums[6], sums[7]],
            slope_variance: sums[8] + self.lost[left],
            ..Sample::default()
        };
        // The share is exp(−k²f²/8).
        Precise { sample, by_footprint: [9, 10, 11].map(|sum| -footprint / 4.0 * sums[sum]) }
    }

    /// Returns limits of the displacement and its first to fifth derivatives by the rest point, in any direction,
    /// under a footprint in meters and for all phases: Σ max(a, |h|)·kⁿ·exp(−k²f²/8), in m to 1/m⁴.
    pub fn most(&self, footprint: f64) -> [f64; 6] {
        let mut most = [0.0; 6];
        for (size, k) in self.sizes.iter().zip(&self.numbers) {
            let mut derivative = size * libm::exp(-k * k * footprint * footprint / 8.0);
            for most in &mut most {
                *most += derivative;
                derivative *= k;
            }
        }
        most
    }
}

/// Adds waves at a rest point, whose filter is f²/8 · log₂ e.
#[inline(always)]
fn add<S: Simd>(simd: S, waves: &[Waves], [x0, z0]: [f64; 2], filter: f64, total: &mut [[f64; LANES]; SUMS]) {
    let mut sums = [f64x8::splat(simd, 0.0); SUMS];
    for Waves { turns, origin, amplitude, horizontal, numbers, square, variance } in waves {
        let [tx, tz] = [load(simd, &turns[0]), load(simd, &turns[1])];
        let [sin, cos] = sincos(simd, tx * x0 + tz * z0 + load(simd, origin));
        let square = load(simd, square);
        let share = halved(simd, square * filter);
        let (sin, cos) = (share * sin, share * cos);
        let [hx, a, hz] = [load(simd, &horizontal[0]), load(simd, amplitude), load(simd, &horizontal[1])];
        let [kx, kz] = [load(simd, &numbers[0]), load(simd, &numbers[1])];
        let moved = [hx * sin, a * cos, hz * sin];
        sums[0] -= moved[0];
        sums[1] += moved[1];
        sums[2] -= moved[2];
        let steep = a * sin;
        sums[3] -= steep * kx;
        sums[4] -= steep * kz;
        let [by_x, by_z] = [hx * cos, hz * cos];
        sums[5] -= by_x * kx;
        sums[6] -= by_x * kz;
        sums[7] -= by_z * kz;
        sums[8] += load(simd, variance) * (share * share * -1.0 + 1.0);
        sums[9] -= moved[0] * square;
        sums[10] += moved[1] * square;
        sums[11] -= moved[2] * square;
    }
    for (total, sum) in total.iter_mut().zip(sums) {
        *total = sum.to_array();
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f64; LANES]) -> f64x8<S> {
    f64x8::load_array_ref(simd, lanes)
}

use std::f64::consts::TAU;
use trochoid_key::content_key;

use crate::fields::{SUMS, Sample};
use crate::wave::{Wave, attenuation};

/// A sea: the sum of its waves. A sea without waves is flat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sea {
    waves: Vec<Wave>,
}

content_key!(Sea { waves });

impl Sea {
    /// Makes a sea that is the sum of these waves.
    pub fn new(waves: Vec<Wave>) -> Self {
        Self { waves }
    }

    /// Returns the waves, in the order in which the reference adds them.
    pub fn waves(&self) -> &[Wave] {
        &self.waves
    }

    /// Returns the root mean square of the surface height in meters, over independent phases.
    pub fn height_rms(&self) -> f64 {
        libm::sqrt(self.waves.iter().map(|wave| wave.amplitude * wave.amplitude / 2.0).sum())
    }

    /// Returns the root mean square of the horizontal displacement in meters, over independent phases.
    pub fn horizontal_rms(&self) -> f64 {
        libm::sqrt(self.waves.iter().map(|wave| wave.horizontal * wave.horizontal / 2.0).sum())
    }

    /// Returns the root mean square of the nth derivative of the height, along the waves and by the rest point, under
    /// this footprint in meters and over independent phases: n = 0 is the height, 1 the slope, 2 the curvature in
    /// 1/m.
    pub fn derivative_rms(&self, n: i32, footprint: f64) -> f64 {
        self.derivatives_rms([n], &[footprint])[0][0]
    }

    /// Returns several [derivatives](Self::derivative_rms) under each of some footprints.
    pub fn derivatives_rms<const N: usize>(&self, n: [i32; N], footprints: &[f64]) -> Vec<[f64; N]> {
        let mut squares = vec![[0.0; N]; footprints.len()];
        for wave in &self.waves {
            let k = wave.wave_number();
            let whole = n.map(|n| wave.amplitude * libm::pow(k, f64::from(n)));
            for (squares, footprint) in squares.iter_mut().zip(footprints) {
                let share = attenuation(k, *footprint);
                for (square, whole) in squares.iter_mut().zip(whole) {
                    let value = whole * share;
                    *square += value * value / 2.0;
                }
            }
        }
        squares.into_iter().map(|squares| squares.map(libm::sqrt)).collect()
    }

    /// Returns the greatest height over the rest level that any phases could give: Σ|a| in meters.
    pub fn height_bound(&self) -> f64 {
        self.waves.iter().map(|wave| wave.amplitude.abs()).sum()
    }

    /// Returns the greatest horizontal displacement that any phases could give: Σ|h| in meters.
    pub fn horizontal_bound(&self) -> f64 {
        self.waves.iter().map(|wave| wave.horizontal.abs()).sum()
    }

    /// Returns the sea at one time in seconds; everything that does not depend on the position is computed once.
    pub fn at(&self, time: f64) -> SeaFrame {
        SeaFrame::new(&self.waves, time)
    }
}

/// A sea at one time, ready for evaluation anywhere.
#[derive(Clone, Debug)]
pub struct SeaFrame {
    /// Each wave with its phase at the origin, in turns, in the order of the sea; for the reference.
    reference: Vec<(Wave, Phase)>,
    /// Phases by falling wavelength, so that the waves that a footprint leaves are a prefix.
    pub(crate) phases: Phases,
    pub(crate) terms: Vec<Term>,
    /// The waves themselves, in the same order.
    pub(crate) sorted: Vec<Wave>,
    /// k²/8 of each term: attenuation is exp(−`filters`·footprint²).
    pub(crate) filters: Vec<f32>,
    /// Slope variance of all waves from this index on; one more entry than there are waves.
    pub(crate) variance_from: Vec<f64>,
}

/// Exponent from which a wave is not added: 1e-6 of it is left.
pub(crate) const CUT: f64 = 13.8;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest integer, ties to even, exactly.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Phase of a wave in turns: `x`·x₀ + `z`·z₀ + `origin`.
#[derive(Clone, Copy, Debug)]
struct Phase {
    x: f64,
    z: f64,
    origin: f64,
}

impl Phase {
    /// Returns the phase at a rest point, reduced to −½…½ turn.
    ///
    /// The reduction is done in f64: at x = t = 1e5 the phase of a wave of 1 m is 1e5 turns, which f32 represents
    /// only to 1/128 turn.
    #[inline(always)]
    fn at(&self, x: f64, z: f64) -> f64 {
        let turns = self.x * x + self.z * z + self.origin;
        turns - ((turns + ROUNDER) - ROUNDER)
    }
}

/// Phases of all waves, one array per factor.
#[derive(Clone, Debug)]
pub(crate) struct Phases {
    x: Vec<f64>,
    z: Vec<f64>,
    origin: Vec<f64>,
}

impl Phases {
    /// Computes the phases of the first waves at a rest point, reduced in f64 to −½…½ turn: as many as `out` holds.
    #[inline(always)]
    pub(crate) fn at(&self, x: f64, z: f64, out: &mut [f32]) {
        let factors = self.x.iter().zip(&self.z).zip(&self.origin);
        for (out, ((&turns_x, &turns_z), &origin)) in out.iter_mut().zip(factors) {
            *out = Phase { x: turns_x, z: turns_z, origin }.at(x, z) as f32;
        }
    }

    /// Returns how many of the first `count` waves satisfy `holds`; they must be sorted so that these come first.
    pub(crate) fn leading(&self, count: usize, holds: impl Fn([f64; 2]) -> bool) -> usize {
        let (mut low, mut high) = (0, count);
        while low < high {
            let middle = low.midpoint(high);
            if holds(self.turns(middle)) { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// Returns the phase of one wave at a rest point, reduced to −½…½ turn.
    pub(crate) fn of(&self, wave: usize, [x, z]: [f64; 2]) -> f64 {
        Phase { x: self.x[wave], z: self.z[wave], origin: self.origin[wave] }.at(x, z)
    }

    /// Returns the phase of one wave at the origin, in turns.
    pub(crate) fn origin(&self, wave: usize) -> f64 {
        self.origin[wave]
    }

    /// Returns the turns per meter of one wave.
    pub(crate) fn turns(&self, wave: usize) -> [f64; 2] {
        [self.x[wave], self.z[wave]]
    }
}

/// Numbers of a wave that the f32 kernels read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    /// Turns per meter along x and z.
    pub(crate) turns: [f32; 2],
    /// Factors of sin θ in Δx, Δz, ∂y/∂x, ∂y/∂z, ∂Δy/∂t.
    pub(crate) sines: [f32; 5],
    /// Factors of cos θ in Δy, ∂Δx/∂x, ∂Δx/∂z, ∂Δz/∂z, ∂Δx/∂t, ∂Δz/∂t.
    pub(crate) cosines: [f32; 6],
    /// Slope variance ½(a·k)² of the whole wave.
    pub(crate) variance: f32,
}

/// Contribution of a wave to a sum.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Factor {
    /// This times sin θ.
    Sine(f64),
    /// This times cos θ.
    Cosine(f64),
}

impl Factor {
    pub(crate) fn value(self) -> f64 {
        match self {
            Self::Sine(value) | Self::Cosine(value) => value,
        }
    }
}

/// Returns the contribution of a wave to each sum, in the order of the kernel's outputs.
pub(crate) fn factors(wave: &Wave) -> [Factor; SUMS] {
    use Factor::{Cosine, Sine};
    let (k, speed) = (wave.wave_number(), wave.angular_frequency);
    let ([x, z], a, h) = (wave.direction, wave.amplitude, wave.horizontal);
    [
        Sine(-h * x),
        Cosine(a),
        Sine(-h * z),
        Sine(-a * k * x),
        Sine(-a * k * z),
        Cosine(-h * k * x * x),
        Cosine(-h * k * x * z),
        Cosine(-h * k * z * z),
        Cosine(h * x * speed),
        Sine(a * speed),
        Cosine(h * z * speed),
    ]
}

impl Term {
    fn new(wave: &Wave) -> Self {
        let ([x, z], steepness) = (wave.direction, wave.steepness());
        let [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz] = factors(wave).map(|factor| factor.value() as f32);
        Self {
            turns: [(x / wave.wavelength) as f32, (z / wave.wavelength) as f32],
            sines: [dx, dz, yx, yz, vy],
            cosines: [dy, xx, xz, zz, vx, vz],
            variance: (steepness * steepness / 2.0) as f32,
        }
    }
}

impl SeaFrame {
    fn new(waves: &[Wave], time: f64) -> Self {
        let phase = |wave: &Wave| {
            let elapsed = wave.angular_frequency * time / TAU;
            let start = wave.phase / TAU;
            let origin = (start - start.round_ties_even()) - (elapsed - elapsed.round_ties_even());
            Phase { x: wave.direction[0] / wave.wavelength, z: wave.direction[1] / wave.wavelength, origin }
        };
        let mut sorted: Vec<&Wave> = waves.iter().collect();
        sorted.sort_by(|a, b| b.wavelength.total_cmp(&a.wavelength));
        let phases: Vec<Phase> = sorted.iter().map(|wave| phase(wave)).collect();
        let mut variance_from = vec![0.0; waves.len() + 1];
        for (index, wave) in sorted.iter().enumerate().rev() {
            variance_from[index] = variance_from[index + 1] + wave.steepness() * wave.steepness() / 2.0;
        }
        Self {
            reference: waves.iter().map(|wave| (*wave, phase(wave))).collect(),
            phases: Phases {
                x: phases.iter().map(|phase| phase.x).collect(),
                z: phases.iter().map(|phase| phase.z).collect(),
                origin: phases.iter().map(|phase| phase.origin).collect(),
            },
            terms: sorted.iter().map(|wave| Term::new(wave)).collect(),
            sorted: sorted.iter().map(|wave| **wave).collect(),
            filters: sorted.iter().map(|wave| (wave.wave_number() * wave.wave_number() / 8.0) as f32).collect(),
            variance_from,
        }
    }

    /// Returns the surface at a rest point (x₀, z₀) under a footprint in meters: the plain f64 sum, straight from the
    /// model.
    ///
    /// Source: thesis §3.2.1 with the signs of the crate's model; Hinsinger, Neyret and Cani 2002, eq. 1.
    pub fn evaluate(&self, rest: [f64; 2], footprint: f64) -> Sample {
        let mut sample = Sample::default();
        for (wave, phase) in &self.reference {
            let k = wave.wave_number();
            let share = attenuation(k, footprint);
            let (sin, cos) = libm::sincos(TAU * phase.at(rest[0], rest[1]));
            let ([x, z], a, h) = (wave.direction, wave.amplitude * share, wave.horizontal * share);
            sample.displacement[0] -= h * x * sin;
            sample.displacement[1] += a * cos;
            sample.displacement[2] -= h * z * sin;
            sample.slope[0] -= a * k * x * sin;
            sample.slope[1] -= a * k * z * sin;
            sample.strain[0] -= h * k * x * x * cos;
            sample.strain[1] -= h * k * x * z * cos;
            sample.strain[2] -= h * k * z * z * cos;
            sample.velocity[0] += h * x * wave.angular_frequency * cos;
            sample.velocity[1] += a * wave.angular_frequency * sin;
            sample.velocity[2] += h * z * wave.angular_frequency * cos;
            sample.slope_variance += (wave.amplitude * k) * (wave.amplitude * k) / 2.0 * (1.0 - share * share);
        }
        sample
    }

    /// Returns the sea that this is one time of.
    pub fn sea(&self) -> Sea {
        Sea::new(self.reference.iter().map(|(wave, _)| *wave).collect())
    }

    /// Returns the waves in the order in which [`Self::evaluate`] adds them, each with its turns per meter along x and z
    /// and its turns at the origin.
    pub(crate) fn plain_waves(&self) -> impl Iterator<Item = (&Wave, [f64; 3])> {
        self.reference.iter().map(|(wave, phase)| (wave, [phase.x, phase.z, phase.origin]))
    }

    /// Returns the number of waves.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Returns whether the sea has no waves.
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// Returns how many waves a footprint in meters leaves; less than 1e-6 is left of each of the others.
    pub fn resolved(&self, footprint: f64) -> usize {
        let print = (footprint as f32).min(1e15);
        self.left(print * print)
    }

    /// Returns how many of the leading waves a footprint leaves, given its square in m².
    pub(crate) fn left(&self, footprint2: f32) -> usize {
        self.filters.partition_point(|filter| filter * footprint2 <= CUT as f32)
    }
}

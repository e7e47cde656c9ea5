use std::f64::consts::TAU;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use crate::wave::{GRAVITY, LENGTHS_M, Wave, WaveError, WaveParameter, within};

/// Most waves of one spectrum.
pub const MAX_WAVES: usize = 100_000;

/// Crests that count as the sharpest of many waves, in multiples of the root mean square of their compression: 0.6 %
/// of a normal distribution lie beyond.
const CREST: f64 = 2.5;

/// How the angular frequency follows from the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Dispersion {
    /// Deep water, ω = √(g·k): long waves are faster.
    #[default]
    Deep,
    /// All crests travel at this speed v in m/s: ω = 2πv/L.
    Speed(f64),
    /// All waves share this period v in s, > 0: ω = 2π/v, as printed in the thesis.
    Period(f64),
}

/// Which displacement a spectrum's waves have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Convention {
    /// x −= h·d·sin θ, y += a·cos θ; `height` is the significant wave height of the sum.
    #[default]
    Settled,
    /// As printed in the thesis: D₀ = s·a·sin θ along +d, D₁ = s·a·cos θ, weights ωᵢ = 1/count.
    Thesis,
}

/// A sea of random waves with log-normal lengths around one direction.
///
/// **Settled.** Amplitudes are proportional to wavelengths (thesis §3.2.1) and scaled so that four times the root
/// mean square of the surface height equals `height` for every count. All waves share one ratio of horizontal to
/// vertical amplitude, so that qᵢ = hᵢkᵢ is the same for all. Sharpness is the compression Σ qᵢ cos θᵢ of the
/// sharpest crests as a share of the cusp: 0 is a sum of sinusoids, and 1 brings them to the cusp. A single wave's
/// crests have √2 times the root mean square of its compression, n waves can reach √(2n) times, and for many waves
/// 2.5 times counts as the sharpest that matter: qᵢ = `sharpness`·√(2/n) / min(√(2n), 2.5). Up to 3 waves never fold
/// below sharpness 1; with many waves at 1, fewer than one rest point in a hundred folds over, and far fewer if
/// directions spread. [`Sea::folding`](crate::Sea::folding) tells how much for any sea.
///
/// **Thesis.** Weights ωᵢ = 1/count, amplitude aᵢ = (height/2)·(Lᵢ/wavelength), both displacements times sharpness.
/// The sum flattens as 1/√count, and as sharpness approaches 0; crests are flat and troughs sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GerstnerSpectrum {
    /// Number of waves, 0 (a flat sea) to [`MAX_WAVES`].
    pub count: usize,
    /// Mean wavelength in meters.
    pub wavelength: f64,
    /// Standard deviation of ln L, 0 to 3.
    pub spread: f64,
    /// Significant wave height in meters, 4 × RMS, ≥ 0.
    pub height: f64,
    /// Azimuth of travel in radians: 0 is +X, growing toward +Z.
    pub direction: f64,
    /// Standard deviation of the azimuth in radians, ≥ 0.
    pub direction_spread: f64,
    /// Sharpness of the crests, ≥ 0: 0 is a sum of sinusoids.
    pub sharpness: f64,
    /// How frequencies follow from wavelengths.
    pub dispersion: Dispersion,
    /// Signs and weights.
    pub convention: Convention,
    /// Random seed.
    pub seed: u64,
}

impl Default for GerstnerSpectrum {
    fn default() -> Self {
        Self {
            count: 1000,
            wavelength: 20.0,
            spread: 0.5,
            height: 1.0,
            direction: 0.0,
            direction_spread: 0.5,
            sharpness: 0.5,
            dispersion: Dispersion::Deep,
            convention: Convention::Settled,
            seed: 0,
        }
    }
}

/// Why a spectrum is rejected.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumError {
    /// There are more waves than [`MAX_WAVES`].
    Count(usize),
    /// A knob is outside of its range.
    Knob(WaveError),
}

impl std::fmt::Display for SpectrumError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Count(found) => write!(f, "{found} waves; expected at most {MAX_WAVES}"),
            Self::Knob(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SpectrumError {}

impl From<WaveError> for SpectrumError {
    fn from(error: WaveError) -> Self {
        Self::Knob(error)
    }
}

/// Random numbers of one wave.
struct WaveDraw {
    wavelength: f64,
    azimuth: f64,
    phase: f64,
}

impl GerstnerSpectrum {
    /// Returns the waves of this spectrum, in the order of their index.
    ///
    /// Wave `i` has the same length, direction and phase for every `count`: more waves never reshuffle the earlier
    /// ones.
    ///
    /// # Errors
    /// A knob is outside of its range.
    pub fn waves(&self) -> Result<Vec<Wave>, SpectrumError> {
        self.validate()?;
        let draws: Vec<WaveDraw> = (0..self.count).map(|index| self.draw(index as u64)).collect();
        // Vertical amplitude of wave i: `scale` · Lᵢ.
        let (scale, orbit) = match self.convention {
            Convention::Settled => {
                // Σ(c·L)²/2 = (height/4)²  ⇒  c = (height/4)·√(2/ΣL²).
                let squares: f64 = draws.iter().map(|draw| draw.wavelength * draw.wavelength).sum();
                let scale = if squares > 0.0 { self.height / 4.0 * libm::sqrt(2.0 / squares) } else { 0.0 };
                let count = self.count as f64;
                let crest = libm::sqrt(2.0 * count).min(CREST);
                let compression = self.sharpness * libm::sqrt(2.0 / count.max(1.0)) / crest.max(1.0);
                // h/a = q/(a·k), and a·k = 2π·c for every wave.
                let steepness = TAU * scale;
                (scale, if steepness > 0.0 { compression / steepness } else { 0.0 })
            }
            Convention::Thesis => {
                let weight = 1.0 / self.count.max(1) as f64;
                (weight * self.sharpness * (self.height / 2.0) / self.wavelength, -1.0)
            }
        };
        Ok(draws.iter().map(|draw| self.wave(draw, scale, orbit)).collect())
    }

    fn wave(&self, draw: &WaveDraw, scale: f64, orbit: f64) -> Wave {
        let k = TAU / draw.wavelength;
        let amplitude = scale * draw.wavelength;
        Wave {
            wavelength: draw.wavelength,
            direction: [libm::cos(draw.azimuth), libm::sin(draw.azimuth)],
            amplitude,
            horizontal: orbit * amplitude,
            angular_frequency: match self.dispersion {
                Dispersion::Deep => libm::sqrt(GRAVITY * k),
                Dispersion::Speed(speed) => k * speed,
                Dispersion::Period(period) => TAU / period,
            },
            phase: draw.phase,
        }
    }

    fn draw(&self, index: u64) -> WaveDraw {
        // Each index has its own generator; the multiplier only spreads neighboring indices over the state.
        let state = (u128::from(self.seed) << 64) | u128::from(index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut random = Pcg64::new(state, u128::from(index));
        let mut unit = || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        // Box–Muller: two independent normal numbers from two uniform ones.
        let radius = libm::sqrt(-2.0 * libm::log(unit()));
        let angle = TAU * unit();
        let (length, turn) = (radius * libm::cos(angle), radius * libm::sin(angle));
        let phase = TAU * unit();
        // The mean of a log-normal is exp(μ + σ²/2): μ = ln(mean) − σ²/2.
        let log_length = libm::log(self.wavelength) + self.spread * (length - self.spread / 2.0);
        WaveDraw {
            wavelength: libm::exp(log_length).clamp(LENGTHS_M.0, LENGTHS_M.1),
            azimuth: self.direction + self.direction_spread * turn,
            phase,
        }
    }

    fn validate(&self) -> Result<(), SpectrumError> {
        if self.count > MAX_WAVES {
            return Err(SpectrumError::Count(self.count));
        }
        let any = (f64::MIN, f64::MAX);
        within(WaveParameter::Wavelength, self.wavelength, (1e-3, 1e6), "0.001 to 1,000,000 meters")?;
        within(WaveParameter::Spread, self.spread, (0.0, 3.0), "0 to 3")?;
        within(WaveParameter::Height, self.height, (0.0, 1e6), "0 to 1,000,000 meters")?;
        within(WaveParameter::Direction, self.direction, any, "a finite azimuth")?;
        within(WaveParameter::DirectionSpread, self.direction_spread, (0.0, 1e3), "0 or more, finite")?;
        within(WaveParameter::Sharpness, self.sharpness, (0.0, 1e3), "0 to 1000")?;
        match self.dispersion {
            Dispersion::Deep => {}
            Dispersion::Speed(speed) => within(WaveParameter::Speed, speed, any, "a finite number of m/s")?,
            Dispersion::Period(period) => {
                within(WaveParameter::Period, period, (1e-9, f64::MAX), "more than 0 seconds")?;
            }
        }
        Ok(())
    }
}

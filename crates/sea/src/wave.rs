use std::f64::consts::TAU;
use trochoid_key::content_key;

/// Acceleration of gravity in m/s².
pub const GRAVITY: f64 = 9.81;

/// One trochoidal wave of a sea, ready for summation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Crest-to-crest length L, in meters, > 0.
    pub wavelength: f64,
    /// Unit direction of travel in the plane of the resting sea: x, z.
    pub direction: [f64; 2],
    /// Vertical amplitude a, in meters.
    pub amplitude: f64,
    /// Horizontal amplitude h, in meters; negative for the signs printed in the thesis.
    pub horizontal: f64,
    /// Angular frequency ω in rad/s.
    pub angular_frequency: f64,
    /// Phase φ in radians: at 0, a crest is at the origin at t = 0.
    pub phase: f64,
}

content_key!(Wave { wavelength, direction, amplitude, horizontal, angular_frequency, phase });

impl Wave {
    /// Returns the wave number k = 2π/L in rad/m.
    pub fn wave_number(&self) -> f64 {
        TAU / self.wavelength
    }

    /// Returns the horizontal compression q = h·k at a crest: 1 is the cusp of a single wave.
    pub fn compression(&self) -> f64 {
        self.horizontal * self.wave_number()
    }

    /// Returns the largest steepness a·k.
    pub fn steepness(&self) -> f64 {
        self.amplitude * self.wave_number()
    }
}

/// Returns the share of a wave that a footprint leaves: exp(−(k·σ)²/2) with σ = `footprint`/2, both in meters.
///
/// A Gaussian of standard deviation σ over the resting sea multiplies a plane wave by exactly this factor.
pub fn attenuation(wave_number: f64, footprint: f64) -> f64 {
    libm::exp(-(wave_number * footprint) * (wave_number * footprint) / 8.0)
}

/// One wave that is placed by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplicitWave {
    /// Crest-to-crest length in meters, > 0.
    pub wavelength: f64,
    /// Vertical amplitude in meters.
    pub amplitude: f64,
    /// Azimuth of travel in radians: 0 is +X, growing toward +Z.
    pub direction: f64,
    /// Compression q = h·k of this wave alone, as a share of the cusp: 0 is a sinusoid, 1 a cusp, more folds.
    pub sharpness: f64,
    /// Phase in radians.
    pub phase: f64,
    /// Speed of the crests in m/s; `None` for that of deep water.
    pub speed: Option<f64>,
}

parameters! {
    /// A parameter of waves, spectra, groups or ripples.
    WaveParameter {
        Wavelength = "wavelength",
        Spread = "spread",
        Height = "height",
        Amplitude = "amplitude",
        Direction = "direction",
        DirectionSpread = "direction_spread",
        Sharpness = "sharpness",
        Phase = "phase",
        Speed = "speed",
        Period = "period",
        Frequency = "frequency",
        Along = "along",
        Across = "across",
        Focus = "focus",
        Time = "time",
        Waves = "waves",
        WavelengthInGroup = "wavelength of a wave in the group",
    }
}

/// Why a wave is rejected.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveError {
    /// Name of the parameter.
    pub parameter: WaveParameter,
    /// Its value.
    pub found: f64,
    /// Accepted values.
    pub expected: &'static str,
}

impl std::fmt::Display for WaveError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}; expected {}", self.parameter, self.found, self.expected)
    }
}

impl std::error::Error for WaveError {}

/// Accepts finite values within closed bounds; rejects anything else, including NaN, by name.
pub(crate) fn within(
    parameter: WaveParameter,
    found: f64,
    (low, high): (f64, f64),
    expected: &'static str,
) -> Result<(), WaveError> {
    if found.is_finite() && found >= low && found <= high {
        Ok(())
    } else {
        Err(WaveError { parameter, found, expected })
    }
}

/// Shortest and longest wave, in meters: phases stay exact in f64, and squares of wave numbers finite in f32.
pub(crate) const LENGTHS_M: (f64, f64) = (1e-6, 1e9);

impl TryFrom<ExplicitWave> for Wave {
    type Error = WaveError;

    fn try_from(wave: ExplicitWave) -> Result<Self, WaveError> {
        let any = (f64::MIN, f64::MAX);
        within(WaveParameter::Wavelength, wave.wavelength, LENGTHS_M, "1e-6 to 1e9 meters")?;
        within(WaveParameter::Amplitude, wave.amplitude, any, "a finite number of meters")?;
        within(WaveParameter::Direction, wave.direction, any, "a finite azimuth")?;
        within(WaveParameter::Sharpness, wave.sharpness, (0.0, f64::MAX), "0 or more, finite")?;
        within(WaveParameter::Phase, wave.phase, any, "a finite angle")?;
        let k = TAU / wave.wavelength;
        let angular_frequency = match wave.speed {
            Some(speed) => {
                within(WaveParameter::Speed, speed, any, "a finite number of m/s")?;
                k * speed
            }
            None => libm::sqrt(GRAVITY * k),
        };
        Ok(Self {
            wavelength: wave.wavelength,
            direction: [libm::cos(wave.direction), libm::sin(wave.direction)],
            amplitude: wave.amplitude,
            horizontal: wave.sharpness / k,
            angular_frequency,
            phase: wave.phase,
        })
    }
}

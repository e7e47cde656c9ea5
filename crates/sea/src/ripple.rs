use std::f64::consts::{FRAC_PI_2, TAU};

use crate::wave::{GRAVITY, LENGTHS_M, Wave, WaveError, WaveParameter, within};

/// The crossed ripples of cartoon water, y = A·sin(p)·cos(q): a checkerboard of bumps and hollows.
///
/// A product of two waves is a sum of two others, A/2·sin(p + q) + A/2·sin(p − q): plain waves of equal length that
/// cross, so that everything that sums waves can make ripples too. After *Creation of a cartoon shader of water for
/// the web*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Height A of the bumps, in meters.
    pub height: f64,
    /// Distance from bump to bump along the direction and across it, in meters.
    pub lengths: [f64; 2],
    /// Azimuth of travel, in radians: 0 is +X, growing toward +Z.
    pub direction: f64,
    /// Angular frequency ω in rad/s. If `None`, deep water sets it, or 1 as printed if `literal`.
    pub frequency: Option<f64>,
    /// Phase p at the origin at time 0, in radians.
    pub phase: f64,
    /// Keeps the printed phases p = k₁a + ωt, q = k₂b + ωt at positions a along and b across. Then one of the two
    /// waves runs at twice the frequency, and the other stands still like a mold. The settled form is p = k₁a − ωt,
    /// q = k₂b: both waves travel, and with them the pattern, unchanged.
    pub literal: bool,
}

impl Default for Ripple {
    /// Returns the printed parameters: 5 rad/m both ways, 0.1 m.
    fn default() -> Self {
        Self { height: 0.1, lengths: [TAU / 5.0; 2], direction: 0.0, frequency: None, phase: 0.0, literal: false }
    }
}

impl Ripple {
    /// Returns the two waves.
    ///
    /// # Errors
    /// A number is not finite, or a length is outside of 2e-6 to 1e9 meters.
    pub fn waves(&self) -> Result<[Wave; 2], WaveError> {
        let any = (f64::MIN, f64::MAX);
        for length in self.lengths {
            within(WaveParameter::Wavelength, length, (2.0 * LENGTHS_M.0, LENGTHS_M.1), "2e-6 to 1e9 meters")?;
        }
        within(WaveParameter::Height, self.height, any, "a finite number of meters")?;
        within(WaveParameter::Direction, self.direction, any, "a finite azimuth")?;
        within(WaveParameter::Phase, self.phase, any, "a finite angle")?;
        within(WaveParameter::Frequency, self.frequency.unwrap_or(0.0), any, "a finite number of rad/s")?;
        let [along, across] = self.lengths.map(|length| TAU / length);
        let k = libm::hypot(along, across);
        let (sin, cos) = libm::sincos(self.direction);
        // Makes a wave a·cos(k·position − ωt + φ) of these wave numbers along and across.
        let wave = |along: f64, across: f64, angular_frequency: f64, phase: f64| Wave {
            wavelength: TAU / k,
            direction: [(along * cos - across * sin) / k, (along * sin + across * cos) / k],
            amplitude: self.height / 2.0,
            horizontal: 0.0,
            angular_frequency,
            phase,
        };
        // sin u = cos(u − π/2).
        let phase = self.phase - FRAC_PI_2;
        Ok(if self.literal {
            // sin(p + q) = cos(−(p + q) + π/2), which travels backward.
            let frequency = self.frequency.unwrap_or(1.0);
            [wave(-along, -across, 2.0 * frequency, -phase), wave(along, -across, 0.0, phase)]
        } else {
            let frequency = self.frequency.unwrap_or_else(|| libm::sqrt(GRAVITY * k));
            [across, -across].map(|across| wave(along, across, frequency, phase))
        })
    }
}

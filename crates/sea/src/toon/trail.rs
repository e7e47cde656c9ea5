use super::error::within;
use super::spline::length_at;
use super::{ToonError, ToonParameter};
use trochoid_key::content_key;

/// How several bursts near a cell contribute to its rift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Combine {
    /// Every burst within the distance adds.
    #[default]
    Sum,
    /// Only the nearest burst counts, as in the printed formula.
    Nearest,
}

content_key!(
    enum Combine {
        Sum,
        Nearest,
    }
);

/// The trail of foam behind bursts: r += k·max(d − m, 0), m the distance from a burst, and r ÷= 1 + ε at every
/// literal step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rift {
    /// Distance d from a burst, in meters, up to which it leaves a trail.
    pub distance: f64,
    /// k: amount that a literal step adds per meter.
    pub gain: f64,
    /// ε: decay per literal step.
    pub decay: f64,
    /// How several bursts are combined.
    pub combine: Combine,
}

content_key!(Rift { distance, gain, decay, combine });

impl Default for Rift {
    fn default() -> Self {
        Self { distance: 1.5, gain: 0.02, decay: 0.01, combine: Combine::Sum }
    }
}

impl Rift {
    /// Returns the final value of the rift at a distance from a resting burst: k(d − m)/ε; infinite without decay.
    pub fn plateau(&self, distance: f64) -> f64 {
        self.gain * (self.distance - distance).max(0.0) / self.decay
    }

    /// Returns the number of literal steps after which half is left: ln 2/ln(1 + ε); infinite without decay.
    pub fn half_life(&self) -> f64 {
        std::f64::consts::LN_2 / libm::log1p(self.decay)
    }

    pub(crate) fn validate(&self) -> Result<(), ToonError> {
        within(ToonParameter::RiftDistance, self.distance, (1e-6, 1e6), "1e-6 to 1e6 meters")?;
        within(ToonParameter::RiftGain, self.gain, (0.0, 1e6), "0 to 1e6 per meter")?;
        within(ToonParameter::RiftDecay, self.decay, (0.0, 1e3), "0 to 1000")
    }
}

/// Returns the share that is left after `steps` literal steps of r ÷= 1 + ε, and the sum of all steps' equal
/// additions in units of one: Σ (1+ε)⁻ʲ over j = 1…steps. The number of steps may be any real number.
pub(crate) fn decayed(decay: f64, steps: f64) -> (f64, f64) {
    let rate = libm::log1p(decay);
    let left = libm::exp(-rate * steps);
    let added = if decay > 0.0 { -libm::expm1(-rate * steps) / decay } else { steps };
    (left, added)
}

/// Coordinates for lines that bursts draw behind them.
///
/// Besides the rift, every cell keeps a weight and two phases of lines. A burst assigns the cell two coordinates in
/// its own frame: along its path, lagging behind by `lag` per meter to the side, and across. Each is an angle, with a
/// full turn for every [`Drift::LINES`] lines; the cell keeps the sum of w·(cos, sin), w = (1 − q²)², q the distance
/// from the burst in an ellipse slightly larger than its own. Where bursts agree, lines therefore turn and fan out
/// with them and are never cut; where a burst overtakes the wake of an unrelated one, angles cancel, and [`spread`]
/// tells that no line can be drawn there.
///
/// A passing burst renews existing values: X' = (X/(1 + ε) + Σ w·x)/(1 + ρ·Σ w) for each literal step, so that the
/// wake behind it is its own, however large the sums were before. Decay reduces all sums equally and moves no line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Radii along and across the heading, relative to those of the burst.
    pub reach: [f64; 2],
    /// Meters by which lines lag behind per meter across: how far they are swept back.
    pub lag: f64,
    /// ε: decay per literal step, like that of a rift.
    pub decay: f64,
    /// ρ: share of the previous values that the middle of a burst replaces per literal step.
    pub renewal: f64,
    /// Distance between lines, in meters.
    pub period: f64,
}

content_key!(Drift { reach, lag, decay, renewal, period });

impl Default for Drift {
    fn default() -> Self {
        Self { reach: [1.1, 1.25], lag: 0.35, decay: 0.02, renewal: 0.5, period: 0.8 }
    }
}

impl Drift {
    /// Number of lines in a full turn, which is how many can be distinguished.
    pub const LINES: u32 = 16;

    pub(crate) fn validate(&self) -> Result<(), ToonError> {
        for reach in self.reach {
            within(ToonParameter::DriftReach, reach, (1e-3, 1e3), "0.001 to 1000")?;
        }
        within(ToonParameter::DriftLag, self.lag, (-1e3, 1e3), "-1000 to 1000")?;
        within(ToonParameter::DriftDecay, self.decay, (0.0, 1e3), "0 to 1000")?;
        within(ToonParameter::DriftRenewal, self.renewal, (0.0, 1e3), "0 to 1000")?;
        within(ToonParameter::DriftPeriod, self.period, (1e-6, 1e6), "1e-6 to 1e6 meters")
    }

    /// Returns the factor that scales weights and phases to about 1 where bursts pass: their largest sum is 1/(ε +
    /// ρ).
    pub fn scale(&self) -> f64 {
        (self.decay + self.renewal).max(1e-6)
    }

    /// Returns the turns per meter.
    pub(crate) fn frequency(&self) -> f64 {
        1.0 / (self.period * f64::from(Self::LINES))
    }

    /// Returns the distance that a burst has come, in turns; each lap counts as a whole number of lines.
    pub(crate) fn along(&self, lap: f64, progress: f64, lengths: &[f64]) -> f64 {
        let length = lengths.last().copied().unwrap_or(0.0);
        let lines = (length / self.period).ceil() * lap;
        let laps = lines.rem_euclid(f64::from(Self::LINES)) / f64::from(Self::LINES);
        (length_at(lengths, progress) * self.frequency() + laps).rem_euclid(1.0)
    }

    /// Returns the square of the width in meters over which the lag's |l| is rounded off.
    pub(crate) fn softness(&self, spacing: f64) -> f64 {
        2.25 * spacing * spacing
    }
}

/// Returns the standard deviation of the coordinates behind a phase, in line distances: 0 if all bursts agree, at
/// most 2.55.
///
/// `phase` is the sum of w·(cos, sin) for the weight `w`. The result is the circular deviation √(1 − R²)/2π of a full
/// turn, where R is the length of the phase relative to the weight.
pub fn spread(weight: f64, phase: [f64; 2]) -> f64 {
    let square = phase[0] * phase[0] + phase[1] * phase[1];
    let lost = 1.0 - square / (weight * weight);
    f64::from(Drift::LINES) / std::f64::consts::TAU * libm::sqrt(lost.max(0.0))
}

//! Phases in twice the precision of f64, to measure the phase errors of pictures.

use std::f64::consts::TAU;

use crate::{Sea, Wave};

/// Rounding error of 2π in f64.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// A sum of two numbers, the second of which is below the last digit of the first (Dekker 1971).
#[derive(Clone, Copy, Debug)]
struct Twofold(f64, f64);

impl Twofold {
    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    fn plus(self, other: Self) -> Self {
        let Self(high, low) = Self::sum(self.0, other.0);
        Self::sum(high, low + self.1 + other.1)
    }

    fn times(self, factor: f64) -> Self {
        let high = self.0 * factor;
        Self::sum(high, self.0.mul_add(factor, -high) + self.1 * factor)
    }

    fn over(self, divisor: Self) -> Self {
        let quotient = self.0 / divisor.0;
        let rest = (-quotient).mul_add(divisor.0, self.0) + self.1 - quotient * divisor.1;
        Self::sum(quotient, rest / divisor.0)
    }

    /// Returns the fractional part, −½…½.
    fn fraction(self) -> f64 {
        let near = self.0 - self.0.round_ties_even();
        let fraction = near + self.1;
        fraction - fraction.round_ties_even()
    }
}

impl Wave {
    /// Returns the error of this wave's phase in the f64 sum at a rest point and time, in turns, measured against
    /// twice the precision.
    ///
    /// ```
    /// use trochoid_sea::{ExplicitWave, Wave};
    ///
    /// let wave = ExplicitWave { wavelength: 7.3, amplitude: 1.0, direction: 0.4, sharpness: 0.5, phase: 1.0, speed: None };
    /// let wave = Wave::try_from(wave)?;
    /// let error = wave.phase_error([1e7, -1e7], 1e7);
    /// assert!(error <= wave.phase_error_bound([1e7, -1e7], 1e7) && error < 1e-8);
    /// # Ok::<(), trochoid_sea::WaveError>(())
    /// ```
    pub fn phase_error(&self, [x, z]: [f64; 2], time: f64) -> f64 {
        let whole = Twofold(TAU, TAU_LOW);
        let length = Twofold(self.wavelength, 0.0);
        let along = |direction: f64, place: f64| Twofold(direction, 0.0).over(length).times(place);
        let elapsed = Twofold(-self.angular_frequency, 0.0).times(time).over(whole);
        let start = Twofold(self.phase, 0.0).over(whole);
        let exact = along(self.direction[0], x).plus(along(self.direction[1], z)).plus(elapsed).plus(start).fraction();
        // The sum of this wave alone reveals its phase: y = cos θ, and slopes −k·d·sin θ.
        let alone = Self { amplitude: 1.0, horizontal: 0.0, ..*self };
        let sample = Sea::new(vec![alone]).at(time).evaluate([x, z], 0.0);
        let [dx, dz] = self.direction;
        let sine = -(sample.slope[0] * dx + sample.slope[1] * dz) / (self.wave_number() * (dx * dx + dz * dz));
        let off = libm::atan2(sine, sample.displacement[1]) / TAU - exact;
        (off - off.round_ties_even()).abs()
    }

    /// Returns the largest possible phase error, in turns: each of its three products is rounded twice and added
    /// once.
    pub fn phase_error_bound(&self, [x, z]: [f64; 2], time: f64) -> f64 {
        let [dx, dz] = self.direction;
        let turns = (x * dx).abs() / self.wavelength
            + (z * dz).abs() / self.wavelength
            + (self.angular_frequency * time).abs() / TAU
            + self.phase.abs() / TAU
            // Recovering the phase from sine and cosine.
            + 4.0;
        4.0 * f64::EPSILON / 2.0 * turns
    }
}

use std::f64::consts::TAU;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use crate::wave::{GRAVITY, LENGTHS_M, Wave, WaveError, WaveParameter, within};

/// Most waves of one group.
pub const MAX_GROUP: usize = 10_000;

/// Range of the wave numbers of a group, in their standard deviations, and their random variation.
const REACH: f64 = 1.8;
const JITTER: f64 = 0.12;

/// One crest that is placed by hand: a packet of plain waves, all of whose crests meet at one position and time.
///
/// Wave vectors lie on a grid around that of the middle wave, k = d(k₀ + p/σ₁) + e·q/σ₂ with d the direction of
/// travel, e across it and p, q from −1.8 to 1.8. Each is moved slightly at random, so that the packet does not
/// recur. Amplitudes are proportional to exp(−(p² + q²)/2) and sum to `height`. The height at the focus is therefore
/// `height`, and around it the surface is a wave under a bell curve of standard deviation σ₁ along and σ₂ across the
/// travel.
///
/// Source: the wave packet of linear wave theory, e.g. Whitham, *Linear and Nonlinear Waves*, 1974, §11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveGroup {
    /// Length of the middle wave, in meters, > 0.
    pub wavelength: f64,
    /// Height of the crest above the resting sea at the focus, in meters.
    pub height: f64,
    /// Azimuth of travel, in radians: 0 is +X, growing toward +Z.
    pub direction: f64,
    /// Standard deviation σ₁ of the packet along its travel, in meters, at least 0.31 wavelengths: a shorter one
    /// would need waves that travel the other way.
    pub along: f64,
    /// Standard deviation σ₂ across the travel, in meters, > 0: half the length of the crest.
    pub across: f64,
    /// World x and z where the crests meet, in meters.
    pub focus: [f64; 2],
    /// Time when the crests meet, in seconds.
    pub time: f64,
    /// Compression along the travel at the focus, as a share of the cusp: 0 gives a sum of sinusoids, 1 a cusp, more
    /// a fold. ≥ 0.
    pub sharpness: f64,
    /// Speed in m/s at which the crest travels unchanged. If `None`, deep water sets the speed of each wave, and the
    /// packet forms and disperses.
    pub speed: Option<f64>,
    /// Number of waves along and across the travel, ≥ 1; with few waves the crest recurs nearby.
    pub waves: [usize; 2],
    /// Random seed.
    pub seed: u64,
}

impl Default for WaveGroup {
    fn default() -> Self {
        Self {
            wavelength: 30.0,
            height: 2.0,
            direction: 0.0,
            along: 15.0,
            across: 15.0,
            focus: [0.0; 2],
            time: 0.0,
            sharpness: 0.5,
            speed: None,
            waves: [5, 5],
            seed: 0,
        }
    }
}

impl WaveGroup {
    /// Least value of [`along`](Self::along), in wavelengths.
    pub const LEAST_ALONG: f64 = 0.31;

    /// Returns the waves of this group.
    ///
    /// # Errors
    /// A number is outside of its range.
    pub fn waves(&self) -> Result<Vec<Wave>, WaveError> {
        self.validate()?;
        let [d, e] = [0.0, TAU / 4.0].map(|turn| self.direction + turn).map(|a| [libm::cos(a), libm::sin(a)]);
        let middle = TAU / self.wavelength;
        let mut random = Pcg64::new(u128::from(self.seed), 0);
        let mut unit = || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let mut place = |index: usize, count: usize| {
            let moved = JITTER * (2.0 * unit() - 1.0);
            // A single wave is in the middle.
            if count > 1 { REACH * (2.0 * index as f64 / (count - 1) as f64 - 1.0) + moved } else { 0.0 }
        };
        let [along, across] = self.waves;
        let mut packet = Vec::with_capacity(along * across);
        for p in 0..along {
            for q in 0..across {
                let (p, q) = (place(p, along), place(q, across));
                let (forward, sideward) = (middle + p / self.along, q / self.across);
                let k = [0, 1].map(|axis| d[axis] * forward + e[axis] * sideward);
                packet.push((k, forward, libm::exp(-(p * p + q * q) / 2.0)));
            }
        }
        let total: f64 = packet.iter().map(|(_, _, weight)| weight).sum();
        // Compression of the crest along its travel for a ratio of 1 of horizontal to vertical amplitude: Σ
        // w·k(d̂·d)².
        let compression: f64 = packet
            .iter()
            .map(|([x, z], forward, weight)| weight / total * forward * forward / libm::sqrt(x * x + z * z))
            .sum();
        packet
            .into_iter()
            .map(|([x, z], forward, weight)| {
                let (k, share) = (libm::sqrt(x * x + z * z), weight / total);
                within(WaveParameter::WavelengthInGroup, TAU / k, LENGTHS_M, "1e-6 to 1e9 meters")?;
                let angular_frequency = self.speed.map_or(libm::sqrt(GRAVITY * k), |speed| speed * forward);
                let travel = angular_frequency * self.time;
                Ok(Wave {
                    wavelength: TAU / k,
                    direction: [x / k, z / k],
                    amplitude: self.height * share,
                    horizontal: self.sharpness / compression * share,
                    angular_frequency,
                    phase: travel - (x * self.focus[0] + z * self.focus[1]),
                })
            })
            .collect()
    }

    fn validate(&self) -> Result<(), WaveError> {
        let any = (f64::MIN, f64::MAX);
        within(WaveParameter::Wavelength, self.wavelength, (1e-3, 1e6), "0.001 to 1,000,000 meters")?;
        within(WaveParameter::Height, self.height, any, "a finite number of meters")?;
        within(WaveParameter::Direction, self.direction, any, "a finite azimuth")?;
        let least = (Self::LEAST_ALONG, 1e6);
        within(WaveParameter::Along, self.along / self.wavelength, least, "0.31 wavelengths or more")?;
        within(WaveParameter::Across, self.across, (1e-3, 1e9), "0.001 to 1e9 meters")?;
        within(WaveParameter::Focus, self.focus[0], (-1e9, 1e9), "at most 1e9 meters from the origin")?;
        within(WaveParameter::Focus, self.focus[1], (-1e9, 1e9), "at most 1e9 meters from the origin")?;
        within(WaveParameter::Time, self.time, (-1e9, 1e9), "at most 1e9 seconds")?;
        within(WaveParameter::Sharpness, self.sharpness, (0.0, 1e3), "0 to 1000")?;
        within(WaveParameter::Speed, self.speed.unwrap_or(0.0), any, "a finite number of m/s")?;
        for count in self.waves {
            within(WaveParameter::Waves, count as f64, (1.0, MAX_GROUP as f64), "at least one wave each way")?;
        }
        within(
            WaveParameter::Waves,
            self.waves[0] as f64 * self.waves[1] as f64,
            (1.0, MAX_GROUP as f64),
            "at most 10,000 in all",
        )
    }
}

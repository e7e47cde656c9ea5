use std::f64::consts::TAU;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

use crate::wave::{GRAVITY, LENGTHS_M, Wave, WaveError, WaveFigure, within};

/// Most waves of one group.
pub const MAX_GROUP: usize = 10_000;

/// How far the wave numbers of a group reach, in their standard deviations, and how far chance moves each.
const REACH: f64 = 1.8;
const JITTER: f64 = 0.12;

/// One crest that is placed by hand: a packet of plain waves, all of whose crests meet at one place and time.
///
/// Wave vectors lie on a grid around that of the middle wave, k = d(k₀ + p/σ₁) + e·q/σ₂ with d the direction of
/// travel, e across it and p, q from −1.8 to 1.8, each moved a little by chance, so that the packet does not return;
/// amplitudes go by exp(−(p² + q²)/2) and sum to `height`. So the height at the focus is `height`, and around it
/// that of a wave under a bell of standard deviation σ₁ along and σ₂ across the travel.
///
/// Source: the wave packet of linear wave theory, e.g. Whitham, *Linear and Nonlinear Waves*, 1974, §11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveGroup {
    /// Length of the middle wave in meters, > 0.
    pub wavelength: f64,
    /// Height of the crest above the resting sea, at the focus, in meters.
    pub height: f64,
    /// Azimuth of travel in radians: 0 is +X, growing toward +Z.
    pub direction: f64,
    /// Standard deviation σ₁ of the packet along its travel in meters, at least 0.31 wavelengths: a shorter one would
    /// need waves that run the other way.
    pub along: f64,
    /// Standard deviation σ₂ across the travel in meters, > 0: half the length of the crest.
    pub across: f64,
    /// World x and z in meters where the crests meet.
    pub focus: [f64; 2],
    /// Time in seconds when they do.
    pub time: f64,
    /// Compression along the travel at the focus as a share of the cusp: 0 is a sum of sinusoids, at 1 the crest is a
    /// cusp, beyond it folds. ≥ 0.
    pub sharpness: f64,
    /// Pace in m/s at which the crest travels unchanged; deep water decides for each wave where it is left out, and
    /// the packet comes and goes.
    pub speed: Option<f64>,
    /// Waves along and across the travel, ≥ 1; few let the crest return nearby.
    pub waves: [usize; 2],
    /// Which of all groups that have these figures.
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
    /// The least [`along`](Self::along), in wavelengths.
    pub const LEAST_ALONG: f64 = 0.31;

    /// The waves of this group.
    ///
    /// # Errors
    /// A figure is outside its range.
    pub fn waves(&self) -> Result<Vec<Wave>, WaveError> {
        self.validate()?;
        let [d, e] = [0.0, TAU / 4.0].map(|turn| self.direction + turn).map(|a| [libm::cos(a), libm::sin(a)]);
        let middle = TAU / self.wavelength;
        let mut random = Pcg64::new(u128::from(self.seed), 0);
        let mut unit = || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let mut place = |index: usize, count: usize| {
            let moved = JITTER * (2.0 * unit() - 1.0);
            // A single wave stands in the middle.
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
        // What the crest compresses along its travel for a ratio of 1 of horizontal to vertical amplitude: Σ w·k(d̂·d)².
        let compression: f64 = packet
            .iter()
            .map(|([x, z], forward, weight)| weight / total * forward * forward / libm::sqrt(x * x + z * z))
            .sum();
        packet
            .into_iter()
            .map(|([x, z], forward, weight)| {
                let (k, share) = (libm::sqrt(x * x + z * z), weight / total);
                within(WaveFigure::WavelengthInGroup, TAU / k, LENGTHS_M, "1e-6 to 1e9 meters")?;
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
        within(WaveFigure::Wavelength, self.wavelength, (1e-3, 1e6), "0.001 to 1,000,000 meters")?;
        within(WaveFigure::Height, self.height, any, "a finite number of meters")?;
        within(WaveFigure::Direction, self.direction, any, "a finite azimuth")?;
        let least = (Self::LEAST_ALONG, 1e6);
        within(WaveFigure::Along, self.along / self.wavelength, least, "0.31 wavelengths or more")?;
        within(WaveFigure::Across, self.across, (1e-3, 1e9), "0.001 to 1e9 meters")?;
        within(WaveFigure::Focus, self.focus[0], (-1e9, 1e9), "at most 1e9 meters from the origin")?;
        within(WaveFigure::Focus, self.focus[1], (-1e9, 1e9), "at most 1e9 meters from the origin")?;
        within(WaveFigure::Time, self.time, (-1e9, 1e9), "at most 1e9 seconds")?;
        within(WaveFigure::Sharpness, self.sharpness, (0.0, 1e3), "0 to 1000")?;
        within(WaveFigure::Speed, self.speed.unwrap_or(0.0), any, "a finite number of m/s")?;
        for count in self.waves {
            within(WaveFigure::Waves, count as f64, (1.0, MAX_GROUP as f64), "at least one wave each way")?;
        }
        within(
            WaveFigure::Waves,
            self.waves[0] as f64 * self.waves[1] as f64,
            (1.0, MAX_GROUP as f64),
            "at most 10,000 in all",
        )
    }
}

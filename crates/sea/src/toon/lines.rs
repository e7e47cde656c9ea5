//! Lines that bursts draw behind them, as a mask.

use std::f64::consts::TAU;

use super::trail::{Drift, spread};

/// Drawing of lines at the phases of a [`Drift`].
///
/// A line's width is `thickness` times the distance to the next line, half to each side, times factors that each fall
/// to 0 continuously: √ of how far below its end the height is, how fresh the trail is, how well bursts agree on it,
/// and how many pixels the distance spans. Lines therefore appear and vanish only by tapering, for whatever reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Share of the distance between lines that a line covers at its thickest, 0 to 1.
    pub thickness: f64,
    /// Height in meters at which lines are thickest; they stay so beyond it, on the side away from `high`.
    pub low: f64,
    /// Height near which the longest lines end, in meters: even lines end at 0.75 to 1.1 of the way from `low`, odd
    /// lines at 0.35 to 0.65, so that their number falls with their width.
    pub high: f64,
    /// Shift of all lines, in line distances.
    pub shift: f64,
    /// Weight from which lines have their full width; must be above 0.
    pub fresh: f64,
    /// Spread in line distances up to which lines have their full width; at twice that they vanish.
    pub spread: f64,
    /// Pixels per line distance below which lines vanish; from twice that on they have their full width.
    pub finest: f64,
    /// Random seed.
    pub seed: u32,
}

impl Default for Lines {
    fn default() -> Self {
        Self { thickness: 0.6, low: 0.0, high: 2.0, shift: 0.0, fresh: 0.3, spread: 0.5, finest: 3.0, seed: 0 }
    }
}

/// Values at a position of the surface that determine its lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinePoint {
    /// Weight, 1 in the middle of bursts.
    pub weight: f64,
    /// Weight × (cos, sin) of the angle that counts lines.
    pub phase: [f64; 2],
    /// Height, in meters.
    pub height: f64,
    /// Lines per pixel: see [`density`].
    pub density: f64,
}

/// Number of lines in a quarter of a turn: beyond it, no angle can be determined between neighbors.
pub(crate) const TOO_MANY: f64 = Drift::LINES as f64 / 4.0;
/// Least density: everything is treated as at least this far away.
pub(crate) const LEAST_DENSITY: f64 = 1e-4;
/// Product of phases below which no angle can be determined.
pub(crate) const LEAST_NORM: f64 = 1e-30;
/// Weight relative to that of a fresh trail up to which nothing is drawn.
pub(crate) const STALE: f64 = 1e-3;
/// Share of the way from `low` to `high` at which the longest lines may end.
pub(crate) const FARTHEST_END: f64 = 1.1;

/// Returns the lines per pixel, from the phases of the pixels left and right, then above and below: along each axis
/// the larger of the two differences, of those that can be determined. If a neighbor is on another wave, often
/// neither can.
pub fn density(here: [f64; 2], beside: [[[f64; 2]; 2]; 2]) -> f64 {
    let across = |there: [f64; 2]| {
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let norm = square(here) * square(there);
        let cross = here[0] * there[1] - here[1] * there[0];
        // The sine approximates the angle.
        let lines = f64::from(Drift::LINES) / TAU * libm::sqrt(cross * cross / norm);
        (norm > LEAST_NORM && here[0] * there[0] + here[1] * there[1] > 0.0).then_some(lines)
    };
    let [x, z] = beside.map(|sides| sides.into_iter().filter_map(across).reduce(f64::max).unwrap_or(TOO_MANY));
    libm::sqrt(x * x + z * z).max(LEAST_DENSITY)
}

impl Lines {
    /// Returns the share of a pixel that lines cover.
    pub fn mask(&self, place: &LinePoint) -> f64 {
        let LinePoint { weight, phase, height, density } = *place;
        let shown = self.shown(weight, phase, density);
        if shown <= 0.0 {
            return 0.0;
        }
        let count = f64::from(Drift::LINES);
        let turns = libm::atan2(phase[1], phase[0]) / TAU;
        let at = (turns * count + self.shift).rem_euclid(count);
        let index = (at as u32).min(Drift::LINES - 1);
        let f = at - f64::from(index) - 0.5;
        // A pixel may be on two lines: this one and the next on its side.
        let beside = if f < 0.0 { index + Drift::LINES - 1 } else { index + 1 } % Drift::LINES;
        let own = self.covered(index, f, height, shown, density);
        let other = self.covered(beside, if f < 0.0 { f + 1.0 } else { f - 1.0 }, height, shown, density);
        (own + other).min(1.0)
    }

    /// Returns the share that is left of the widths of all lines.
    fn shown(&self, weight: f64, phase: [f64; 2], density: f64) -> f64 {
        if weight <= STALE * self.fresh {
            return 0.0;
        }
        let fresh = smooth(weight / self.fresh);
        let agreed = smooth(2.0 - spread(weight, phase) / self.spread);
        let wide = smooth(1.0 / (density * self.finest).max(1e-9) - 1.0);
        fresh * agreed * wide
    }

    /// Returns the share of a pixel covered by one line whose middle is about `f` line distances away.
    fn covered(&self, index: u32, f: f64, height: f64, shown: f64, density: f64) -> f64 {
        let density = density.max(LEAST_DENSITY);
        let [end, half, aside] = self.line(index);
        // Remaining share of the way from the thick end to the thin end.
        let left = if end == self.low { 0.0 } else { ((end - height) / (end - self.low)).clamp(0.0, 1.0) };
        let half = half * libm::sqrt(left) * shown;
        covered(f - aside, half, density)
    }

    /// Returns the height at which a line ends, half its largest width, and its displacement to the side, in line
    /// distances.
    pub(crate) fn line(&self, index: u32) -> [f64; 3] {
        let [end, width, aside] = [0, 1, 2].map(|what| unit(self.seed, index * 3 + what));
        let end = if index % 2 == 1 { 0.35 + 0.3 * end } else { 0.75 + 0.35 * end };
        let half = self.thickness / 2.0 * (0.7 + 0.3 * width);
        [self.low + (self.high - self.low) * end, half, 0.18 * (aside - 0.5)]
    }
}

/// Returns the share of a pixel of width `density`, at a distance `away` from a line's middle, that the line covers
/// with `half` its width to each side.
pub(crate) fn covered(away: f64, half: f64, density: f64) -> f64 {
    let (low, high) = ((away - density / 2.0).max(-half), (away + density / 2.0).min(half));
    ((high - low) / density).clamp(0.0, 1.0)
}

/// Returns 0 up to 0 and 1 from 1 on, with level ends.
pub(crate) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns a random number in 0…1 for an index: the finalizer of MurmurHash3.
fn unit(seed: u32, index: u32) -> f64 {
    let mut h = seed.wrapping_mul(0x9e37_79b9) ^ index.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from(h ^ (h >> 16)) / f64::from(u32::MAX)
}

//! Lines that bursts draw behind them, as a mask.

use std::f64::consts::TAU;

use super::trail::{Drift, spread};

/// How lines are drawn at the phases of a [`Drift`].
///
/// A line's width is `thickness` times its distance to the next one, half to each side, times factors that each fall to 0
/// without a jump: √ of how far its end lies above, how fresh the trail is, how well bursts agree on it, and how many
/// pixels its distance spans. So lines appear and vanish by tapering alone, wherever and for whatever reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Share of the distance between lines that a line covers at its thickest, 0 to 1.
    pub thickness: f64,
    /// Height in meters at which lines are thickest; beyond, on the side away from `high`, they stay so.
    pub low: f64,
    /// Height about which the longest lines have ended: even ones at 0.75 to 1.1 of the way from `low`, odd ones at 0.35
    /// to 0.65, so that their number falls with their width.
    pub high: f64,
    /// Distance in lines by which all are shifted.
    pub shift: f64,
    /// Weight from which on lines have their full width; must be above 0.
    pub fresh: f64,
    /// Spread in lines up to which they have their full width; at twice that they are gone.
    pub spread: f64,
    /// Pixels from line to line below which they are gone; from twice that on they have their full width.
    pub finest: f64,
    /// Which of all such drawings.
    pub seed: u32,
}

impl Default for Lines {
    fn default() -> Self {
        Self { thickness: 0.6, low: 0.0, high: 2.0, shift: 0.0, fresh: 0.3, spread: 0.5, finest: 3.0, seed: 0 }
    }
}

/// What a place of the surface knows of lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Weight, 1 in the middle of bursts.
    pub weight: f64,
    /// Weight × (cos, sin) of the angle that counts lines.
    pub phase: [f64; 2],
    /// Height in meters.
    pub height: f64,
    /// Lines across a pixel: see [`density`].
    pub density: f64,
}

/// Lines a quarter of a turn apart: beyond, no angle can be told between neighbors.
pub(crate) const TOO_MANY: f64 = Drift::LINES as f64 / 4.0;
/// Least density: nothing lies nearer.
pub(crate) const LEAST_DENSITY: f64 = 1e-4;
/// Phases whose product is less tell no angle.
pub(crate) const LEAST_NORM: f64 = 1e-30;
/// Weight, over that of a fresh trail, up to which nothing is drawn.
pub(crate) const STALE: f64 = 1e-3;

/// Lines across a pixel, from the phases of the pixels left and right, then above and below: along each axis the greater
/// of the two differences, of those that are told. Where a neighbor lies on another wave, often none is.
pub fn density(here: [f64; 2], beside: [[[f64; 2]; 2]; 2]) -> f64 {
    let across = |there: [f64; 2]| {
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let norm = square(here) * square(there);
        let cross = here[0] * there[1] - here[1] * there[0];
        // The sine stands for the angle.
        let lines = f64::from(Drift::LINES) / TAU * libm::sqrt(cross * cross / norm);
        (norm > LEAST_NORM && here[0] * there[0] + here[1] * there[1] > 0.0).then_some(lines)
    };
    let [x, z] = beside.map(|sides| sides.into_iter().filter_map(across).reduce(f64::max).unwrap_or(TOO_MANY));
    libm::sqrt(x * x + z * z).max(LEAST_DENSITY)
}

impl Lines {
    /// Share of a pixel that lines cover.
    pub fn mask(&self, place: &Place) -> f64 {
        let Place { weight, phase, height, density } = *place;
        let shown = self.shown(weight, phase, density);
        if shown <= 0.0 {
            return 0.0;
        }
        let count = f64::from(Drift::LINES);
        let turns = libm::atan2(phase[1], phase[0]) / TAU;
        let at = (turns * count + self.shift).rem_euclid(count);
        let index = (at as u32).min(Drift::LINES - 1);
        let f = at - f64::from(index) - 0.5;
        // A pixel may lie on two lines: this one and the next on its side.
        let beside = if f < 0.0 { index + Drift::LINES - 1 } else { index + 1 } % Drift::LINES;
        let own = self.covered(index, f, height, shown, density);
        let other = self.covered(beside, if f < 0.0 { f + 1.0 } else { f - 1.0 }, height, shown, density);
        (own + other).min(1.0)
    }

    /// What is left of all widths, whatever the line.
    fn shown(&self, weight: f64, phase: [f64; 2], density: f64) -> f64 {
        if weight <= STALE * self.fresh {
            return 0.0;
        }
        let fresh = smooth(weight / self.fresh);
        let agreed = smooth(2.0 - spread(weight, phase) / self.spread);
        let wide = smooth(1.0 / (density * self.finest).max(1e-9) - 1.0);
        fresh * agreed * wide
    }

    /// Share of a pixel that one line covers whose middle is about `f` line distances away.
    fn covered(&self, index: u32, f: f64, height: f64, shown: f64, density: f64) -> f64 {
        let density = density.max(LEAST_DENSITY);
        let [end, half, aside] = self.line(index);
        // Left of the way from the thick end to the thin one.
        let left = if end == self.low { 0.0 } else { ((end - height) / (end - self.low)).clamp(0.0, 1.0) };
        let half = half * libm::sqrt(left) * shown;
        covered(f - aside, half, density)
    }

    /// The height at which a line ends, half its greatest width, and by how much it lies aside, in distances of lines.
    pub(crate) fn line(&self, index: u32) -> [f64; 3] {
        let [end, width, aside] = [0, 1, 2].map(|what| unit(self.seed, index * 3 + what));
        let end = if index % 2 == 1 { 0.35 + 0.3 * end } else { 0.75 + 0.35 * end };
        let half = self.thickness / 2.0 * (0.7 + 0.3 * width);
        [self.low + (self.high - self.low) * end, half, 0.18 * (aside - 0.5)]
    }
}

/// Share of a pixel as wide as `density`, `away` from a line's middle, that the line covers to both sides by `half`.
pub(crate) fn covered(away: f64, half: f64, density: f64) -> f64 {
    let (low, high) = ((away - density / 2.0).max(-half), (away + density / 2.0).min(half));
    ((high - low) / density).clamp(0.0, 1.0)
}

/// 0 up to 0, 1 from 1 on, with level ends.
pub(crate) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A random number in 0…1 for an index: the finalizer of MurmurHash3.
fn unit(seed: u32, index: u32) -> f64 {
    let mut h = seed.wrapping_mul(0x9e37_79b9) ^ index.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from(h ^ (h >> 16)) / f64::from(u32::MAX)
}

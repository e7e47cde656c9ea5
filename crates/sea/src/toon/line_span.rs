//! Bounds on the mask of lines at a position that is itself known only within bounds.

use std::f64::consts::{PI, TAU};

use super::lines::{FARTHEST_END, LEAST_DENSITY, LEAST_NORM, Lines, STALE, TOO_MANY, covered, smooth};
use super::trail::Drift;

/// A phase that is known up to a distance.
#[derive(Clone, Copy, Debug)]
pub struct NearPhase {
    /// Its angle, and the largest error of it: π if the angle may be any.
    angle: f64,
    turn: f64,
    /// Bounds on its length.
    lengths: [f64; 2],
}

/// Known bounds at a position: each quantity lies between two numbers.
#[derive(Clone, Copy, Debug)]
pub struct NearPlace {
    /// Weight, 1 in the middle of bursts.
    pub weight: [f64; 2],
    /// The phase.
    pub phase: NearPhase,
    /// Height, in meters.
    pub height: [f64; 2],
    /// Lines per pixel: see [`density_span`].
    pub density: [f64; 2],
}

/// Rounding error of an angle or a share.
const LOST: f64 = 1e-15;

impl NearPhase {
    /// Makes a phase from weight × (cos, sin), and the largest distance of the true phase from it.
    pub fn new(phase: [f64; 2], within: f64) -> Self {
        let squared = phase[0] * phase[0] + phase[1] * phase[1];
        // Small squares lose digits.
        let length = if squared > 1e-250 { squared.sqrt() } else { libm::hypot(phase[0], phase[1]) };
        let sine = within / length;
        let turn = if within == 0.0 {
            0.0
        } else if sine < 0.1 {
            // The series of the arcsine is s + s³/6 + 3s⁵/40 + …
            sine + sine * sine * sine / 5.0
        } else if sine < 0.999_999 {
            libm::asin(sine)
        } else {
            PI
        };
        let lengths = [(length - within).max(0.0), length + within];
        Self { angle: libm::atan2(phase[1], phase[0]), turn: turn + LOST, lengths }
    }
}

/// Returns bounds on [`density`](super::lines::density), and whether it is certain which neighbors determine an
/// angle.
///
/// ```
/// use trochoid_sea::toon::{NearPhase, density_span, lines::density};
///
/// let phase = |angle: f64| [angle.cos(), angle.sin()];
/// let near = |angle: f64| NearPhase::new(phase(angle), 1e-3);
/// let ([low, high], clear) = density_span(near(0.0), [[near(-0.2), near(0.2)]; 2]);
/// let exact = density(phase(0.0), [[phase(-0.2), phase(0.2)]; 2]);
/// assert!(clear && low < exact && exact < high && high - low < 0.02);
/// ```
pub fn density_span(here: NearPhase, beside: [[NearPhase; 2]; 2]) -> ([f64; 2], bool) {
    let mut clear = true;
    let [x, z] = beside.map(|sides| {
        // Angles of neighbors that certainly determine one, and of those that may.
        let (mut sure, mut low, mut high) = (None::<f64>, f64::INFINITY, 0.0_f64);
        for there in sides {
            let (NearPhase { angle: a, turn: own, .. }, NearPhase { angle: b, turn: other, .. }) = (here, there);
            let norms = [0, 1].map(|end| here.lengths[end] * there.lengths[end]).map(|norm| norm * norm);
            let apart = (a - b).abs();
            let apart = apart.min(TAU - apart);
            let (least, most) = ((apart - own - other).max(0.0), apart + own + other);
            if least >= PI / 2.0 || norms[1] * (1.0 + 1e-12) <= LEAST_NORM {
                continue;
            }
            // An angle that is not a number may be any.
            (low, high) = (low.min(least), high.max(most.min(PI / 2.0)));
            if most < PI / 2.0 && norms[0] * (1.0 - 1e-12) > LEAST_NORM {
                sure = Some(sure.unwrap_or(0.0).max(least));
            } else {
                clear = false;
            }
        }
        // More lines the larger the angle.
        let lines = |angle: f64| f64::from(Drift::LINES) / TAU * libm::sin(angle);
        match sure {
            Some(least) => [lines(least), lines(high)],
            None if low.is_finite() => [lines(low), TOO_MANY],
            None => [TOO_MANY; 2],
        }
    });
    let of = |end: usize| libm::sqrt(x[end] * x[end] + z[end] * z[end]).max(LEAST_DENSITY);
    ([of(0) * (1.0 - LOST), of(1) * (1.0 + LOST)], clear)
}

impl Lines {
    /// Returns bounds on [`mask`](Self::mask), and whether it is continuous between them.
    ///
    /// ```
    /// use trochoid_sea::toon::{NearPhase, NearPlace, lines::{LinePoint, Lines}};
    ///
    /// let lines = Lines::default();
    /// let place = LinePoint { weight: 1.0, phase: [0.8, 0.6], height: 0.5, density: 0.1 };
    /// let near = |number: f64| [number - 1e-4, number + 1e-4];
    /// let ([low, high], _) = lines.mask_span(&NearPlace {
    ///     weight: near(place.weight),
    ///     phase: NearPhase::new(place.phase, 1e-4),
    ///     height: near(place.height),
    ///     density: near(place.density),
    /// });
    /// assert!(low <= lines.mask(&place) && lines.mask(&place) <= high && high - low < 0.1);
    /// ```
    pub fn mask_span(&self, place: &NearPlace) -> ([f64; 2], bool) {
        let [least, most] = self.shown_span(place);
        if most <= 0.0 {
            return ([0.0; 2], true);
        }
        // Stale trails end in a step, although a tiny one.
        let stale = STALE * self.fresh;
        let mut clear = place.weight[0] > stale || place.weight[1] <= stale;
        let count = f64::from(Drift::LINES);
        let NearPhase { angle, turn, .. } = place.phase;
        let (at, by) = (angle / TAU * count + self.shift, turn / TAU * count + LOST * (count + self.shift.abs()));
        // Within half a line distance, the two lines that may cover a pixel are the same.
        let halves = [at - by, at + by].map(|end| (2.0 * end).floor());
        if halves[1] - halves[0] > 1.0 || !by.is_finite() {
            return ([0.0, 1.0], false);
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut jump = [0.0; 2];
        let both = [halves[0], halves[1]];
        for &half in &both[..if halves[0] == halves[1] { 1 } else { 2 }] {
            let span = [(at - by).max(half / 2.0), (at + by).min(half / 2.0 + 0.5)];
            let line = (half / 2.0).floor();
            let index = line.rem_euclid(count) as u32 % Drift::LINES;
            let f = span.map(|end| end - line - 0.5);
            let is_before = half.rem_euclid(2.0) == 0.0;
            let (beside, aside) = if is_before { (index + Drift::LINES - 1, 1.0) } else { (index + 1, -1.0) };
            let own = self.covered_span(index, f, place, [least, most]);
            let other = self.covered_span(beside % Drift::LINES, f.map(|f| f + aside), place, [least, most]);
            low = low.min((own[0] + other[0]).min(1.0));
            high = high.max((own[1] + other[1]).min(1.0));
            // At the next half, another line comes in, which contributes nothing unless lines are crowded.
            jump[usize::from(is_before)] = other[1];
        }
        if halves[0] != halves[1] && halves[1].rem_euclid(2.0) == 1.0 {
            clear &= jump == [0.0; 2];
        }
        ([(low - LOST).max(0.0), (high + LOST).min(1.0)], clear)
    }

    /// Returns whether no line is shown under weights up to one.
    pub fn hides(&self, weight: f64) -> bool {
        weight <= STALE * self.fresh
    }

    /// Returns whether all lines certainly end before the heights between two, in meters.
    pub fn end_before(&self, [least, most]: [f64; 2]) -> bool {
        let farthest = self.low + FARTHEST_END * (self.high - self.low);
        let lost = 8.0 * LOST * (self.low.abs() + self.high.abs());
        if self.low < self.high { least > farthest + lost } else { most < farthest - lost }
    }

    /// Returns bounds on the share of all widths that is left.
    fn shown_span(&self, place: &NearPlace) -> [f64; 2] {
        let lengths = place.phase.lengths;
        let spread = |weight: f64, length: f64, lost: f64| {
            let kept = length / weight;
            let lost = (1.0 - kept * kept + lost).max(0.0);
            f64::from(Drift::LINES) / TAU * libm::sqrt(lost)
        };
        let weights = place.weight.map(|weight| weight.max(0.0));
        let spreads = [spread(weights[1], lengths[0], 4.0 * LOST), spread(weights[0], lengths[1], -4.0 * LOST)];
        let shown = |end: usize| {
            if self.hides(weights[end]) {
                return 0.0;
            }
            let agreed = smooth(2.0 - spreads[end] / self.spread);
            let wide = smooth(1.0 / (place.density[1 - end] * self.finest).max(1e-9) - 1.0);
            smooth(weights[end] / self.fresh) * agreed * wide
        };
        [shown(0) * (1.0 - 10.0 * LOST), shown(1) * (1.0 + 10.0 * LOST)]
    }

    /// Returns bounds on the coverage of a line whose middle is at a distance within `f`.
    fn covered_span(&self, index: u32, f: [f64; 2], place: &NearPlace, shown: [f64; 2]) -> [f64; 2] {
        let [end, half, aside] = self.line(index);
        let lost = LOST * (end.abs() + self.low.abs() + place.height[0].abs() + place.height[1].abs());
        let left = |height: f64| {
            if end == self.low { 0.0 } else { ((end - height) / (end - self.low)).clamp(0.0, 1.0) }
        };
        let lefts = [left(place.height[0] - lost), left(place.height[1] + lost)];
        let halves = [
            half * libm::sqrt(lefts[0].min(lefts[1])) * shown[0],
            half * libm::sqrt(lefts[0].max(lefts[1])) * shown[1],
        ];
        let [from, to] = f.map(|f| f - aside);
        let nearest = if from <= 0.0 && to >= 0.0 { 0.0 } else { from.abs().min(to.abs()) };
        let farthest = from.abs().max(to.abs());
        let [fine, coarse] = place.density;
        // The coverage of a pixel falls with the distance from the line and grows with its width. With larger pixels
        // it falls, but beside the line it first rises, until both edges are within the pixel.
        let best = if nearest < halves[1] { fine } else { (2.0 * (nearest + halves[1])).clamp(fine, coarse) };
        let of = |away: f64, half: f64, density: f64| covered(away, half, density);
        let least = of(farthest, halves[0], fine).min(of(farthest, halves[0], coarse));
        [(least - 1e-12).max(0.0), (of(nearest, halves[1], best) + 1e-12).min(1.0)]
    }
}

//! What bursts do to the cells, in f64: every cell, every burst that reaches it.

use std::f64::consts::PI;

use crate::toon::spline::Spline;
use crate::toon::{Burst, Combine, LITERAL_HZ, Shape, ToonSea};

/// A burst at one time.
pub(super) struct ActiveBurst<'a> {
    burst: &'a Burst,
    center: [f64; 2],
    /// Cosine and sine of its heading.
    heading: [f64; 2],
    /// Share of the height that the fade leaves.
    left: f64,
    /// Turns of its drift lines.
    turns: f64,
    /// Distance from its center within which it has any effect.
    reach: f64,
}

impl<'a> ActiveBurst<'a> {
    /// Returns the bursts that are active. Their turns are 0 unless the sea has the lengths of paths.
    pub(super) fn all(sea: &'a ToonSea, time: f64) -> Vec<Self> {
        let passing = |(index, burst): (usize, &'a Burst)| {
            let spline = Spline(burst.path);
            let (lap, progress) = burst.progress(time);
            let (rift, drift) = (sea.behavior.rift, sea.behavior.drift);
            let (radii, _) = burst.profile(sea.behavior.shape);
            let farthest = |[a, b]: [f64; 2]| a.max(b);
            let raised = match sea.behavior.shape {
                Shape::Intended => burst.peak * farthest(burst.influence),
                Shape::Literal => f64::INFINITY,
            };
            let drawn = farthest([radii[0] * drift.reach[0], radii[1] * drift.reach[1]]);
            Self {
                burst,
                center: spline.point(progress),
                heading: spline.heading(progress),
                left: burst.left(progress),
                turns: sea.lengths.get(index).map_or(0.0, |lengths| drift.along(lap, progress, lengths)),
                // Rounding must not cut off values that are nearly 0.
                reach: (1.0 + 1e-9) * raised.max(drawn).max(rift.distance),
            }
        };
        sea.bursts.iter().enumerate().filter(|(_, burst)| burst.is_active(time)).map(passing).collect()
    }

    /// Returns whether it may have an effect at a position.
    fn reaches(&self, [x, z]: [f64; 2]) -> bool {
        let (dx, dz) = (x - self.center[0], z - self.center[1]);
        dx * dx + dz * dz <= self.reach * self.reach
    }

    /// Returns a position relative to it, along its heading and across it if it is oriented.
    fn local(&self, [x, z]: [f64; 2], oriented: bool) -> [f64; 2] {
        let [cos, sin] = if oriented { self.heading } else { [1.0, 0.0] };
        let (dx, dz) = (x - self.center[0], z - self.center[1]);
        [dx * cos + dz * sin, dz * cos - dx * sin]
    }

    /// Returns its height at a position.
    fn profile(&self, sea: &ToonSea, place: [f64; 2]) -> f64 {
        let [along, across] = self.local(place, sea.behavior.oriented);
        let Burst { influence, peak: p, height: h, .. } = *self.burst;
        let distance = libm::hypot(along / influence[0], across / influence[1]);
        self.left
            * match sea.behavior.shape {
                Shape::Intended => p * h / 2.0 * (libm::cos((PI * distance / p).min(PI)) + 1.0),
                Shape::Literal => h * libm::cos((p * distance).min(PI) + 1.0),
            }
    }
}

/// The cells of a row, and the bursts that may reach them, in their order.
pub(super) struct Row<'a> {
    sea: &'a ToonSea,
    bursts: Vec<&'a ActiveBurst<'a>>,
    z: f64,
}

impl<'a> Row<'a> {
    pub(super) fn new(sea: &'a ToonSea, bursts: &'a [ActiveBurst<'a>], row: usize) -> Self {
        let z = row as f64 * sea.basin.spacing;
        let near = |burst: &&ActiveBurst<'_>| (z - burst.center[1]).abs() <= burst.reach;
        Self { sea, bursts: bursts.iter().filter(near).collect(), z }
    }

    /// Returns the place of a cell, and the bursts that reach it.
    fn reached(&self, column: usize) -> ([f64; 2], impl Iterator<Item = &ActiveBurst<'a>>) {
        let place = [column as f64 * self.sea.basin.spacing, self.z];
        (place, self.bursts.iter().copied().filter(move |burst| burst.reaches(place)))
    }

    /// Computes the force of a step.
    pub(super) fn force(&self, out: &mut [f64]) {
        for (column, out) in out.iter_mut().enumerate() {
            let (place, bursts) = self.reached(column);
            *out = self.sea.injection() * bursts.map(|burst| burst.profile(self.sea, place)).sum::<f64>();
        }
    }

    /// Lets an interval, in seconds, pass for the rift.
    pub(super) fn rift(&self, seconds: f64, values: &mut [f64]) {
        let rift = self.sea.behavior.rift;
        let [left, added] = decayed(rift.decay, seconds);
        for (column, value) in values.iter_mut().enumerate() {
            let ([x, z], bursts) = self.reached(column);
            let inside = bursts.map(|burst| {
                let [dx, dz] = [x - burst.center[0], z - burst.center[1]];
                (rift.distance - libm::hypot(dx, dz)).max(0.0)
            });
            let near = match rift.combine {
                Combine::Sum => inside.sum(),
                Combine::Nearest => inside.fold(0.0, f64::max),
            };
            *value = *value * left + rift.gain * near * added;
        }
    }

    /// Lets an interval, in seconds, pass for the five fields of drift lines.
    pub(super) fn drift(&self, seconds: f64, values: &mut [[f64; 5]]) {
        let (drift, spacing) = (self.sea.behavior.drift, self.sea.basin.spacing);
        let [left, added] = decayed(drift.decay, seconds);
        for (column, values) in values.iter_mut().enumerate() {
            let (place, bursts) = self.reached(column);
            let mut sums = [0.0; 5];
            for active in bursts {
                let [a, l] = active.local(place, true);
                let (radii, _) = active.burst.profile(self.sea.behavior.shape);
                let q = libm::hypot(a / (radii[0] * drift.reach[0]), l / (radii[1] * drift.reach[1]));
                let weight = active.left * (1.0 - q * q).max(0.0) * (1.0 - q * q).max(0.0);
                let swept = drift.lag * libm::sqrt(l * l + drift.softness(spacing));
                let angle = |meters: f64, turns: f64| libm::sincos(2.0 * PI * (meters * drift.frequency() + turns));
                let (along_sin, along_cos) = angle(a - swept, active.turns);
                let (across_sin, across_cos) = angle(active.burst.lane + l, 0.0);
                for (sum, value) in sums.iter_mut().zip([1.0, along_cos, along_sin, across_cos, across_sin]) {
                    *sum += weight * value;
                }
            }
            let renewed = 1.0 + drift.renewal * seconds * LITERAL_HZ * sums[0];
            for (value, sum) in values.iter_mut().zip(sums) {
                *value = (*value * left + sum * added) / renewed;
            }
        }
    }
}

/// Returns the share that is left of a trail after an interval, and Σ (1+ε)⁻ʲ over its literal steps j.
pub(super) fn decayed(decay: f64, seconds: f64) -> [f64; 2] {
    let steps = seconds * LITERAL_HZ;
    let left = libm::pow(1.0 + decay, -steps);
    [left, if decay > 0.0 { (1.0 - left) / decay } else { steps }]
}

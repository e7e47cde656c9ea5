//! What bursts do to the cells of a row, in f64 and plain loops: every cell, every burst.

use std::f64::consts::PI;

use super::DRIFTS;
use super::bursts::{ActiveBurst, decayed};
use crate::toon::{Burst, Combine, LITERAL_HZ, Shape, ToonSea};

/// A row of cells under bursts.
pub(super) struct Row<'a> {
    pub(super) sea: &'a ToonSea,
    pub(super) bursts: &'a [ActiveBurst<'a>],
    pub(super) row: usize,
}

/// Returns a position relative to a burst, along an axis and across it.
fn local(active: &ActiveBurst<'_>, [x, z]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    let (dx, dz) = (x - active.center[0], z - active.center[1]);
    [dx * cos + dz * sin, dz * cos - dx * sin]
}

/// Returns the height of a burst at a position.
fn profile(active: &ActiveBurst<'_>, sea: &ToonSea, place: [f64; 2]) -> f64 {
    let [along, across] = local(active, place, active.axis(sea.behavior.oriented));
    let Burst { influence, peak: p, height: h, .. } = *active.burst;
    let distance = libm::hypot(along / influence[0], across / influence[1]);
    active.left
        * match sea.behavior.shape {
            Shape::Intended => p * h / 2.0 * (libm::cos((PI * distance / p).min(PI)) + 1.0),
            Shape::Literal => h * libm::cos((p * distance).min(PI) + 1.0),
        }
}

impl Row<'_> {
    fn place(&self, column: usize) -> [f64; 2] {
        [column, self.row].map(|index| index as f64 * self.sea.basin.spacing)
    }

    /// Computes the force of a step.
    pub(super) fn force(&self, out: &mut [f64]) {
        for (column, out) in out.iter_mut().enumerate() {
            let place = self.place(column);
            *out = self.sea.injection() * self.bursts.iter().map(|burst| profile(burst, self.sea, place)).sum::<f64>();
        }
    }

    /// Lets an interval, in seconds, pass for the rift.
    pub(super) fn rift(&self, seconds: f64, values: &mut [f64]) {
        let rift = self.sea.behavior.rift;
        let [left, added] = decayed(rift.decay, seconds);
        for (column, value) in values.iter_mut().enumerate() {
            let [x, z] = self.place(column);
            let inside = self.bursts.iter().map(|burst| {
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

    /// Lets an interval, in seconds, pass for the fields of drift lines, one after another.
    pub(super) fn drift(&self, seconds: f64, values: &mut [f64]) {
        let (drift, basin) = (self.sea.behavior.drift, self.sea.basin);
        let [left, added] = decayed(drift.decay, seconds);
        for column in 0..basin.columns {
            let mut sums = [0.0; DRIFTS];
            for active in self.bursts {
                let [a, l] = local(active, self.place(column), active.heading);
                let (radii, _) = active.burst.profile(self.sea.behavior.shape);
                let q = libm::hypot(a / (radii[0] * drift.reach[0]), l / (radii[1] * drift.reach[1]));
                let weight = active.left * (1.0 - q * q).max(0.0) * (1.0 - q * q).max(0.0);
                let swept = drift.lag * libm::sqrt(l * l + drift.softness(basin.spacing));
                let angle = |meters: f64, turns: f64| libm::sincos(2.0 * PI * (meters * drift.frequency() + turns));
                let (along_sin, along_cos) = angle(a - swept, active.turns);
                let (across_sin, across_cos) = angle(active.burst.lane + l, 0.0);
                for (sum, value) in sums.iter_mut().zip([1.0, along_cos, along_sin, across_cos, across_sin]) {
                    *sum += weight * value;
                }
            }
            let renewed = 1.0 + drift.renewal * seconds * LITERAL_HZ * sums[0];
            for (field, sum) in sums.into_iter().enumerate() {
                let value = &mut values[field * basin.columns + column];
                *value = (*value * left + sum * added) / renewed;
            }
        }
    }
}

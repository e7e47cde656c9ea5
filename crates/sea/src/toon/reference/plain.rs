//! What bursts do to the cells of a row, in f64 and plain loops: every cell, every burst.

use super::DRIFTS;
use super::bursts::{ActiveBurst, MOST_HALF_TURNS, Profile};
use crate::kernel64::{COSINE, SINE};
use crate::toon::trail::decayed;
use crate::toon::{Combine, LITERAL_HZ, ToonSea};

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

/// Returns sine and cosine of an angle in half turns by the polynomials of `kernel64`.
fn sincos(half_turns: f64) -> [f64; 2] {
    let nearest = half_turns.round_ties_even();
    let y = half_turns - nearest;
    let polynomial =
        |coefficients: &[f64]| coefficients.iter().fold(0.0, |sum, coefficient| sum * (y * y) + coefficient);
    let sign = if nearest.rem_euclid(2.0) == 1.0 { -1.0 } else { 1.0 };
    [sign * (polynomial(&SINE) * y), sign * polynomial(&COSINE)]
}

/// Returns the height of a burst at a position.
fn height(active: &ActiveBurst<'_>, sea: &ToonSea, place: [f64; 2]) -> f64 {
    let [along, across] = local(active, place, active.axis(sea.behavior.oriented));
    let Profile { inverse, shift, raise, factor } = active.profile(sea.behavior.shape);
    let distance = length(along * inverse[0], across * inverse[1]);
    let [_, cos] = sincos(distance.min(1.0) + shift);
    factor * (cos + raise)
}

fn length(x: f64, z: f64) -> f64 {
    libm::sqrt(x * x + z * z)
}

impl Row<'_> {
    fn place(&self, column: usize) -> [f64; 2] {
        [column, self.row].map(|index| index as f64 * self.sea.basin.spacing)
    }

    /// Computes the force of a step.
    pub(super) fn force(&self, out: &mut [f64]) {
        for (column, out) in out.iter_mut().enumerate() {
            let place = self.place(column);
            *out = self.sea.injection() * self.bursts.iter().map(|burst| height(burst, self.sea, place)).sum::<f64>();
        }
    }

    /// Lets an interval, in seconds, pass for the rift.
    pub(super) fn rift(&self, seconds: f64, values: &mut [f64]) {
        let rift = self.sea.behavior.rift;
        let (left, added) = decayed(rift.decay, seconds * LITERAL_HZ);
        for (column, value) in values.iter_mut().enumerate() {
            let [x, z] = self.place(column);
            let inside = self.bursts.iter().map(|burst| {
                let [dx, dz] = [x - burst.center[0], z - burst.center[1]];
                (rift.distance - length(dx, dz)).max(0.0)
            });
            let near = match rift.combine {
                Combine::Sum => inside.sum(),
                Combine::Nearest => inside.fold(0.0, f64::max),
            };
            *value = *value * left + near * (rift.gain * added);
        }
    }

    /// Lets an interval, in seconds, pass for the fields of drift lines, one after another.
    pub(super) fn drift(&self, seconds: f64, values: &mut [f64]) {
        let (drift, basin) = (self.sea.behavior.drift, self.sea.basin);
        let (left, added) = decayed(drift.decay, seconds * LITERAL_HZ);
        for column in 0..basin.columns {
            let mut sums = [0.0; DRIFTS];
            for active in self.bursts {
                let [a, l] = local(active, self.place(column), active.heading);
                let inverse = active.drawn_inverse(self.sea);
                let [along, across] = [a * inverse[0], l * inverse[1]];
                let inside = (1.0 - (along * along + across * across)).max(0.0);
                let weight = inside * active.left * inside;
                let swept = drift.lag * libm::sqrt(l * l + drift.softness(basin.spacing));
                let angle = |meters: f64, turns: f64| {
                    sincos((2.0 * (meters * drift.frequency() + turns)).clamp(-MOST_HALF_TURNS, MOST_HALF_TURNS))
                };
                let [along_sin, along_cos] = angle(a - swept, active.turns);
                let [across_sin, across_cos] = angle(active.burst.lane + l, 0.0);
                for (sum, value) in sums.iter_mut().zip([1.0, along_cos, along_sin, across_cos, across_sin]) {
                    *sum += weight * value;
                }
            }
            let kept = 1.0 / (1.0 + drift.renewal * seconds * LITERAL_HZ * sums[0]);
            for (field, sum) in sums.into_iter().enumerate() {
                let value = &mut values[field * basin.columns + column];
                *value = (*value * left + sum * added) * kept;
            }
        }
    }
}

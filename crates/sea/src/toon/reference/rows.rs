//! What bursts do to the cells of a row, eight cells at a time: the same numbers as the plain loops.
//!
//! Every cell takes the operations of those in their order. What is left out is exact zeros: bursts that do not reach a
//! cell, and trails that have not begun.

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};

use super::DRIFTS;
use super::bursts::{ActiveBurst, Ellipse, MOST_HALF_TURNS, Profile};
use crate::kernel64::{LANES, sincos};
use crate::toon::{Combine, ToonSea};

/// The bursts of a step, each with the cells that it may change; `None` are all.
pub(super) struct Step<'a> {
    sea: &'a ToonSea,
    bursts: Vec<(ActiveBurst<'a>, Option<Ellipse>)>,
}

/// What an interval does to trails: the share that it leaves, the factor of what bursts add, and the share that each unit
/// of their weight renews.
#[derive(Clone, Copy)]
pub(super) struct Interval {
    pub(super) left: f64,
    pub(super) added: f64,
    pub(super) renewal: f64,
}

/// A burst of a step that may reach a row.
struct Near {
    /// Its index in the step.
    burst: usize,
    /// Distance of the row from its center, along z.
    dz: f64,
    columns: Range<usize>,
}

/// Memory for the sums over bursts in a row of cells, and for the bursts that reach it. What lies beyond the row is not
/// part of the sums.
#[derive(Default)]
pub(super) struct Sums {
    sums: Vec<f64>,
    near: Vec<Near>,
}

/// Returns zeros for some fields of a row, and the length of each. Beyond `reached`, they may be anything.
fn cleared<'a>(
    sums: &'a mut Vec<f64>,
    fields: usize,
    columns: usize,
    reached: &Range<usize>,
) -> (&'a mut [f64], usize) {
    let length = columns.next_multiple_of(LANES);
    sums.resize(fields * length, 0.0);
    for field in sums.chunks_exact_mut(length) {
        field[reached.clone()].fill(0.0);
    }
    (sums, length)
}

impl<'a> Step<'a> {
    /// Returns the bursts that are active at a time; `ellipse` tells where they count.
    pub(super) fn new(sea: &'a ToonSea, time: f64, ellipse: impl Fn(&ActiveBurst<'a>) -> Option<Ellipse>) -> Self {
        let placed = |burst: ActiveBurst<'a>| {
            let ellipse = ellipse(&burst);
            (burst, ellipse)
        };
        Self { sea, bursts: ActiveBurst::all(sea, time).into_iter().map(placed).collect() }
    }

    /// Returns the bursts.
    pub(super) fn active(&self) -> impl Iterator<Item = &ActiveBurst<'a>> {
        self.bursts.iter().map(|(burst, _)| burst)
    }

    /// Finds the bursts that may reach a row. Returns columns that contain all that they may reach, from a multiple of
    /// [`LANES`] to one, which may lie beyond the row.
    fn find(&self, row: usize, near: &mut Vec<Near>) -> Range<usize> {
        near.clear();
        let z = row as f64 * self.sea.basin.spacing;
        let [mut start, mut end] = [usize::MAX, 0];
        for (index, (burst, ellipse)) in self.bursts.iter().enumerate() {
            let columns = ellipse.as_ref().map_or(0..self.sea.basin.columns, |ellipse| ellipse.columns(z));
            if columns.is_empty() {
                continue;
            }
            (start, end) = (start.min(columns.start), end.max(columns.end));
            near.push(Near { burst: index, dz: z - burst.center[1], columns });
        }
        if near.is_empty() { 0..0 } else { start..end.next_multiple_of(LANES) }
    }

    /// Computes the force of the step on a row. Returns the largest.
    pub(super) fn force(&self, level: Level, row: usize, sums: &mut Sums, out: &mut [f64]) -> f64 {
        let Sums { sums, near } = sums;
        let reached = self.find(row, near);
        out[..reached.start].fill(0.0);
        out[reached.end.min(self.sea.basin.columns)..].fill(0.0);
        if near.is_empty() {
            return 0.0;
        }
        let (sums, _) = cleared(sums, 1, out.len(), &reached);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || self.force_on(simd, near, sums, reached, out)))
    }

    #[inline(always)]
    fn force_on<S: Simd>(
        &self,
        simd: S,
        near: &[Near],
        sums: &mut [f64],
        reached: Range<usize>,
        out: &mut [f64],
    ) -> f64 {
        let sea = self.sea;
        let one = f64x8::splat(simd, 1.0);
        for Near { burst, dz, columns } in near {
            let active = &self.bursts[*burst].0;
            let Profile { inverse, shift, raise, factor } = active.profile(sea.behavior.shape);
            let axis = active.axis(sea.behavior.oriented);
            for at in columns.clone().step_by(LANES) {
                let [along, across] = local(simd, sea, active, at, *dz, axis);
                let [along, across] = [along * inverse[0], across * inverse[1]];
                let distance = (along * along + across * across).sqrt();
                let [_, cos] = sincos(simd, distance.min(one) + shift);
                add(simd, &mut sums[at..], (cos + raise) * factor);
            }
        }
        let injection = sea.injection();
        let mut most = f64x8::splat(simd, 0.0);
        for at in reached.step_by(LANES) {
            let force = load(simd, &sums[at..out.len()]) * injection;
            most = most.max(force.abs());
            store(force, &mut out[at..]);
        }
        most.reduce_max()
    }

    /// Lets an interval pass for the rift of a row; `is_still` tells that it is 0 everywhere. Returns the
    /// largest value of those that did not only decay.
    pub(super) fn rift(
        &self,
        level: Level,
        interval: Interval,
        row: usize,
        sums: &mut Sums,
        values: &mut [f64],
        is_still: bool,
    ) -> f64 {
        let Sums { sums, near } = sums;
        let reached = self.find(row, near);
        if near.is_empty() && is_still {
            return 0.0;
        }
        let (sums, _) = cleared(sums, 1, values.len(), &reached);
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || self.rift_on(simd, interval, near, sums, reached, values)
        ))
    }

    #[inline(always)]
    fn rift_on<S: Simd>(
        &self,
        simd: S,
        interval: Interval,
        near: &[Near],
        sums: &mut [f64],
        reached: Range<usize>,
        values: &mut [f64],
    ) -> f64 {
        let rift = self.sea.behavior.rift;
        let zero = f64x8::splat(simd, 0.0);
        for Near { burst, dz, columns } in near {
            let active = &self.bursts[*burst].0;
            for at in columns.clone().step_by(LANES) {
                let dx = offset(simd, self.sea, active, at);
                let distance = (dx * dx + dz * dz).sqrt();
                let inside = (distance * -1.0 + rift.distance).max(zero);
                match rift.combine {
                    Combine::Sum => add(simd, &mut sums[at..], inside),
                    Combine::Nearest => store(load(simd, &sums[at..]).max(inside), &mut sums[at..]),
                }
            }
        }
        let Interval { left, added, .. } = interval;
        decay(values, &reached, left);
        let mut most = zero;
        for at in reached.step_by(LANES) {
            let near = load(simd, &sums[at..values.len()]);
            let value = load(simd, &values[at..]) * left + near * added;
            most = most.max(value.abs());
            store(value, &mut values[at..]);
        }
        most.reduce_max()
    }

    /// Lets an interval pass for the fields of drift lines of a row, one after another; `is_still` tells
    /// that they are 0 everywhere. Returns the largest value of those that did not only decay.
    pub(super) fn drift(
        &self,
        level: Level,
        interval: Interval,
        row: usize,
        sums: &mut Sums,
        values: &mut [f64],
        is_still: bool,
    ) -> f64 {
        let Sums { sums, near } = sums;
        let reached = self.find(row, near);
        if near.is_empty() && is_still {
            return 0.0;
        }
        let (sums, length) = cleared(sums, DRIFTS, self.sea.basin.columns, &reached);
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || {
                self.draw(simd, near, sums, length);
                self.drift_on(simd, interval, sums, length, &reached, values)
            }
        ))
    }

    /// Adds the coordinates of drift lines in a row, in fields of a length.
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, near: &[Near], sums: &mut [f64], length: usize) {
        let (drift, spacing) = (self.sea.behavior.drift, self.sea.basin.spacing);
        let (frequency, softness) = (drift.frequency(), drift.softness(spacing));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let farthest = f64x8::splat(simd, MOST_HALF_TURNS);
        for Near { burst, dz, columns } in near {
            let active = &self.bursts[*burst].0;
            let inverse = active.drawn_inverse(self.sea);
            for at in columns.clone().step_by(LANES) {
                let [a, l] = local(simd, self.sea, active, at, *dz, active.heading);
                let [along, across] = [a * inverse[0], l * inverse[1]];
                let inside = (one - (along * along + across * across)).max(zero);
                let weight = inside * active.left * inside;
                let swept = (l * l + softness).sqrt() * drift.lag;
                let angle = |meters: f64x8<S>, turns: f64| {
                    ((meters * frequency + turns) * 2.0).max(farthest * -1.0).min(farthest)
                };
                let [along_sin, along_cos] = sincos(simd, angle(a - swept, active.turns));
                let [across_sin, across_cos] = sincos(simd, angle(l + active.burst.lane, 0.0));
                let values = [one, along_cos, along_sin, across_cos, across_sin];
                for (field, value) in values.into_iter().enumerate() {
                    add(simd, &mut sums[field * length + at..], weight * value);
                }
            }
        }
    }

    /// Lets an interval pass under sums in fields of a length, which are 0 beyond the columns reached.
    #[inline(always)]
    fn drift_on<S: Simd>(
        &self,
        simd: S,
        interval: Interval,
        sums: &[f64],
        length: usize,
        reached: &Range<usize>,
        values: &mut [f64],
    ) -> f64 {
        let columns = self.sea.basin.columns;
        let Interval { left, added, renewal } = interval;
        for values in values.chunks_exact_mut(columns) {
            decay(values, reached, left);
        }
        let one = f64x8::splat(simd, 1.0);
        let mut most = f64x8::splat(simd, 0.0);
        for at in reached.clone().step_by(LANES) {
            let kept = one / (load(simd, &sums[at..columns]) * renewal + one);
            for field in 0..DRIFTS {
                let values = &mut values[field * columns + at..(field + 1) * columns];
                let sum = load(simd, &sums[field * length..][at..columns]);
                let value = (load(simd, values) * left + sum * added) * kept;
                most = most.max(value.abs());
                store(value, values);
            }
        }
        most.reduce_max()
    }
}

/// Decays what no burst reaches in a row. Inlined, so that it uses the vectors of its caller.
#[inline(always)]
fn decay(values: &mut [f64], reached: &Range<usize>, left: f64) {
    for value in &mut values[..reached.start] {
        *value *= left;
    }
    let end = reached.end.min(values.len());
    for value in &mut values[end..] {
        *value *= left;
    }
}

/// Returns x of cells relative to a burst.
#[inline(always)]
fn offset<S: Simd>(simd: S, sea: &ToonSea, active: &ActiveBurst<'_>, column: usize) -> f64x8<S> {
    let lanes = f64x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    (lanes + column as f64) * sea.basin.spacing - active.center[0]
}

/// Returns the positions of cells relative to a burst, along an axis and across it.
#[inline(always)]
fn local<S: Simd>(
    simd: S,
    sea: &ToonSea,
    active: &ActiveBurst<'_>,
    column: usize,
    dz: f64,
    [cos, sin]: [f64; 2],
) -> [f64x8<S>; 2] {
    let dx = offset(simd, sea, active, column);
    [dx * cos + dz * sin, f64x8::splat(simd, dz * cos) - dx * sin]
}

/// Returns the first numbers of a slice, with zeros if they are few.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, values: &[f64]) -> f64x8<S> {
    match values.first_chunk::<LANES>() {
        Some(values) => f64x8::load_array_ref(simd, values),
        None => {
            let mut lanes = [0.0; LANES];
            lanes[..values.len()].copy_from_slice(values);
            f64x8::load_array(simd, lanes)
        }
    }
}

/// Stores numbers at the start of a slice, as many as it has.
#[inline(always)]
pub(super) fn store<S: Simd>(found: f64x8<S>, values: &mut [f64]) {
    match values.first_chunk_mut::<LANES>() {
        Some(values) => found.store_array(values),
        None => values.copy_from_slice(&found.to_array()[..values.len()]),
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, sums: &mut [f64], found: f64x8<S>) {
    store(load(simd, sums) + found, sums);
}

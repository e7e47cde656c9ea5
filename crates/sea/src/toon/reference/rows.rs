//! What bursts do to the cells of a row, eight cells at a time: the same numbers as the plain loops.
//!
//! Every cell takes the operations of those in their order. What is left out is exact zeros: bursts that do not reach a
//! cell, and trails that have not begun.

use std::f64::consts::PI;
use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};

use super::DRIFTS;
use super::bursts::{ActiveBurst, Ellipse, decayed};
use super::functions::{LANES, hypot, sincos};
use crate::toon::{Burst, Combine, LITERAL_HZ, Shape, ToonSea};

/// The bursts of a step, each with the cells that it may change; `None` are all.
pub(super) struct Step<'a> {
    sea: &'a ToonSea,
    bursts: Vec<(ActiveBurst<'a>, Option<Ellipse>)>,
}

/// Sums over bursts in a row of cells, kept to reuse their memory. What lies beyond the row is not part of them.
#[derive(Default)]
pub(super) struct Sums(Vec<f64>);

impl Sums {
    /// Returns zeros for some fields of a row, and the length of each. Beyond `reached`, they may be anything.
    fn cleared(&mut self, fields: usize, columns: usize, reached: &Range<usize>) -> (&mut [f64], usize) {
        let length = columns.next_multiple_of(LANES);
        self.0.resize(fields * length, 0.0);
        for field in self.0.chunks_exact_mut(length) {
            field[reached.start..reached.end.next_multiple_of(LANES)].fill(0.0);
        }
        (&mut self.0, length)
    }
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

    /// Returns the bursts that may reach a row, each with the distance of the row along z and the columns.
    fn reaching(&self, row: usize) -> impl Iterator<Item = (&ActiveBurst<'a>, f64, Range<usize>)> {
        let z = row as f64 * self.sea.basin.spacing;
        let columns = self.sea.basin.columns;
        let near = self.bursts.iter().map(move |(burst, ellipse)| {
            let reached = ellipse.as_ref().map_or(0..columns, |ellipse| ellipse.columns(z));
            (burst, z - burst.center[1], reached)
        });
        near.filter(|(.., columns)| !columns.is_empty())
    }

    /// Returns columns that contain all that bursts may reach in a row, from a multiple of [`LANES`].
    fn reached(&self, row: usize) -> Range<usize> {
        let all = self.reaching(row).map(|(.., columns)| columns);
        all.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    }

    /// Computes the force of the step on a row. Returns the largest.
    pub(super) fn force(&self, level: Level, row: usize, sums: &mut Sums, out: &mut [f64]) -> f64 {
        if self.reaching(row).next().is_none() {
            out.fill(0.0);
            return 0.0;
        }
        let (sums, _) = sums.cleared(1, out.len(), &(0..out.len()));
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || self.force_on(simd, row, sums, out)))
    }

    #[inline(always)]
    fn force_on<S: Simd>(&self, simd: S, row: usize, sums: &mut [f64], out: &mut [f64]) -> f64 {
        let sea = self.sea;
        for (active, dz, columns) in self.reaching(row) {
            let Burst { influence, peak: p, height: h, .. } = *active.burst;
            let axis = active.axis(sea.behavior.oriented);
            for at in columns.step_by(LANES) {
                let [along, across] = local(simd, sea, active, at, dz, axis);
                let distance = hypot(simd, along / influence[0], across / influence[1]);
                let height = match sea.behavior.shape {
                    Shape::Intended => {
                        let angle = distance * PI / p;
                        let is_beyond = angle.simd_ge(f64x8::splat(simd, PI));
                        let [_, cos] = sincos(simd, is_beyond.select(f64x8::splat(simd, 0.0), angle));
                        (is_beyond.select(f64x8::splat(simd, -1.0), cos) + 1.0) * (p * h / 2.0)
                    }
                    Shape::Literal => {
                        let [_, cos] = sincos(simd, (distance * p).min(f64x8::splat(simd, PI)) + 1.0);
                        cos * h
                    }
                };
                add(simd, &mut sums[at..], height * active.left);
            }
        }
        let injection = sea.injection();
        let mut most = f64x8::splat(simd, 0.0);
        for at in (0..out.len()).step_by(LANES) {
            let force = load(simd, &sums[at..out.len()]) * injection;
            most = most.max(force.abs());
            store(force, &mut out[at..]);
        }
        most.reduce_max()
    }

    /// Lets an interval, in seconds, pass for the rift of a row, whose largest value is given. Returns the largest.
    pub(super) fn rift(
        &self,
        level: Level,
        seconds: f64,
        row: usize,
        sums: &mut Sums,
        values: &mut [f64],
        most: f64,
    ) -> f64 {
        let is_reached = self.reaching(row).next().is_some();
        if !is_reached && most == 0.0 {
            return 0.0;
        }
        let (sums, _) = sums.cleared(1, values.len(), &(0..values.len()));
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || self.rift_on(simd, seconds, row, sums, values)))
    }

    #[inline(always)]
    fn rift_on<S: Simd>(&self, simd: S, seconds: f64, row: usize, sums: &mut [f64], values: &mut [f64]) -> f64 {
        let rift = self.sea.behavior.rift;
        let zero = f64x8::splat(simd, 0.0);
        for (active, dz, columns) in self.reaching(row) {
            for at in columns.step_by(LANES) {
                let distance = hypot(simd, offset(simd, self.sea, active, at), f64x8::splat(simd, dz));
                let inside = (distance * -1.0 + rift.distance).max(zero);
                match rift.combine {
                    Combine::Sum => add(simd, &mut sums[at..], inside),
                    Combine::Nearest => store(load(simd, &sums[at..]).max(inside), &mut sums[at..]),
                }
            }
        }
        let [left, added] = decayed(rift.decay, seconds);
        let mut most = zero;
        for at in (0..values.len()).step_by(LANES) {
            let near = load(simd, &sums[at..values.len()]);
            let value = load(simd, &values[at..]) * left + near * rift.gain * added;
            most = most.max(value.abs());
            store(value, &mut values[at..]);
        }
        most.reduce_max()
    }

    /// Lets an interval, in seconds, pass for the fields of drift lines of a row, one after another, whose largest value
    /// is given. Returns the largest.
    pub(super) fn drift(
        &self,
        level: Level,
        seconds: f64,
        row: usize,
        sums: &mut Sums,
        values: &mut [f64],
        most: f64,
    ) -> f64 {
        let reached = self.reached(row);
        if reached.is_empty() && most == 0.0 {
            return 0.0;
        }
        let (sums, length) = sums.cleared(DRIFTS, self.sea.basin.columns, &reached);
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || {
                self.draw(simd, row, sums, length);
                self.drift_on(simd, seconds, sums, length, &reached, values)
            }
        ))
    }

    /// Adds the coordinates of drift lines in a row, in fields of a length.
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, row: usize, sums: &mut [f64], length: usize) {
        let (drift, spacing) = (self.sea.behavior.drift, self.sea.basin.spacing);
        let (frequency, softness) = (drift.frequency(), drift.softness(spacing));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        for (active, dz, columns) in self.reaching(row) {
            let (radii, _) = active.burst.profile(self.sea.behavior.shape);
            let radii = [radii[0] * drift.reach[0], radii[1] * drift.reach[1]];
            for at in columns.step_by(LANES) {
                let [a, l] = local(simd, self.sea, active, at, dz, active.heading);
                let q = hypot(simd, a / radii[0], l / radii[1]);
                let inside = (one - q * q).max(zero);
                let weight = inside * active.left * inside;
                let swept = (l * l + softness).sqrt() * drift.lag;
                let angle = |meters: f64x8<S>, turns: f64| (meters * frequency + turns) * (2.0 * PI);
                let [along_sin, along_cos] = sincos(simd, angle(a - swept, active.turns));
                let [across_sin, across_cos] = sincos(simd, angle(l + active.burst.lane, 0.0));
                let values = [one, along_cos, along_sin, across_cos, across_sin];
                for (field, value) in values.into_iter().enumerate() {
                    add(simd, &mut sums[field * length + at..], weight * value);
                }
            }
        }
    }

    /// Lets an interval, in seconds, pass under sums in fields of a length, which are 0 beyond the columns reached.
    #[inline(always)]
    fn drift_on<S: Simd>(
        &self,
        simd: S,
        seconds: f64,
        sums: &[f64],
        length: usize,
        reached: &Range<usize>,
        values: &mut [f64],
    ) -> f64 {
        let (drift, columns) = (self.sea.behavior.drift, self.sea.basin.columns);
        let [left, added] = decayed(drift.decay, seconds);
        let renewal = drift.renewal * seconds * LITERAL_HZ;
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let mut most = zero;
        for at in (0..columns).step_by(LANES) {
            let weight = if reached.contains(&at) { load(simd, &sums[at..columns]) } else { zero };
            let is_new = weight.simd_ne(zero).any_true();
            let renewed = weight * renewal + one;
            for field in 0..DRIFTS {
                let values = &mut values[field * columns + at..(field + 1) * columns];
                let mut value = load(simd, values) * left;
                // Without weight, the sums are 0 and the divisor is 1.
                if is_new {
                    let sum = load(simd, &sums[field * length..][at..columns]);
                    value = (value + sum * added) / renewed;
                }
                most = most.max(value.abs());
                store(value, values);
            }
        }
        most.reduce_max()
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

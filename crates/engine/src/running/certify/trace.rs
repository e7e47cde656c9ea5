//! Runs a program with bounds on the errors of everything that it computes: operation by operation, over chunks.

use crate::planning::bounds::BOUNDS;
use crate::rules::error::{self, Fields, Known, Sum};
use fearless_simd::Level;
use std::collections::HashMap;
use trochoid_graph::{Bound, Op, Slot, Type};
use trochoid_kernel::{CHUNK, CompiledProgram, Origin, Plane, TakeRow};
use trochoid_memory::{Kernel, Stream, dispatch};
use trochoid_weights::arithmetic as a;

/// A program and its rows, for one thread.
#[derive(Debug)]
pub(crate) struct Trace<'p> {
    origin: &'p Origin,
    level: Level,
    /// By operation: index of its first row.
    first: Vec<usize>,
    /// By operation: planes that it loads, by channel.
    loads: Vec<[usize; 3]>,
    rows: Vec<Row>,
    /// Weights of one sample, before and after they are made to sum to 1.
    weights: [Vec<f32>; 2],
}

/// Values and encoded bounds over a chunk.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Row {
    values: [f32; CHUNK],
    bounds: [f32; CHUNK],
}

impl Row {
    const ZERO: Self = Self { values: [0.0; CHUNK], bounds: [0.0; CHUNK] };

    #[inline(always)]
    fn known(&self, x: usize) -> Known {
        Known { value: f64::from(self.values[x]), bound: Bound::decode(self.bounds[x]) }
    }

    /// Computes every value and bound from those of another row.
    #[inline(always)]
    fn map(&mut self, t: &Self, value: impl Fn(f32) -> f32, bound: impl Fn(Known, f64) -> Bound) {
        for x in 0..CHUNK {
            let computed = value(t.values[x]);
            self.values[x] = computed;
            self.bounds[x] = bound(t.known(x), f64::from(computed)).encode();
        }
    }
}

/// Returns the number of rows that an operation makes.
fn rows(op: &Op) -> usize {
    match op.ty() {
        Type::Scalar => 1,
        Type::Color => 3,
        Type::Partition(n) => n,
    }
}

impl<'p> Trace<'p> {
    /// Takes planes in the order of `compiled`, whose second half holds the bounds of the first half.
    pub(crate) fn new(compiled: &'p CompiledProgram) -> Self {
        let origin = &compiled.origin;
        let planes = &compiled.planes[..compiled.planes.len() / 2];
        let planes: HashMap<Slot, usize> = planes.iter().enumerate().map(|(index, slot)| (*slot, index)).collect();
        let (mut first, mut loads, mut all, mut most) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for (op, _) in origin.program.ops() {
            first.push(all.len());
            let of = |slot: &Slot, channel: usize| planes[&Slot { channel, ..*slot }];
            loads.push(match op {
                Op::Load(slot) => [of(slot, slot.channel); 3],
                Op::LoadColor(slot) => [0, 1, 2].map(|c| of(slot, slot.channel + c)),
                _ => [0; 3],
            });
            let constant = |value: &f32| {
                let bound = error::constant(*value).encode();
                Row { values: [*value; CHUNK], bounds: [bound; CHUNK] }
            };
            match op {
                Op::Constant(value) => all.push(constant(value)),
                Op::ConstantColor(color) => all.extend(color.iter().map(constant)),
                _ => all.resize(all.len() + rows(op), Row::ZERO),
            }
            most = most.max(rows(op));
        }
        let weights = [vec![0.0; most], vec![0.0; most]];
        Self { origin, level: compiled.instructions.level(), first, loads, rows: all, weights }
    }

    /// Hands over the rows of every root as (root, channel, y, samples): those of its values, and those of its bounds
    /// [`BOUNDS`] channels behind.
    pub(crate) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, take: TakeRow<'_>) {
        dispatch(self.level, TracedTile { trace: self, planes, width, height, take });
    }
}

/// A tile of a program.
struct TracedTile<'t, 'p, 'a> {
    trace: &'t mut Trace<'p>,
    planes: &'t [Plane<'a>],
    width: usize,
    height: usize,
    take: TakeRow<'t>,
}

impl Kernel for TracedTile<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Stream>(self, _simd: S) {
        let Self { trace, planes, width, height, take } = self;
        for y in 0..height {
            for x in (0..width).step_by(CHUNK) {
                let count = CHUNK.min(width - x);
                for position in 0..trace.first.len() {
                    trace.operation(position, planes, [x, y], count);
                }
                let ops = trace.origin.program.ops();
                for (index, &root) in trace.origin.roots.iter().enumerate() {
                    let own = &trace.rows[trace.first[root as usize]..];
                    for (channel, row) in own[..rows(&ops[root as usize].0)].iter().enumerate() {
                        take(index, channel, y, &row.values[..count]);
                        take(index, BOUNDS + channel, y, &row.bounds[..count]);
                    }
                }
            }
        }
    }
}

impl Trace<'_> {
    /// Computes the rows of an operation from column `x` of row `y` on. Samples from `count` on may be anything.
    ///
    /// Values follow the f32 definitions, which all kernels match.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "loops over several arrays")]
    fn operation(&mut self, position: usize, planes: &[Plane<'_>], [x, y]: [usize; 2], count: usize) {
        let op = &self.origin.program.ops()[position].0;
        let (before, own) = self.rows.split_at_mut(self.first[position]);
        let first = &self.first;
        let row = |position: u32, channel: usize| &before[first[position as usize] + channel];
        match op {
            Op::Load(_) | Op::LoadColor(_) => {
                let bounds = planes.len() / 2;
                let copy = |to: &mut [f32; CHUNK], plane: &Plane<'_>| {
                    to[..count].copy_from_slice(&plane.samples[plane.start + y * plane.stride + x..][..count]);
                };
                for (own, plane) in own.iter_mut().zip(self.loads[position]).take(rows(op)) {
                    copy(&mut own.values, &planes[plane]);
                    copy(&mut own.bounds, &planes[bounds + plane]);
                }
            }
            // Filled once for all.
            Op::Constant(_) | Op::ConstantColor(_) => {}
            Op::Clamp { x, min, max } => {
                let (min, max) = (*min, *max);
                own[0].map(row(x.0, 0), |x| a::clamp(x, min, max), |x, y| error::clamp(x, min, max, y));
            }
            Op::Step { x, threshold } => {
                let at = *threshold;
                own[0].map(row(x.0, 0), |x| a::step(x, at), |x, y| error::clamp(x, at, at, y));
            }
            Op::Smooth(t) => own[0].map(row(t.0, 0), a::smooth, error::smooth),
            Op::Power { t, p } => {
                let p = *p;
                own[0].map(row(t.0, 0), |t| a::power(t, p), |t, y| error::power(t, p, y));
            }
            Op::Complement(t) => own[0].map(row(t.0, 0), a::complement, error::complement),
            Op::Product(t, u) => {
                let (t, u, own) = (row(t.0, 0), row(u.0, 0), &mut own[0]);
                for x in 0..CHUNK {
                    let computed = a::product(t.values[x], u.values[x]);
                    own.values[x] = computed;
                    own.bounds[x] = error::product(t.known(x), u.known(x), f64::from(computed)).encode();
                }
            }
            Op::Partition(weights) => {
                let sample = &mut self.weights[0][..weights.len()];
                for x in 0..count {
                    sample.iter_mut().zip(weights).for_each(|(to, weight)| *to = row(weight.0, 0).values[x]);
                    a::round_partition(sample);
                    sample.iter().zip(&mut *own).for_each(|(weight, own)| own.values[x] = *weight);
                }
                for (weight, own) in weights.iter().zip(own) {
                    let weight = row(weight.0, 0);
                    for x in 0..CHUNK {
                        own.bounds[x] = error::part(weight.known(x), f64::from(own.values[x])).encode();
                    }
                }
            }
            Op::Normalize { values, floor } => {
                let [fields, shares] = &mut self.weights;
                let (fields, shares) = (&mut fields[..values.len()], &mut shares[..values.len() + 1]);
                for x in 0..count {
                    fields.iter_mut().zip(values).for_each(|(to, value)| *to = row(value.0, 0).values[x]);
                    a::normalize(fields, *floor, shares);
                    shares.iter().zip(&mut *own).for_each(|(share, own)| own.values[x] = *share);
                    let mut all = Fields::default();
                    values.iter().for_each(|value| all.add(row(value.0, 0).known(x)));
                    let all = all.shares(*floor);
                    let (rest, own) = match own[..=values.len()].split_last_mut() {
                        Some(found) => found,
                        None => unreachable!("there is a weight for the remainder"),
                    };
                    for (own, value) in own.iter_mut().zip(values) {
                        own.bounds[x] = all.of(row(value.0, 0).known(x), f64::from(own.values[x])).encode();
                    }
                    rest.bounds[x] = all.rest(f64::from(rest.values[x])).encode();
                }
            }
            Op::Weight(partition, i) => own[0].clone_from(row(partition.0, *i)),
            Op::Mix { a, b, t } => {
                let t = row(t.0, 0);
                for (channel, own) in own[..3].iter_mut().enumerate() {
                    let (a, b) = (row(a.0, channel), row(b.0, channel));
                    for x in 0..CHUNK {
                        let computed = a::mix(a.values[x], b.values[x], t.values[x]);
                        own.values[x] = computed;
                        own.bounds[x] = error::mix(a.known(x), b.known(x), t.known(x), f64::from(computed)).encode();
                    }
                }
            }
            Op::Blend { colors, weights } => {
                for (channel, own) in own[..3].iter_mut().enumerate() {
                    let (mut values, mut sums) = ([0.0_f64; CHUNK], Sums::default());
                    for (i, color) in colors.iter().enumerate() {
                        let (weight, color) = (row(weights.0, i), row(color.0, channel));
                        for x in 0..CHUNK {
                            values[x] = a::accumulate(values[x], weight.values[x], color.values[x]);
                            sums.add(x, weight.known(x), color.known(x));
                        }
                    }
                    for x in 0..CHUNK {
                        let computed = values[x] as f32;
                        own.values[x] = computed;
                        own.bounds[x] = sums.at(x).bound(colors.len(), f64::from(computed)).encode();
                    }
                }
            }
        }
    }
}

/// What is known of the terms of a Blend over a chunk, member by member.
struct Sums {
    low: [f64; CHUNK],
    high: [f64; CHUNK],
    size: [f64; CHUNK],
    sum: [f64; CHUNK],
    moved: [f64; CHUNK],
    clear: [bool; CHUNK],
}

impl Default for Sums {
    #[inline(always)]
    fn default() -> Self {
        let Sum { low, high, size, sum, moved, clear } = Sum::default();
        Self {
            low: [low; CHUNK],
            high: [high; CHUNK],
            size: [size; CHUNK],
            sum: [sum; CHUNK],
            moved: [moved; CHUNK],
            clear: [clear; CHUNK],
        }
    }
}

impl Sums {
    #[inline(always)]
    fn at(&self, x: usize) -> Sum {
        Sum {
            low: self.low[x],
            high: self.high[x],
            size: self.size[x],
            sum: self.sum[x],
            moved: self.moved[x],
            clear: self.clear[x],
        }
    }

    #[inline(always)]
    fn add(&mut self, x: usize, weight: Known, color: Known) {
        let mut sum = self.at(x);
        sum.add(weight, color);
        (self.low[x], self.high[x], self.size[x]) = (sum.low, sum.high, sum.size);
        (self.sum[x], self.moved[x], self.clear[x]) = (sum.sum, sum.moved, sum.clear);
    }
}

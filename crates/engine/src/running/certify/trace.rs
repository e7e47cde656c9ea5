//! Runs a program with bounds on the errors of everything that it computes: operation by operation, in rows.

use crate::kernel::{CHUNK, CompiledProgram, Origin, Plane, TakeRow};
use crate::planning::bounds::BOUNDS;
use crate::rules::error::{Operands, error};
use std::collections::HashMap;
use trochoid_graph::{Bound, Op, Scalar, Slot, Type};
use trochoid_weights::arithmetic as a;

/// A program and its rows, for one thread.
#[derive(Debug)]
pub(crate) struct Trace<'p> {
    origin: &'p Origin,
    /// Index of the plane that holds the values of a slot.
    planes: HashMap<Slot, usize>,
    /// Index of each operation's first row.
    first: Vec<usize>,
    rows: TraceRows,
}

/// Values and encoded bounds over a chunk.
#[derive(Debug)]
struct TraceRows {
    values: Vec<[f32; CHUNK]>,
    bounds: Vec<[f32; CHUNK]>,
}

/// Everything that was computed at one sample.
struct SampleOperands<'a> {
    rows: &'a TraceRows,
    first: &'a [usize],
    x: usize,
}

impl Operands for SampleOperands<'_> {
    #[inline]
    fn value(&self, position: u32, row: usize) -> f64 {
        f64::from(self.float(position, row))
    }

    #[inline]
    fn bound(&self, position: u32, row: usize) -> Bound {
        Bound::decode(self.rows.bounds[self.first[position as usize] + row][self.x])
    }
}

impl SampleOperands<'_> {
    #[inline]
    fn float(&self, position: u32, row: usize) -> f32 {
        self.rows.values[self.first[position as usize] + row][self.x]
    }

    /// Computes an operation by its f32 definition, which all kernels match.
    fn compute(&self, op: &Op, out: &mut [f32]) {
        let scalar = |s: Scalar| self.float(s.0, 0);
        match op {
            Op::Load(_) | Op::LoadColor(_) => {}
            Op::Constant(value) => out[0] = *value,
            Op::ConstantColor(color) => out.copy_from_slice(color),
            Op::Clamp { x, min, max } => out[0] = a::clamp(scalar(*x), *min, *max),
            Op::Step { x, threshold } => out[0] = a::step(scalar(*x), *threshold),
            Op::Smooth(t) => out[0] = a::smooth(scalar(*t)),
            Op::Power { t, p } => out[0] = a::power(scalar(*t), *p),
            Op::Complement(t) => out[0] = a::complement(scalar(*t)),
            Op::Product(t, u) => out[0] = a::product(scalar(*t), scalar(*u)),
            Op::Partition(weights) => {
                out.iter_mut().zip(weights).for_each(|(out, weight)| *out = scalar(*weight));
                a::round_partition(out);
            }
            Op::Normalize { values, floor } => {
                let values: Vec<f32> = values.iter().map(|value| scalar(*value)).collect();
                a::normalize(&values, *floor, out);
            }
            Op::Weight(partition, i) => out[0] = self.float(partition.0, *i),
            Op::Mix { a, b, t } => {
                for (row, out) in out.iter_mut().enumerate() {
                    *out = a::mix(self.float(a.0, row), self.float(b.0, row), scalar(*t));
                }
            }
            Op::Blend { colors, weights } => {
                for (row, out) in out.iter_mut().enumerate() {
                    let terms = colors.iter().enumerate();
                    let sum = terms.fold(0.0, |sum, (i, color)| {
                        a::accumulate(sum, self.float(weights.0, i), self.float(color.0, row))
                    });
                    *out = sum as f32;
                }
            }
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
        let mut first = Vec::new();
        let mut count = 0;
        for (op, _) in origin.program.ops() {
            first.push(count);
            count += rows(op);
        }
        let rows = TraceRows { values: vec![[0.0; CHUNK]; count], bounds: vec![[0.0; CHUNK]; count] };
        let planes = &compiled.planes[..compiled.planes.len() / 2];
        let planes = planes.iter().enumerate().map(|(index, slot)| (*slot, index)).collect();
        Self { origin, planes, first, rows }
    }

    /// Hands over the rows of every root as (root, channel, y, samples): those of its values, and those of its bounds
    /// [`BOUNDS`] channels behind.
    pub(crate) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, take: TakeRow<'_>) {
        for y in 0..height {
            for x in (0..width).step_by(CHUNK) {
                let count = CHUNK.min(width - x);
                self.chunk(planes, x, y, count);
                for (index, &root) in self.origin.roots.iter().enumerate() {
                    let own = self.first[root as usize];
                    for channel in 0..rows(&self.origin.program.ops()[root as usize].0) {
                        take(index, channel, y, &self.rows.values[own + channel][..count]);
                        take(index, BOUNDS + channel, y, &self.rows.bounds[own + channel][..count]);
                    }
                }
            }
        }
    }

    fn chunk(&mut self, planes: &[Plane<'_>], x: usize, y: usize, count: usize) {
        for (position, (op, _)) in self.origin.program.ops().iter().enumerate() {
            let (own, channels) = (self.first[position], rows(op));
            if let Op::Load(slot) | Op::LoadColor(slot) = op {
                for channel in 0..channels {
                    let slot = if channels == 3 { Slot { channel, ..*slot } } else { *slot };
                    let plane = self.planes[&slot];
                    let row = |plane: &Plane<'_>| plane.start + y * plane.stride + x;
                    let (values, bounds) = (&planes[plane], &planes[planes.len() / 2 + plane]);
                    self.rows.values[own + channel][..count].copy_from_slice(&values.samples[row(values)..][..count]);
                    self.rows.bounds[own + channel][..count].copy_from_slice(&bounds.samples[row(bounds)..][..count]);
                }
                continue;
            }
            let mut computed = vec![0.0_f32; channels];
            let mut exact = vec![0.0_f64; channels];
            let mut bounds = vec![Bound::EXACT; channels];
            for x in 0..count {
                let at = SampleOperands { rows: &self.rows, first: &self.first, x };
                at.compute(op, &mut computed);
                exact.iter_mut().zip(&computed).for_each(|(to, from)| *to = f64::from(*from));
                error(op, &at, &exact, &mut bounds);
                for channel in 0..channels {
                    self.rows.values[own + channel][x] = computed[channel];
                    self.rows.bounds[own + channel][x] = bounds[channel].encode();
                }
            }
        }
    }
}

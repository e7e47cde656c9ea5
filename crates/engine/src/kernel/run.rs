//! Runs compiled programs.

use super::compile::{Compiled, Instruction, Row, Work};
use fearless_simd::{Level, Simd, dispatch};
use trochoid_graph::Variance;
use trochoid_weights::arithmetic as a;

/// A plane over a tile, wherever its rows lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane<'a> {
    pub(crate) samples: &'a [f32],
    /// The tile's first sample.
    pub(crate) start: usize,
    /// From one row to the next; 0 where one row stands for all.
    pub(crate) stride: usize,
}

impl<'a> Plane<'a> {
    /// The first `width` samples of row y.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, width: usize) -> &'a [f32] {
        let start = self.start + y * self.stride;
        &self.samples[start..start + width]
    }
}

/// The extremes of weights seen while running, for the audit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WeightAudit {
    pub(crate) min: f32,
    pub(crate) max_deviation: f64,
}

impl Default for WeightAudit {
    fn default() -> Self {
        Self { min: f32::INFINITY, max_deviation: 0.0 }
    }
}

impl WeightAudit {
    pub(crate) fn merge(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max_deviation: self.max_deviation.max(other.max_deviation) }
    }
}

/// Receives rows as (root or output, channel, y within the tile, samples).
pub(crate) type Sink<'s> = &'s mut dyn FnMut(usize, usize, usize, &[f32]);

/// Rows and instructions of one thread.
#[derive(Debug)]
pub(crate) struct Machine<'p> {
    compiled: &'p Compiled,
    level: Level,
    rows: Vec<Vec<f32>>,
    audit: WeightAudit,
}

impl<'p> Machine<'p> {
    pub(crate) fn new(compiled: &'p Compiled) -> Self {
        Self { compiled, level: Level::new(), rows: vec![Vec::new(); compiled.rows], audit: WeightAudit::default() }
    }

    pub(crate) fn audit(&self) -> WeightAudit {
        self.audit
    }

    /// Runs the program over a tile of `width` × `height` pixels and hands every row of every root to `sink`
    /// as (root, channel, y, samples).
    pub(crate) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, sink: Sink<'_>) {
        for row in &mut self.rows {
            row.resize(width, 0.0);
        }
        let compiled = self.compiled;
        let level = self.level;
        dispatch!(level, simd => execute(simd, &compiled.once, self, planes, 0, width));
        for y in 0..height {
            dispatch!(level, simd => execute(simd, &compiled.each, self, planes, y, width));
            for (root, rows) in compiled.roots.iter().enumerate() {
                for (channel, row) in rows.iter().enumerate() {
                    sink(root, channel, y, self.row(*row, planes, y, width));
                }
            }
        }
    }

    #[inline(always)]
    fn row<'r>(&'r self, row: Row, planes: &'r [Plane<'r>], y: usize, width: usize) -> &'r [f32] {
        match row {
            Row::Own(index) => &self.rows[index as usize][..width],
            Row::Plane(index) => planes[index as usize].row(y, width),
        }
    }
}

/// Runs instructions over one row, compiled for each instruction set.
#[inline(always)]
fn execute<S: Simd>(
    simd: S,
    list: &[Instruction],
    machine: &mut Machine<'_>,
    planes: &[Plane<'_>],
    y: usize,
    width: usize,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for instruction in list {
                // What does not vary along the row is computed for one pixel and spread.
                let constant_row = matches!(instruction.variance, Variance::Constant | Variance::Row);
                let length = if constant_row { 1.min(width) } else { width };
                step(instruction, machine, planes, y, width, length);
                #[cfg(test)]
                sabotage(instruction, machine);
                if constant_row {
                    for &to in &instruction.to {
                        let row = &mut machine.rows[to as usize];
                        let value = row[0];
                        row.fill(value);
                    }
                }
            }
        },
    );
}

/// Runs one instruction over the first `n` pixels of a row.
#[inline(always)]
fn step(instruction: &Instruction, machine: &mut Machine<'_>, planes: &[Plane<'_>], y: usize, width: usize, n: usize) {
    // The rows written are taken out, so that the rest can be read; no instruction reads what it writes.
    let mut first = std::mem::take(&mut machine.rows[instruction.to[0] as usize]);
    {
        let to = &mut first[..n];
        let get = |row: Row| &machine.row(row, planes, y, width)[..n];
        match &instruction.work {
            Work::Constant(value) => to.fill(*value),
            Work::Clamp { x, min, max } => unary(to, get(*x), |x| a::clamp(x, *min, *max)),
            Work::Smooth(t) => unary(to, get(*t), a::smooth),
            Work::Power { t, p } => {
                to.copy_from_slice(get(*t));
                a::power_row(to, *p);
            }
            Work::Step { x, threshold } => unary(to, get(*x), |x| a::step(x, *threshold)),
            Work::Complement(t) => unary(to, get(*t), a::complement),
            Work::Product(t, u) => {
                for ((to, t), u) in to.iter_mut().zip(get(*t)).zip(get(*u)) {
                    *to = a::product(*t, *u);
                }
            }
            Work::ConstantColor(_)
            | Work::Mix { .. }
            | Work::Blend { .. }
            | Work::Partition(_)
            | Work::Normalize { .. } => {}
        }
    }
    machine.rows[instruction.to[0] as usize] = first;
    match &instruction.work {
        Work::ConstantColor(color) => {
            for (&to, value) in instruction.to.iter().zip(color) {
                machine.rows[to as usize][..n].fill(*value);
            }
        }
        Work::Mix { a, b, t } => {
            let audit = audit_mask(&machine.row(*t, planes, y, width)[..n]);
            machine.audit = machine.audit.merge(audit);
            for c in 0..3 {
                let to = instruction.to[c] as usize;
                let mut out = std::mem::take(&mut machine.rows[to]);
                mix(
                    &mut out[..n],
                    &machine.row(a[c], planes, y, width)[..n],
                    &machine.row(b[c], planes, y, width)[..n],
                    &machine.row(*t, planes, y, width)[..n],
                );
                machine.rows[to] = out;
            }
        }
        Work::Blend { colors, weights } => {
            let mut deviation = 0.0f64;
            let mut min = f32::INFINITY;
            for x in 0..n {
                let mut sum = 0.0f64;
                for weight in weights {
                    let weight = machine.row(*weight, planes, y, width)[x];
                    sum += f64::from(weight);
                    min = min.min(weight);
                }
                // NaN must count: max would drop it.
                let off = (sum - 1.0).abs();
                deviation = if off <= deviation { deviation } else { off };
            }
            machine.audit = machine.audit.merge(WeightAudit { min, max_deviation: deviation });
            for c in 0..3 {
                let to = instruction.to[c] as usize;
                let mut out = std::mem::take(&mut machine.rows[to]);
                let mut sums = [0.0f64; CHUNK];
                let mut start = 0;
                while start < n {
                    let end = (start + CHUNK).min(n);
                    let sums = &mut sums[..end - start];
                    sums.fill(0.0);
                    for (color, weight) in colors.iter().zip(weights) {
                        let color = &machine.row(color[c], planes, y, width)[start..end];
                        let weight = &machine.row(*weight, planes, y, width)[start..end];
                        for ((sum, color), weight) in sums.iter_mut().zip(color).zip(weight) {
                            *sum = a::accumulate(*sum, *weight, *color);
                        }
                    }
                    for (to, sum) in out[start..end].iter_mut().zip(sums) {
                        *to = *sum as f32;
                    }
                    start = end;
                }
                machine.rows[to] = out;
            }
        }
        Work::Partition(weights) => {
            let mut out: Vec<Vec<f32>> =
                instruction.to.iter().map(|&to| std::mem::take(&mut machine.rows[to as usize])).collect();
            for (out, weight) in out.iter_mut().zip(weights) {
                out[..n].copy_from_slice(&machine.row(*weight, planes, y, width)[..n]);
            }
            let mut slices: Vec<&mut [f32]> = out.iter_mut().map(|row| &mut row[..n]).collect();
            a::round_partition_rows(&mut slices);
            for (&to, row) in instruction.to.iter().zip(out) {
                machine.rows[to as usize] = row;
            }
        }
        Work::Normalize { values, floor } => {
            let mut out: Vec<Vec<f32>> =
                instruction.to.iter().map(|&to| std::mem::take(&mut machine.rows[to as usize])).collect();
            {
                let values: Vec<&[f32]> = values.iter().map(|row| &machine.row(*row, planes, y, width)[..n]).collect();
                let mut slices: Vec<&mut [f32]> = out.iter_mut().map(|row| &mut row[..n]).collect();
                a::normalize_rows(&values, *floor, &mut slices);
            }
            for (&to, row) in instruction.to.iter().zip(out) {
                machine.rows[to as usize] = row;
            }
        }
        _ => {}
    }
}

/// Spoils what an instruction wrote, as the program's fault says.
#[cfg(test)]
fn sabotage(instruction: &Instruction, machine: &mut Machine<'_>) {
    use super::compile::Fault;
    let first = &mut machine.rows[instruction.to[0] as usize];
    match (machine.compiled.fault, &instruction.work) {
        (Fault::MixOvershoots, Work::Mix { .. }) => first.iter_mut().for_each(|v| *v = *v * 1.5 + 0.01),
        (Fault::PartitionLeaks, Work::Normalize { .. }) => first.iter_mut().for_each(|v| *v *= 0.9),
        (Fault::ClampLeaks, Work::Clamp { .. }) => first.iter_mut().for_each(|v| *v += 0.25),
        (Fault::MixLosesOne, Work::Mix { .. }) => first.iter_mut().rev().take(1).for_each(|v| *v = f32::NAN),
        _ => {}
    }
}

/// Pixels whose f64 sums are held at once.
const CHUNK: usize = 64;

#[inline(always)]
fn unary(to: &mut [f32], from: &[f32], f: impl Fn(f32) -> f32) {
    for (to, x) in to.iter_mut().zip(from) {
        *to = f(*x);
    }
}

#[inline(always)]
fn mix(to: &mut [f32], from: &[f32], other: &[f32], t: &[f32]) {
    for (((to, from), other), t) in to.iter_mut().zip(from).zip(other).zip(t) {
        *to = a::mix(*from, *other, *t);
    }
}

/// The lesser of t and 1 − t over a row; NaN becomes −∞, so that it cannot hide.
#[inline(always)]
fn audit_mask(t: &[f32]) -> WeightAudit {
    let mut min = f32::INFINITY;
    for &t in t {
        let least = if t <= 0.5 { t } else { 1.0 - t };
        min = if least >= min { min } else { least };
    }
    WeightAudit { min: if min.is_nan() { f32::NEG_INFINITY } else { min }, max_deviation: 0.0 }
}

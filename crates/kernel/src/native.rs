//! Runs code as machine code: each instruction is translated once, so that no dispatch is needed over rows.

use crate::audit::{BitRange, ValueRule};
use crate::code::{Chunk, Code, ColorOperand, Instruction, Row};
use crate::run::{CodeFrame, KernelInputs, Look, RowEnd, filled};
use crate::sweep::is_simple;
use fearless_simd::Level;
use std::sync::{Arc, OnceLock};
use trochoid_jit::{Lanes, Op, Program, Run, STEP, Set, Stores, Value};
use trochoid_memory::{Scratch, Target};

/// Number of samples of a row shown to the look callback at a time: they stay in L1.
const BLOCK: usize = 512;

/// Indices of the state vectors that come before those of the roots. From [`WEIGHTS`] on, all are audits.
const FIELDS: usize = 0;
const MASKS: usize = 1;
const COLORS: usize = 3;
const WEIGHTS: usize = 4;
const SUMS: usize = 6;
const ROOTS: usize = 8;

/// A translated program. The machine code is compiled when first needed.
#[derive(Clone, Debug)]
pub(crate) struct Native {
    program: Program,
    set: Set,
    columns: usize,
    cached: OnceLock<Option<Arc<trochoid_jit::Code>>>,
    around: OnceLock<Option<Arc<trochoid_jit::Code>>>,
}

/// Scratch space that a machine needs to run it.
#[derive(Debug, Default)]
pub(crate) struct NativeMemory {
    state: Vec<Lanes>,
    memory: trochoid_jit::Scratch,
    /// Padded to whole steps.
    end: RowEnd,
    /// Results that are shown before they go to their destination.
    block: Vec<Vec<f32>>,
}

impl Native {
    /// Translates code that reads the given numbers of planes, columns and lines; `None` if the processor or one of
    /// the instructions has no machine code.
    pub(crate) fn new(code: &Code, planes: usize, columns: usize, lines: usize, level: Level) -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        let set = match level {
            Level::Avx512(_) => Set::Avx512,
            Level::Avx2(_) => Set::Avx2,
            _ => return None,
        };
        #[cfg(not(target_arch = "x86_64"))]
        let set = {
            let _ = level;
            return None;
        };
        let program = Translation::new(code, planes, columns, lines).whole()?;
        Some(Self { program, set, columns, cached: OnceLock::new(), around: OnceLock::new() })
    }

    fn code(&self, stores: Stores) -> Option<&trochoid_jit::Code> {
        let code = match stores {
            Stores::Cached => &self.cached,
            Stores::Around => &self.around,
        };
        code.get_or_init(|| trochoid_jit::Code::compile(&self.program, self.set, stores).map(Arc::new)).as_deref()
    }

    /// Runs over the first `width` pixels of a row, like `sweep`. Returns false if there is no machine code after
    /// all.
    #[allow(clippy::too_many_arguments, reason = "the machine's parts, borrowed one by one")]
    pub(crate) fn row(
        &self,
        frame: &mut CodeFrame<'_>,
        inputs: KernelInputs<'_>,
        width: usize,
        out: &mut [Target<'_>],
        start: usize,
        look: Option<Look<'_>>,
        scratch: &mut NativeMemory,
    ) -> bool {
        let whole = width / STEP * STEP;
        let around = look.is_none() && whole > 0 && out.iter().all(|target| target.is_lines(start, whole));
        let stores = if around { Stores::Around } else { Stores::Cached };
        let (Some(code), Some(cached)) = (self.code(stores), self.code(Stores::Cached)) else { return false };
        load_bits(frame, &mut scratch.state, self.program.state());
        let lines: Scratch<&[f32]> = inputs.lines.iter().map(|chunk| &chunk.0[..1]).collect();
        let rows = |from: usize, to: usize| -> Scratch<&[f32]> {
            let planes = inputs.planes.iter().map(|row| {
                let at = row.at.wrapping_add(from);
                &row.plane.samples[at..at + (to - from)]
            });
            planes.chain(inputs.columns[..self.columns].iter().map(|column| &column[from..to])).collect()
        };
        let (state, memory) = (&mut scratch.state, &mut scratch.memory);
        match look {
            None => {
                let run = Run { inputs: &rows(0, whole), lines: &lines, start, count: whole };
                code.run(&run, out, state, memory);
                if whole < width && whole > 0 && !around {
                    // The last samples with some before them, whose results are the same again: nothing is copied.
                    let run = Run {
                        inputs: &rows(width - STEP, width),
                        lines: &lines,
                        start: start + width - STEP,
                        count: STEP,
                    };
                    cached.run(&run, out, state, memory);
                } else if whole < width {
                    self.tail(cached, inputs, &lines, whole..width, state, memory, &mut scratch.end);
                    for (out, rest) in out.iter_mut().zip(&scratch.end.results) {
                        out.copy(start + whole, &rest.0[..width - whole]);
                    }
                }
            }
            Some(look) => {
                scratch.block.resize_with(out.len(), || vec![0.0; BLOCK]);
                for from in (0..whole).step_by(BLOCK) {
                    let count = BLOCK.min(whole - from);
                    let mut targets: Scratch<Target<'_>> =
                        scratch.block.iter_mut().map(|row| Target::new(row)).collect();
                    let run = Run { inputs: &rows(from, from + count), lines: &lines, start: 0, count };
                    cached.run(&run, &mut targets, state, memory);
                    drop(targets);
                    show(frame.code, look, |channel| &scratch.block[channel][..count]);
                    for (out, block) in out.iter_mut().zip(&scratch.block) {
                        out.copy(start + from, &block[..count]);
                    }
                }
                if whole < width {
                    self.tail(cached, inputs, &lines, whole..width, state, memory, &mut scratch.end);
                    show(frame.code, look, |channel| &scratch.end.results[channel].0[..width - whole]);
                    for (out, rest) in out.iter_mut().zip(&scratch.end.results) {
                        out.copy(start + whole, &rest.0[..width - whole]);
                    }
                }
            }
        }
        store_bits(frame, &mut scratch.state);
        true
    }

    /// Makes the code that writes through the cache; returns the number of samples that it processes at a time, if there
    /// is some.
    pub(crate) fn make_ready(&self) -> Option<usize> {
        self.code(Stores::Cached).map(trochoid_jit::Code::step)
    }

    /// Runs over `count` samples of rows, a whole number of the code's steps. Returns false if there is no machine code
    /// after all.
    pub(crate) fn samples(
        &self,
        frame: &mut CodeFrame<'_>,
        inputs: &[&[f32]],
        count: usize,
        outputs: &mut [Target<'_>],
        scratch: &mut NativeMemory,
    ) -> bool {
        let Some(code) = self.code(Stores::Cached) else { return false };
        load_bits(frame, &mut scratch.state, self.program.state());
        code.run(&Run { inputs, lines: &[], start: 0, count }, outputs, &mut scratch.state, &mut scratch.memory);
        store_bits(frame, &mut scratch.state);
        true
    }

    /// Runs over the end of a row, padded with its last sample, so that the padding adds nothing new to any audit.
    #[allow(clippy::too_many_arguments, reason = "the machine's parts, borrowed one by one")]
    fn tail(
        &self,
        code: &trochoid_jit::Code,
        inputs: KernelInputs<'_>,
        lines: &[&[f32]],
        range: std::ops::Range<usize>,
        state: &mut [Lanes],
        memory: &mut trochoid_jit::Scratch,
        end: &mut RowEnd,
    ) {
        end.padded.clear();
        end.padded.extend(inputs.planes.iter().map(|row| {
            let at = row.at.wrapping_add(range.start);
            filled(&row.plane.samples[at..at + range.len()])
        }));
        let columns = inputs.columns[..self.columns].iter().map(|column| &column[range.start..range.start + STEP]);
        let rows: Scratch<&[f32]> = end.padded.iter().map(|chunk| &chunk.0[..STEP]).chain(columns).collect();
        end.results.resize(self.program.outputs(), Chunk::ZERO);
        let mut targets: Scratch<Target<'_>> = end.results.iter_mut().map(|chunk| Target::new(&mut chunk.0)).collect();
        code.run(&Run { inputs: &rows, lines, start: 0, count: STEP }, &mut targets, state, memory);
    }
}

/// Shows every color root to the look callback.
fn show<'r>(code: &Code, look: Look<'_>, row: impl Fn(usize) -> &'r [f32]) {
    for (root, &(first, _)) in code.roots.iter().enumerate().filter(|(root, _)| code.is_color(*root)) {
        look(root, [row(first), row(first + 1), row(first + 2)]);
    }
}

/// Returns the first check of a rule. Checks are only ever evaluated together, so the first one records for all of
/// them.
fn check(code: &Code, rule: ValueRule) -> Option<usize> {
    code.checks.iter().position(|(_, kind)| *kind == rule)
}

/// Calls `f` with the first state vector of every record, whether a least value precedes the largest, and the bits to
/// which it belongs.
fn each(frame: &mut CodeFrame<'_>, mut f: impl FnMut(usize, bool, &mut BitRange)) {
    let code = frame.code;
    for (rule, state) in [(ValueRule::Field, FIELDS), (ValueRule::Mask, MASKS), (ValueRule::Color, COLORS)] {
        if let Some(index) = check(code, rule) {
            f(state, rule == ValueRule::Mask, &mut frame.checks[index]);
        }
    }
    if !code.audits {
        return;
    }
    f(WEIGHTS, true, &mut frame.weights);
    let mut state = ROOTS;
    for root in 0..code.roots.len() {
        if code.is_color(root) {
            for bits in &mut frame.colors[root] {
                f(state, true, bits);
                state += 2;
            }
        } else {
            f(state, false, &mut frame.scalars[root]);
            state += 1;
        }
    }
}

/// Loads what was recorded before.
fn load_bits(frame: &mut CodeFrame<'_>, state: &mut Vec<Lanes>, count: usize) {
    state.clear();
    state.resize(count, Lanes([0; 16]));
    each(frame, |at, has_least, bits| {
        if has_least {
            state[at].0 = bits.least;
            state[at + 1].0 = bits.largest;
        } else {
            state[at].0 = bits.largest;
        }
    });
}

/// Stores what was recorded.
fn store_bits(frame: &mut CodeFrame<'_>, state: &mut [Lanes]) {
    each(frame, |at, has_least, bits| {
        if has_least {
            bits.least = state[at].0;
            bits.largest = state[at + 1].0;
        } else {
            bits.largest = state[at].0;
        }
    });
    if !frame.code.audits {
        return;
    }
    for lanes in &state[SUMS..SUMS + 2] {
        for pair in lanes.0.as_chunks::<2>().0 {
            let deviation = f64::from_bits(u64::from(pair[0]) | u64::from(pair[1]) << 32);
            frame.partitions.max_deviation = frame.partitions.max_deviation.max(deviation);
        }
    }
}

/// Translates instructions over chunks to a program over samples.
struct Translation<'c> {
    code: &'c Code,
    program: Program,
    planes: Vec<Value>,
    columns: Vec<Value>,
    lines: Vec<Value>,
    own: Vec<Option<Value>>,
    last: Option<[Value; 3]>,
    /// Open gates: the instruction after the gate, and the color if it is closed.
    gates: Vec<(usize, [Value; 3])>,
    /// First state vector, by root.
    states: Vec<u32>,
}

impl<'c> Translation<'c> {
    fn new(code: &'c Code, planes: usize, columns: usize, lines: usize) -> Self {
        let mut states = Vec::with_capacity(code.roots.len());
        let mut state = ROOTS;
        for root in 0..code.roots.len() {
            states.push(state as u32);
            state += if code.is_color(root) { 6 } else { 1 };
        }
        let state = if code.audits { state } else { WEIGHTS };
        let mut program = Program::new(planes + columns, lines, code.channels(), state);
        let mut inputs: Vec<Value> = (0..planes + columns).map(|i| program.compute(Op::Input(i as u32))).collect();
        let columns = inputs.split_off(planes);
        let lines = (0..lines).map(|line| program.compute(Op::Line(line as u32))).collect();
        let mut own = vec![None; code.own];
        for &(row, value) in &code.constants {
            own[row as usize] = Some(program.compute(Op::Constant(value)));
        }
        Self { code, program, planes: inputs, columns, lines, own, last: None, gates: Vec::new(), states }
    }

    fn whole(mut self) -> Option<Program> {
        let code = self.code;
        for (at, instruction) in code.list.iter().enumerate() {
            self.instruction(at, instruction)?;
            while let Some(&(_, otherwise)) = self.gates.last().filter(|(end, _)| *end == at + 1) {
                self.gates.pop();
                let inside = self.last?;
                self.last = Some(self.program.join(inside, otherwise));
            }
        }
        self.gates.is_empty().then_some(self.program)
    }

    fn row(&self, row: Row) -> Option<Value> {
        match row {
            Row::Own(row) => self.own[row as usize],
            Row::Plane(plane) => self.planes.get(plane as usize).copied(),
            Row::Column(row) => self.columns.get(row as usize).copied(),
            Row::Line(row) => self.lines.get(row as usize).copied(),
        }
    }

    fn rows(&self, rows: &[Row]) -> Option<Vec<Value>> {
        rows.iter().map(|row| self.row(*row)).collect()
    }

    fn constant(&mut self, color: &[f32; 3]) -> [Value; 3] {
        color.map(|channel| self.program.compute(Op::Constant(channel)))
    }

    fn mixed(&mut self, a: [Value; 3], b: [Value; 3], t: Value) -> [Value; 3] {
        [0, 1, 2].map(|c| self.program.compute(Op::Mix { a: a[c], b: b[c], t }))
    }

    fn operand(&mut self, operand: &ColorOperand) -> Option<[Value; 3]> {
        Some(match operand {
            ColorOperand::Last => self.last?,
            ColorOperand::Rows([r, g, b]) => [self.row(*r)?, self.row(*g)?, self.row(*b)?],
            ColorOperand::Constant(color) => self.constant(color),
            ColorOperand::Pair { from, to, by } => {
                let t = self.row(*by)?;
                let (a, b) = (self.constant(from), self.constant(to));
                self.mixed(a, b, t)
            }
        })
    }

    /// Sets the result of a scalar operation.
    fn set(&mut self, to: u32, op: Op) {
        self.own[to as usize] = Some(self.program.compute(op));
    }

    fn out_color(&mut self, root: u32) -> Option<()> {
        let color = self.last?;
        let (first, _) = self.code.roots[root as usize];
        let state = self.states[root as usize];
        for (c, value) in color.into_iter().enumerate() {
            if self.code.audits {
                self.program.see(value, Some(state + 2 * c as u32), state + 2 * c as u32 + 1, false);
            }
            self.program.output(value, (first + c) as u32);
        }
        Some(())
    }

    fn instruction(&mut self, at: usize, instruction: &Instruction) -> Option<()> {
        match instruction {
            Instruction::Check { plane, index } => {
                self.program.fetch(*plane);
                let value = self.planes[*plane as usize];
                match self.code.checks[*index as usize].1 {
                    ValueRule::Field => self.program.see(value, None, FIELDS as u32, true),
                    ValueRule::Mask => self.program.see(value, Some(MASKS as u32), MASKS as u32 + 1, false),
                    ValueRule::Color => self.program.see(value, None, COLORS as u32, false),
                }
            }
            Instruction::Clamp { x, min, max, to } => {
                let x = self.row(*x)?;
                let op = if is_simple(*min, *max) {
                    Op::Clamp { x, min: *min, width: *max - *min }
                } else if min == max {
                    Op::Step { x, threshold: *max }
                } else {
                    return None;
                };
                self.set(*to, op);
            }
            Instruction::Smooth { t, to } => {
                let t = self.row(*t)?;
                self.set(*to, Op::Smooth(t));
            }
            Instruction::Power { t, p, to } => {
                let t = self.row(*t)?;
                if *p == 1.0 {
                    self.own[*to as usize] = Some(t);
                } else if (1.0..=16.0).contains(p) && *p == p.trunc() {
                    self.set(*to, Op::Power { t, n: *p as u32 });
                } else {
                    return None;
                }
            }
            Instruction::Step { x, threshold, to } => {
                let x = self.row(*x)?;
                self.set(*to, Op::Step { x, threshold: *threshold });
            }
            Instruction::Complement { t, to } => {
                let t = self.row(*t)?;
                self.set(*to, Op::Complement(t));
            }
            Instruction::Product { t, u, to } => {
                let (t, u) = (self.row(*t)?, self.row(*u)?);
                self.set(*to, Op::Product(t, u));
            }
            Instruction::Partition { weights, to } => {
                let weights = self.rows(weights)?;
                let rounded = self.program.partition(weights);
                to.iter().zip(rounded).for_each(|(to, value)| self.own[*to as usize] = Some(value));
            }
            // Its divisions in f64 gain nothing from machine code.
            Instruction::Normalize { .. } => return None,
            Instruction::AuditMask(row) => {
                let value = self.row(*row)?;
                self.program.see(value, Some(WEIGHTS as u32), WEIGHTS as u32 + 1, false);
            }
            Instruction::AuditPartition(rows) => {
                let values = self.rows(rows)?;
                for value in &values {
                    // 1 − w is no less than any other weight, so recording it as well changes nothing.
                    self.program.see(*value, Some(WEIGHTS as u32), WEIGHTS as u32 + 1, false);
                }
                self.program.see_sum(values, SUMS as u32);
            }
            Instruction::Patch { corners, x, y } => {
                let (x, y) = (self.row(*x)?, self.row(*y)?);
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| self.constant(&corners[i]));
                let (top, bottom) = (self.mixed(a, b, x), self.mixed(c, d, x));
                self.last = Some(self.mixed(top, bottom, y));
            }
            Instruction::Mix { a, b, t, out } => {
                let (a, b, t) = (self.operand(a)?, self.operand(b)?, self.row(*t)?);
                self.last = Some(self.mixed(a, b, t));
                if let Some(root) = out {
                    self.out_color(*root)?;
                }
            }
            Instruction::Blend { colors, weights } => {
                let colors = colors.iter().map(|color| self.operand(color)).collect::<Option<Vec<_>>>()?;
                let weights = self.rows(weights)?;
                self.last = Some(self.program.blend(colors, weights));
            }
            Instruction::Load(operand) => self.last = Some(self.operand(operand)?),
            Instruction::Keep(to) => {
                for (to, value) in to.iter().zip(self.last?) {
                    self.own[*to as usize] = Some(value);
                }
            }
            Instruction::Gate { t, closed, otherwise, skip } => {
                let (otherwise, t) = (self.operand(otherwise)?, self.row(*t)?);
                self.program.gate(t, *closed);
                self.gates.push((at + 1 + skip, otherwise));
            }
            Instruction::OutColor(root) => self.out_color(*root)?,
            Instruction::OutRows { root, rows } => {
                let (first, _) = self.code.roots[*root as usize];
                for (channel, value) in self.rows(rows)?.into_iter().enumerate() {
                    if self.code.audits {
                        self.program.see(value, None, self.states[*root as usize], true);
                    }
                    self.program.output(value, (first + channel) as u32);
                }
            }
        }
        Some(())
    }
}

//! Translates a program to machine code, item by item.

use crate::assembler::{Assembler, Reg, Result, VectorPlace};
use crate::branches::Skip;
use crate::operations::{BinaryInstruction, Compare};
use crate::program::{Item, Op, Program, Value};
use crate::registers::{End, Holder, PreparedMask, Registers, Snapshot, ValueSource, Victim, position};
use crate::schedule::scheduled;
use crate::{Set, Stores};
use iced_x86::code_asm::CodeLabel;
use std::collections::BTreeMap;

/// Number of vectors of state in registers: of 32 in wide, of 16 in narrow code.
const PINNED: [usize; 2] = [6, 3];
/// Registers of wide code that contain 0.5 and 1.0 for the whole loop.
const HALF: Reg = 31;
const ONE: Reg = 30;
/// Number of vectors processed side by side, in wide and narrow code: while one waits, the processor works on the
/// other.
const PARTS: [u32; 2] = [2, 1];

/// Machine code, its constants and its number of slots.
#[derive(Debug)]
pub(crate) struct Translated {
    pub(crate) code: Vec<u8>,
    pub(crate) constants: Vec<u32>,
    pub(crate) slots: usize,
    /// Number of samples processed at a time.
    pub(crate) step: usize,
}

/// Translates a program without open gates.
pub(crate) fn translate(program: &Program, set: Set, stores: Stores) -> Result<Translated> {
    let wide = set == Set::Avx512;
    let count = if wide { 32 } else { 16 };
    let parts = PARTS[usize::from(!wide)];
    let fixed = if wide { 2 } else { 0 };
    let program = &scheduled(program, wide, parts);
    let pinned = pinned(program, PINNED[usize::from(!wide)]);
    let mut translator = Translator {
        asm: Assembler::new(wide, parts, program.inputs + program.lines + program.outputs)?,
        registers: Registers::new(program, wide, parts, fixed + pinned.len()),
        pinned: pinned.iter().enumerate().map(|(index, state)| (*state, (count - 1 - fixed - index) as Reg)).collect(),
        program,
        stores,
        gates: Vec::new(),
        skips: Vec::new(),
        made: Vec::new(),
        parts,
        part: 0,
        at: 0,
    };
    translator.whole()?;
    let slots = translator.registers.slots();
    let (code, constants) = translator.asm.finish()?;
    let step = if wide { 16 } else { 8 } * parts as usize;
    Ok(Translated { code, constants, slots, step })
}

/// Returns the vectors of state that are used most often.
fn pinned(program: &Program, most: usize) -> Vec<u32> {
    let mut seen: BTreeMap<u32, usize> = BTreeMap::new();
    for item in &program.items {
        if let Item::See { least, largest, .. } = item {
            [Some(*largest), *least].into_iter().flatten().for_each(|state| *seen.entry(state).or_default() += 1);
        }
    }
    let mut order: Vec<(u32, usize)> = seen.into_iter().collect();
    order.sort_by_key(|(state, count)| (std::cmp::Reverse(*count), *state));
    order.into_iter().take(most).map(|(state, _)| state).collect()
}

pub(crate) struct Translator<'p> {
    pub(crate) asm: Assembler,
    pub(crate) registers: Registers,
    /// Registers of pinned state, by the index of the state.
    pub(crate) pinned: BTreeMap<u32, Reg>,
    pub(crate) program: &'p Program,
    pub(crate) stores: Stores,
    /// Open gates: the places of all values, and the target of the jump.
    pub(crate) gates: Vec<(Snapshot, CodeLabel)>,
    /// Paths around finished branches.
    pub(crate) skips: Vec<Skip>,
    /// Values that the current item made.
    pub(crate) made: Vec<Value>,
    pub(crate) parts: u32,
    pub(crate) part: u32,
    pub(crate) at: u32,
}

impl Translator<'_> {
    fn whole(&mut self) -> Result {
        for (state, register) in &self.pinned {
            self.asm.load(*register, VectorPlace::State(*state))?;
        }
        if self.asm.wide {
            self.asm.fill(HALF, 0.5)?;
            self.asm.fill(ONE, 1.0)?;
        }
        self.asm.begin()?;
        let program = self.program;
        for (at, item) in program.items.iter().enumerate() {
            let parts: Vec<Item> = (0..self.parts).map(|part| item.map(|value| value.of(part, self.parts))).collect();
            for part in 0..self.parts {
                self.part = part;
                self.at = position(item, at, part, self.parts);
                match item {
                    Item::Gate { closed, .. } if part == 0 => self.gate(&parts, *closed)?,
                    Item::Join { .. } if part == 0 => self.join(&parts)?,
                    Item::Gate { .. } | Item::Join { .. } => {}
                    _ => self.item(&parts[part as usize])?,
                }
                self.registers.end(std::mem::take(&mut self.made), &parts[part as usize], self.at);
            }
        }
        self.asm.repeat()?;
        for (state, register) in &self.pinned {
            self.asm.store(VectorPlace::State(*state), *register)?;
        }
        self.asm.leave()?;
        self.around()
    }

    /// Takes a register for the current item.
    pub(crate) fn take(&mut self) -> Result<Reg> {
        match self.registers.take(self.at) {
            Victim::Free(register) => Ok(register),
            Victim::Store(register, slot) => {
                self.asm.store(VectorPlace::Slot(slot), register)?;
                Ok(register)
            }
        }
    }

    pub(crate) fn take_all<const N: usize>(&mut self) -> Result<[Reg; N]> {
        let mut all = [0; N];
        for register in &mut all {
            *register = self.take()?;
        }
        Ok(all)
    }

    pub(crate) fn give_back(&mut self, registers: &[Reg]) {
        registers.iter().for_each(|register| self.registers.give_back(*register));
    }

    /// Returns the register of a value, which is loaded if necessary.
    pub(crate) fn value(&mut self, value: Value) -> Result<Reg> {
        if let Some(register) = self.registers.find(value) {
            return Ok(register);
        }
        let register = self.take()?;
        match (self.registers.slot(value), self.registers.source(value)) {
            (_, Some(source)) => self.fetch(register, source)?,
            (Some(slot), None) => self.asm.load(register, VectorPlace::Slot(slot))?,
            (None, None) => unreachable!("values are used where they were made, or after what they were made before"),
        }
        self.registers.hold(register, Holder::Value(value));
        Ok(register)
    }

    pub(crate) fn fetch(&mut self, register: Reg, source: ValueSource) -> Result {
        match source {
            ValueSource::Row(row, part) => self.asm.load(register, VectorPlace::Row(row, part)),
            ValueSource::Line(row) => self.asm.line(register, row),
            ValueSource::Constant(constant) => self.asm.fill(register, constant),
        }
    }

    pub(crate) fn constant(&self, value: Value) -> Option<f32> {
        match self.registers.source(value) {
            Some(ValueSource::Constant(constant)) => Some(constant),
            _ => None,
        }
    }

    /// Records that a register has a value that was just made.
    pub(crate) fn define(&mut self, value: Value, register: Reg) {
        self.registers.hold(register, Holder::Value(value));
        self.made.push(value);
    }

    fn item(&mut self, item: &Item) -> Result {
        match item {
            Item::Compute { op, to } => self.compute(op, *to),
            Item::Blend { colors, weights, to } => self.blend(colors, weights, *to),
            Item::Partition { weights, to } => self.partition(weights, to),
            Item::Over { x, min, width, to } => {
                let x = self.value(*x)?;
                let d = self.take()?;
                self.asm.binary_constant(BinaryInstruction::Sub, d, x, *min)?;
                self.asm.binary_constant(BinaryInstruction::Div, d, d, *width)?;
                self.define(*to, d);
                Ok(())
            }
            Item::Within { x, to } => {
                let x_in = self.value(*x)?;
                let d = self.over(*x, x_in, &[])?;
                // If both operands are equal or one is NaN, the instruction returns the second.
                self.asm.binary_constant(BinaryInstruction::Max, d, x_in, 0.0)?;
                if self.asm.wide {
                    self.asm.binary(BinaryInstruction::Min, d, d, ONE)?
                } else {
                    self.asm.binary_constant(BinaryInstruction::Min, d, d, 1.0)?
                }
                self.define(*to, d);
                Ok(())
            }
            Item::Ready(t) => self.by(*t).map(|_| ()),
            Item::Fetch(input) => self.asm.fetch(*input as usize, self.part),
            Item::See { value, least, largest, shifted } => self.see(*value, *least, *largest, *shifted),
            Item::SeeSum { weights, state } => self.see_sum(weights, *state),
            Item::Output { value, to } => {
                let register = self.value(*value)?;
                let place = VectorPlace::Row(self.program.inputs + self.program.lines + *to as usize, self.part);
                match self.stores {
                    Stores::Cached => self.asm.store(place, register),
                    Stores::Around => self.asm.stream(place, register),
                }
            }
            Item::Gate { .. } | Item::Join { .. } => unreachable!("for all vectors at once"),
        }
    }

    fn compute(&mut self, op: &Op, to: Value) -> Result {
        match *op {
            // Loaded when they are used.
            Op::Input(_) | Op::Line(_) | Op::Constant(_) => Ok(()),
            Op::Mix { a, b, t } => self.mix(a, b, t, to),
            Op::Clamp { .. } => unreachable!("clamps are split"),
            Op::Step { x, threshold } => {
                let x = self.value(x)?;
                let d = self.take()?;
                let mask = self.asm.scratch(d);
                self.asm.compare_constant(mask, Compare::AtLeast, x, threshold)?;
                self.asm.choose(d, mask, 0.0, 1.0)?;
                self.define(to, d);
                Ok(())
            }
            Op::Complement(t) => {
                let t = self.value(t)?;
                let d = self.take()?;
                if self.asm.wide {
                    self.asm.binary(BinaryInstruction::Sub, d, ONE, t)?;
                } else {
                    self.asm.fill(d, 1.0)?;
                    self.asm.binary(BinaryInstruction::Sub, d, d, t)?;
                }
                self.define(to, d);
                Ok(())
            }
            Op::Product(t, u) => {
                let (t, u) = (self.value(t)?, self.value(u)?);
                let d = self.take()?;
                self.asm.binary(BinaryInstruction::Mul, d, t, u)?;
                self.define(to, d);
                Ok(())
            }
            Op::Smooth(t) => {
                let t = self.value(t)?;
                let [low, high, factor] = self.take_all()?;
                self.asm.widen(low, high, t)?;
                for half in [low, high] {
                    // 2·t is exact, so 3 − 2·t is rounded only once.
                    self.asm.fill_double(factor, 3.0)?;
                    self.asm.binary_double(BinaryInstruction::FnmaDouble, factor, half, 2.0)?;
                    self.asm.binary(BinaryInstruction::MulDouble, half, half, half)?;
                    self.asm.binary(BinaryInstruction::MulDouble, half, half, factor)?;
                }
                self.asm.narrow(factor, low, high)?;
                self.define(to, factor);
                Ok(())
            }
            Op::Power { t, n } => {
                let t = self.value(t)?;
                let [low, high, square, d] = self.take_all()?;
                self.asm.widen(low, high, t)?;
                for half in [low, high] {
                    self.asm.copy(square, half)?;
                    let (mut n, mut is_first) = (n, true);
                    while n > 0 {
                        if n & 1 == 1 {
                            if is_first {
                                self.asm.copy(half, square)?;
                            } else {
                                self.asm.binary(BinaryInstruction::MulDouble, half, half, square)?;
                            }
                            is_first = false;
                        }
                        n >>= 1;
                        if n > 0 {
                            self.asm.binary(BinaryInstruction::MulDouble, square, square, square)?;
                        }
                    }
                }
                self.asm.narrow(d, low, high)?;
                self.asm.binary(BinaryInstruction::Min, d, d, t)?;
                self.define(to, d);
                Ok(())
            }
        }
    }

    /// Prepares a mask: finds the nearer end, and the distance from it.
    fn by(&mut self, t: Value) -> Result<PreparedMask> {
        if let Some(by) = self.registers.by.iter().find(|by| by.of == t).copied() {
            self.registers.lock_by(by);
            return Ok(by);
        }
        let x = self.value(t)?;
        let by = self.take()?;
        let mask = if self.asm.wide { self.registers.mask(self.at) } else { self.take()? };
        let near = self.registers.near(t);
        let how = if near == End::A { Compare::Less } else { Compare::NotLess };
        if self.asm.wide {
            self.asm.compare(mask, how, x, HALF)?;
            if near == End::A {
                self.asm.binary(BinaryInstruction::Sub, by, x, ONE)?;
                self.asm.select(by, mask, by, x)?;
            } else {
                // The processor eliminates register copies.
                self.asm.copy(by, x)?;
                self.asm.sub_where(by, mask, x, ONE)?;
            }
        } else {
            self.asm.compare_constant(mask, how, x, 0.5)?;
            let [others, lanes] = if near == End::A { [1.0, 0.0] } else { [0.0, 1.0] };
            self.asm.choose(by, mask, others, lanes)?;
            self.asm.binary(BinaryInstruction::Sub, by, x, by)?;
            self.registers.hold(mask, Holder::MaskSide(t));
        }
        self.registers.hold(by, Holder::MaskDistance(t));
        let by = PreparedMask { of: t, by, mask, near };
        self.registers.by.push(by);
        Ok(by)
    }

    fn mix(&mut self, a: Value, b: Value, t: Value, to: Value) -> Result {
        let PreparedMask { by, mask, near, .. } = self.by(t)?;
        let d = match (self.constant(a), self.constant(b)) {
            (Some(from), Some(until)) => {
                let d = self.take()?;
                let [far, near] = if near == End::A { [until, from] } else { [from, until] };
                self.asm.choose(d, mask, far, near)?;
                self.asm.binary_constant(BinaryInstruction::Fma, d, by, until - from)?;
                d
            }
            // For −0 and 0, the result would have the other sign.
            (None, Some(until)) if near == End::B && until != 0.0 => {
                let a_in = self.value(a)?;
                let difference = self.take()?;
                self.asm.binary_constant(BinaryInstruction::Sub, difference, a_in, until)?;
                let d = self.over(a, a_in, &[b, t])?;
                self.asm.select_constant(d, mask, a_in, until)?;
                self.asm.binary(BinaryInstruction::Fnma, d, by, difference)?;
                d
            }
            (Some(from), None) if near == End::A => {
                let b_in = self.value(b)?;
                let difference = self.take()?;
                self.asm.binary_constant(BinaryInstruction::Sub, difference, b_in, from)?;
                let d = self.over(b, b_in, &[a, t])?;
                self.asm.select_constant(d, mask, b_in, from)?;
                self.asm.binary(BinaryInstruction::Fma, d, by, difference)?;
                d
            }
            _ => {
                let (a_in, b_in) = (self.value(a)?, self.value(b)?);
                let difference = self.take()?;
                self.asm.binary(BinaryInstruction::Sub, difference, b_in, a_in)?;
                let d = if self.registers.may_reuse(a, self.at) {
                    self.over(a, a_in, &[b, t])?
                } else {
                    self.over(b, b_in, &[a, t])?
                };
                self.select(d, near, mask, a_in, b_in)?;
                self.asm.binary(BinaryInstruction::Fma, d, by, difference)?;
                d
            }
        };
        self.define(to, d);
        Ok(())
    }

    /// Returns the register of a value after its last use, unless the value is among `others`; else a new register.
    fn over(&mut self, value: Value, register: Reg, others: &[Value]) -> Result<Reg> {
        if !others.contains(&value) && self.registers.may_reuse(value, self.at) {
            self.registers.reuse(value);
            return Ok(register);
        }
        self.take()
    }

    /// Selects b where it is nearer, else a.
    fn select(&mut self, to: Reg, near: End, mask: Reg, a: Reg, b: Reg) -> Result {
        match near {
            End::A => self.asm.select(to, mask, b, a),
            End::B => self.asm.select(to, mask, a, b),
        }
    }

    fn see(&mut self, value: Value, least: Option<u32>, largest: u32, shifted: bool) -> Result {
        let mut x = self.value(value)?;
        if shifted {
            let bits = self.take()?;
            self.asm.shift(bits, x)?;
            x = bits;
        }
        for (op, state) in [(BinaryInstruction::MinBits, least), (BinaryInstruction::MaxBits, Some(largest))] {
            let Some(state) = state else { continue };
            if let Some(register) = self.pinned.get(&state).copied() {
                self.asm.binary(op, register, register, x)?;
            } else {
                let seen = self.take()?;
                self.asm.binary_memory(op, seen, x, VectorPlace::State(state))?;
                self.asm.store(VectorPlace::State(state), seen)?;
            }
        }
        Ok(())
    }
}

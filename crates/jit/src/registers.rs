//! What each vector register holds: values stay in registers as long as there are enough, and the one that is needed
//! again last gives way.

use crate::assembler::Reg;
use crate::program::{Item, Op, Program, Value};

/// What a register holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holder {
    Nothing,
    /// What the instruction at hand works with.
    Temporary,
    /// State, throughout.
    Pinned,
    Value(Value),
    /// How far a mask is from its nearer end.
    By(Value),
    /// Which end that is. Narrow vectors only; wide ones have mask registers.
    Near(Value),
}

/// Where a value can be had besides in a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    Row(usize, u32),
    Line(usize),
    Constant(f32),
}

/// A value.
#[derive(Clone, Debug, Default)]
struct Home {
    register: Option<Reg>,
    slot: Option<u32>,
    source: Option<Source>,
    /// The items that take it.
    uses: Vec<u32>,
    /// The mixes that it weighs.
    mixes: Vec<u32>,
    /// How many of them have a constant at its 0 only, less those that have one at its 1 only.
    from_constants: i32,
}

/// An end of a mix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    A,
    B,
}

/// A mask made ready for mixing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct By {
    pub(crate) of: Value,
    pub(crate) by: Reg,
    /// Where one of the ends is nearer: a mask register, or a vector register in narrow code.
    pub(crate) mask: Reg,
    /// Which one.
    pub(crate) near: End,
}

/// Where everything is at a gate.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    holders: Vec<Holder>,
    by: Vec<By>,
    /// By value.
    slots: Vec<Option<u32>>,
}

/// What brings a value from where it is to where it must be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Move {
    Store(Reg, u32),
    Load(Reg, u32),
    Source(Reg, Source),
}

/// What has to give way.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Victim {
    /// Nothing is lost.
    Free(Reg),
    /// The value has to be stored to the slot first.
    Store(Reg, u32),
}

#[derive(Debug)]
pub(crate) struct Registers {
    holders: Vec<Holder>,
    /// Registers of the item at hand.
    locked: u32,
    homes: Vec<Home>,
    pub(crate) by: Vec<By>,
    wide: bool,
    free_slots: Vec<u32>,
    slots: u32,
}

/// When an item runs for one of the vectors side by side: one after the other, but where branches begin and end.
pub(crate) fn position(item: &Item, at: usize, part: u32, parts: u32) -> u32 {
    let part = if matches!(item, Item::Gate { .. } | Item::Join { .. }) { parts - 1 } else { part };
    at as u32 * parts + part
}

/// Never.
const NEVER: u32 = u32::MAX;

impl Registers {
    /// For a program that works on `parts` vectors side by side; the last `pinned` registers are taken.
    pub(crate) fn new(program: &Program, wide: bool, parts: u32, pinned: usize) -> Self {
        let count = if wide { 32 } else { 16 };
        let mut holders = vec![Holder::Nothing; count];
        holders[count - pinned..].fill(Holder::Pinned);
        let mut homes = vec![Home::default(); program.values as usize * parts as usize];
        for (at, item) in program.items.iter().enumerate() {
            for part in 0..parts {
                let at = position(item, at, part, parts);
                let home = |value: &Value| value.of(part, parts).0 as usize;
                item.operands(|value| homes[home(&value)].uses.push(at));
                let Item::Compute { op, to } = item else { continue };
                homes[home(to)].source = match op {
                    Op::Input(index) => Some(Source::Row(*index as usize, part)),
                    Op::Line(index) => Some(Source::Line(program.inputs + *index as usize)),
                    Op::Constant(value) => Some(Source::Constant(*value)),
                    _ => None,
                };
                if let Op::Mix { a, b, t } = op {
                    let is_constant = |value| i32::from(matches!(homes[home(value)].source, Some(Source::Constant(_))));
                    let from = is_constant(a) - is_constant(b);
                    let mask = &mut homes[home(t)];
                    mask.mixes.push(at);
                    mask.from_constants += from;
                }
            }
        }
        Self { holders, locked: 0, homes, by: Vec::new(), wide, free_slots: Vec::new(), slots: 0 }
    }

    /// Number of slots that the code needs.
    pub(crate) fn slots(&self) -> usize {
        self.slots as usize
    }

    pub(crate) fn source(&self, value: Value) -> Option<Source> {
        self.homes[value.0 as usize].source
    }

    pub(crate) fn slot(&self, value: Value) -> Option<u32> {
        self.homes[value.0 as usize].slot
    }

    /// The register of a value, kept until the end of the item.
    pub(crate) fn find(&mut self, value: Value) -> Option<Reg> {
        let register = self.homes[value.0 as usize].register?;
        self.locked |= 1 << register;
        Some(register)
    }

    /// Whether an item takes a value last.
    pub(crate) fn is_last(&self, value: Value, at: u32) -> bool {
        self.homes[value.0 as usize].uses.last().is_none_or(|last| *last <= at)
    }

    /// Whether the item at hand may overwrite a value: it is in a register, and taken last.
    pub(crate) fn may_reuse(&self, value: Value, at: u32) -> bool {
        self.homes[value.0 as usize].register.is_some() && self.is_last(value, at)
    }

    /// Gives up a value for what the item at hand makes in its register.
    pub(crate) fn reuse(&mut self, value: Value) {
        if let Some(register) = self.homes[value.0 as usize].register.take() {
            self.lock(register as usize);
        }
    }

    /// The end of a mask that most mixes want in a mask register: a vector and a constant are selected from at once if
    /// the constant is where the mask is set.
    pub(crate) fn near(&self, t: Value) -> End {
        if self.homes[t.0 as usize].from_constants > 0 { End::A } else { End::B }
    }

    /// A register for the item at hand, and what has to happen to what it held.
    pub(crate) fn take(&mut self, at: u32) -> Victim {
        let open = |register: &usize| self.locked >> register & 1 == 0 && self.holders[*register] != Holder::Pinned;
        let free = (0..self.holders.len()).filter(open).find(|r| self.holders[*r] == Holder::Nothing);
        if let Some(register) = free {
            return Victim::Free(self.lock(register));
        }
        let victim = (0..self.holders.len()).filter(open).max_by_key(|register| match self.holders[*register] {
            Holder::Value(value) => {
                let home = &self.homes[value.0 as usize];
                // Of what is needed equally late, what costs nothing to give up.
                (next(&home.uses, at), u8::from(home.slot.is_some() || home.source.is_some()) * 2)
            }
            Holder::By(value) | Holder::Near(value) => (next(&self.homes[value.0 as usize].mixes, at), 1),
            _ => (0, 0),
        });
        let Some(register) = victim else { unreachable!("no item works with that many registers") };
        let held = self.holders[register];
        let register = self.lock(register);
        match held {
            Holder::Value(value) => {
                let home = &mut self.homes[value.0 as usize];
                home.register = None;
                if home.slot.is_none() && home.source.is_none() {
                    let slot = self.new_slot();
                    self.homes[value.0 as usize].slot = Some(slot);
                    return Victim::Store(register, slot);
                }
            }
            Holder::By(value) | Holder::Near(value) => {
                self.drop_by(value);
                self.holders[register as usize] = Holder::Temporary;
            }
            _ => {}
        }
        Victim::Free(register)
    }

    fn lock(&mut self, register: usize) -> Reg {
        self.locked |= 1 << register;
        self.holders[register] = Holder::Temporary;
        register as Reg
    }

    /// Keeps the registers of a ready mask until the end of the item.
    pub(crate) fn lock_by(&mut self, by: By) {
        self.locked |= 1 << by.by;
        if !self.wide {
            self.locked |= 1 << by.mask;
        }
    }

    /// Gives back what the item at hand needs no longer.
    pub(crate) fn give_back(&mut self, register: Reg) {
        if self.holders[register as usize] == Holder::Temporary {
            self.holders[register as usize] = Holder::Nothing;
        }
        self.locked &= !(1 << register);
    }

    /// A mask register for a new ready mask. Wide only.
    pub(crate) fn mask(&mut self, at: u32) -> u8 {
        let used = |mask: u8| self.by.iter().any(|by| by.mask == mask);
        if let Some(free) = (1..crate::assembler::SCRATCH_MASK).find(|mask| !used(*mask)) {
            return free;
        }
        let open = self.by.iter().filter(|by| self.locked >> by.by & 1 == 0);
        let Some(victim) = open.max_by_key(|by| next(&self.homes[by.of.0 as usize].mixes, at)).copied() else {
            unreachable!("an item makes one mask ready")
        };
        self.drop_by(victim.of);
        victim.mask
    }

    /// Forgets a ready mask.
    fn drop_by(&mut self, of: Value) {
        self.by.retain(|by| by.of != of);
        for holder in &mut self.holders {
            if matches!(holder, Holder::By(value) | Holder::Near(value) if *value == of) {
                *holder = Holder::Nothing;
            }
        }
    }

    /// Notes what a register holds from now on.
    pub(crate) fn hold(&mut self, register: Reg, holder: Holder) {
        self.holders[register as usize] = holder;
        if let Holder::Value(value) = holder {
            self.homes[value.0 as usize].register = Some(register);
        }
    }

    pub(crate) fn new_slot(&mut self) -> u32 {
        self.free_slots.pop().unwrap_or_else(|| {
            self.slots += 1;
            self.slots - 1
        })
    }

    /// Notes that a slot holds a value.
    pub(crate) fn set_slot(&mut self, value: Value, slot: u32) {
        self.homes[value.0 as usize].slot = Some(slot);
    }

    /// After an item that made some values: frees what nobody needs any more.
    pub(crate) fn end(&mut self, mut done: Vec<Value>, item: &Item, at: u32) {
        self.locked = 0;
        for holder in &mut self.holders {
            if *holder == Holder::Temporary {
                *holder = Holder::Nothing;
            }
        }
        item.operands(|value| done.push(value));
        for value in done {
            if !self.is_last(value, at) {
                continue;
            }
            if let Some(register) = self.homes[value.0 as usize].register.take() {
                self.holders[register as usize] = Holder::Nothing;
            }
            if let Some(slot) = self.homes[value.0 as usize].slot.take() {
                self.free_slots.push(slot);
            }
            self.drop_by(value);
        }
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        let slots = self.homes.iter().map(|home| home.slot).collect();
        Snapshot { holders: self.holders.clone(), by: self.by.clone(), slots }
    }

    /// Gives a value's register to another value that is the same.
    pub(crate) fn rename(&mut self, from: Value, to: Value) {
        if let Some(register) = self.homes[from.0 as usize].register.take() {
            self.hold(register, Holder::Value(to));
        }
    }

    /// What has to happen where the branch from a gate to item `join` is jumped over, so that everything is where it is
    /// after the branch; `results` are the values that the join makes, and what they are then.
    pub(crate) fn resolve(&mut self, gate: &Snapshot, join: u32, results: &[(Value, Value)]) -> Vec<Move> {
        // Masks made ready on one of the two ways only are lost.
        let lost: Vec<By> = self.by.iter().filter(|by| !gate.by.contains(by)).copied().collect();
        lost.iter().for_each(|by| self.drop_by(by.of));
        let register_then = |value: Value| gate.holders.iter().position(|holder| *holder == Holder::Value(value));
        let (mut stores, mut loads, mut spare) = (Vec::new(), Vec::new(), Vec::new());
        // Slots that were given inside.
        for at in 0..self.homes.len() {
            let (value, home) = (Value(at as u32), &self.homes[at]);
            let is_needed = home.uses.last().is_some_and(|last| *last >= join);
            if let (Some(slot), None, Some(register)) = (home.slot, gate.slots[at], register_then(value))
                && is_needed
            {
                stores.push(Move::Store(register as Reg, slot));
            }
        }
        for register in 0..self.holders.len() {
            let Holder::Value(value) = self.holders[register] else { continue };
            let result = results.iter().find(|(to, _)| *to == value);
            // What the register must hold.
            let then = result.map_or(value, |(_, otherwise)| *otherwise);
            let home = &self.homes[then.0 as usize];
            let is_needed = home.uses.last().is_some_and(|last| *last >= join);
            if register_then(then) == Some(register) || !is_needed {
                continue;
            }
            let to = register as Reg;
            if let Some(source) = home.source {
                loads.push(Move::Source(to, source));
            } else if let Some(slot) = gate.slots[then.0 as usize] {
                loads.push(Move::Load(to, slot));
            } else if let Some(from) = register_then(then) {
                let slot = self.new_slot();
                spare.push(slot);
                stores.push(Move::Store(from as Reg, slot));
                loads.push(Move::Load(to, slot));
            } else {
                unreachable!("what is needed after a branch was there before it")
            }
        }
        self.free_slots.extend(spare);
        // Every store before every load: no load takes the place of what is still to be stored.
        stores.extend(loads);
        stores
    }
}

/// The first of some items from `at` on.
fn next(uses: &[u32], at: u32) -> u32 {
    uses.get(uses.partition_point(|item| *item < at)).copied().unwrap_or(NEVER)
}

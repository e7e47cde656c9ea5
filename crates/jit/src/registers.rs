//! Register allocation: values stay in vector registers as long as there are enough; otherwise the value with the
//! latest next use is stored.

use crate::assembler::Reg;
use crate::program::{Item, Op, Program, Value};

/// Content of a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holder {
    Nothing,
    /// Temporary value of the current item.
    Temporary,
    /// State, for the whole loop.
    Pinned,
    Value(Value),
    /// Signed distance of a mask from its nearer end.
    MaskDistance(Value),
    /// Selects the nearer end of a mask. Narrow code only; wide code uses mask registers.
    MaskSide(Value),
}

/// Source of a value other than a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ValueSource {
    Row(usize, u32),
    Line(usize),
    Constant(f32),
}

/// Places and uses of a value.
#[derive(Clone, Debug, Default)]
struct ValuePlaces {
    register: Option<Reg>,
    slot: Option<u32>,
    source: Option<ValueSource>,
    /// Items that use the value.
    uses: Vec<u32>,
    /// Mixes with the value as the weight.
    mixes: Vec<u32>,
    /// Number of these mixes with a constant only at t = 0, minus those with a constant only at t = 1.
    from_constants: i32,
}

/// An end of a mix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    A,
    B,
}

/// A mask that is prepared for mixing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PreparedMask {
    pub(crate) of: Value,
    pub(crate) by: Reg,
    /// Lanes in which the end `near` is nearer: a mask register, or a vector register in narrow code.
    pub(crate) mask: Reg,
    /// End that is nearer in the lanes of `mask`.
    pub(crate) near: End,
}

/// Places of all values at a gate.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    holders: Vec<Holder>,
    by: Vec<PreparedMask>,
    /// Slots, by value.
    slots: Vec<Option<u32>>,
}

/// Instruction that moves a value to the place where it is needed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Move {
    Store(Reg, u32),
    Load(Reg, u32),
    Fetch(Reg, ValueSource),
}

/// Register that is freed for a new value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Victim {
    /// The register can be overwritten.
    Free(Reg),
    /// The value has to be stored to the slot first.
    Store(Reg, u32),
}

#[derive(Debug)]
pub(crate) struct Registers {
    holders: Vec<Holder>,
    /// Registers of the current item, as bits.
    locked: u32,
    homes: Vec<ValuePlaces>,
    pub(crate) by: Vec<PreparedMask>,
    wide: bool,
    free_slots: Vec<u32>,
    slots: u32,
}

/// Returns the position of an item for one of the vectors side by side: consecutive, except where branches begin and
/// end.
pub(crate) fn position(item: &Item, at: usize, part: u32, parts: u32) -> u32 {
    let part = if matches!(item, Item::Gate { .. } | Item::Join { .. }) { parts - 1 } else { part };
    at as u32 * parts + part
}

/// Position of a use that does not exist.
const NEVER: u32 = u32::MAX;

impl Registers {
    /// Makes the allocation for a program that processes `parts` vectors side by side; the last `pinned` registers
    /// are reserved.
    pub(crate) fn new(program: &Program, wide: bool, parts: u32, pinned: usize) -> Self {
        let count = if wide { 32 } else { 16 };
        let mut holders = vec![Holder::Nothing; count];
        holders[count - pinned..].fill(Holder::Pinned);
        let mut homes = vec![ValuePlaces::default(); program.values as usize * parts as usize];
        for (at, item) in program.items.iter().enumerate() {
            for part in 0..parts {
                let at = position(item, at, part, parts);
                let home = |value: &Value| value.of(part, parts).0 as usize;
                item.operands(|value| homes[home(&value)].uses.push(at));
                let Item::Compute { op, to } = item else { continue };
                homes[home(to)].source = match op {
                    Op::Input(index) => Some(ValueSource::Row(*index as usize, part)),
                    Op::Line(index) => Some(ValueSource::Line(program.inputs + *index as usize)),
                    Op::Constant(value) => Some(ValueSource::Constant(*value)),
                    _ => None,
                };
                if let Op::Mix { a, b, t } = op {
                    let is_constant =
                        |value| i32::from(matches!(homes[home(value)].source, Some(ValueSource::Constant(_))));
                    let from = is_constant(a) - is_constant(b);
                    let mask = &mut homes[home(t)];
                    mask.mixes.push(at);
                    mask.from_constants += from;
                }
            }
        }
        Self { holders, locked: 0, homes, by: Vec::new(), wide, free_slots: Vec::new(), slots: 0 }
    }

    /// Returns the number of slots that the code needs.
    pub(crate) fn slots(&self) -> usize {
        self.slots as usize
    }

    pub(crate) fn source(&self, value: Value) -> Option<ValueSource> {
        self.homes[value.0 as usize].source
    }

    pub(crate) fn slot(&self, value: Value) -> Option<u32> {
        self.homes[value.0 as usize].slot
    }

    /// Returns the register of a value, and locks it until the end of the item.
    pub(crate) fn find(&mut self, value: Value) -> Option<Reg> {
        let register = self.homes[value.0 as usize].register?;
        self.locked |= 1 << register;
        Some(register)
    }

    /// Whether an item is the last to use a value.
    pub(crate) fn is_last(&self, value: Value, at: u32) -> bool {
        self.homes[value.0 as usize].uses.last().is_none_or(|last| *last <= at)
    }

    /// Whether the current item may overwrite a value: it is in a register, and this is its last use.
    pub(crate) fn may_reuse(&self, value: Value, at: u32) -> bool {
        self.homes[value.0 as usize].register.is_some() && self.is_last(value, at)
    }

    /// Drops a value, so that the current item can use its register for a result.
    pub(crate) fn reuse(&mut self, value: Value) {
        if let Some(register) = self.homes[value.0 as usize].register.take() {
            self.lock(register as usize);
        }
    }

    /// Returns the end of a mask that most mixes need in the mask register: one instruction selects between a vector
    /// and a constant if the constant is for the set lanes.
    pub(crate) fn near(&self, t: Value) -> End {
        if self.homes[t.0 as usize].from_constants > 0 { End::A } else { End::B }
    }

    /// Takes a register for the current item; its old value may have to be stored first.
    pub(crate) fn take(&mut self, at: u32) -> Victim {
        let open = |register: &usize| self.locked >> register & 1 == 0 && self.holders[*register] != Holder::Pinned;
        let free = (0..self.holders.len()).filter(open).find(|r| self.holders[*r] == Holder::Nothing);
        if let Some(register) = free {
            return Victim::Free(self.lock(register));
        }
        let victim = (0..self.holders.len()).filter(open).max_by_key(|register| match self.holders[*register] {
            Holder::Value(value) => {
                let home = &self.homes[value.0 as usize];
                // Among values with the same next use, prefer one that needs no store.
                (next(&home.uses, at), u8::from(home.slot.is_some() || home.source.is_some()) * 2)
            }
            Holder::MaskDistance(value) | Holder::MaskSide(value) => (next(&self.homes[value.0 as usize].mixes, at), 1),
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
            Holder::MaskDistance(value) | Holder::MaskSide(value) => {
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

    /// Locks the registers of a prepared mask until the end of the item.
    pub(crate) fn lock_by(&mut self, by: PreparedMask) {
        self.locked |= 1 << by.by;
        if !self.wide {
            self.locked |= 1 << by.mask;
        }
    }

    /// Frees a temporary register of the current item.
    pub(crate) fn give_back(&mut self, register: Reg) {
        if self.holders[register as usize] == Holder::Temporary {
            self.holders[register as usize] = Holder::Nothing;
        }
        self.locked &= !(1 << register);
    }

    /// Returns a mask register for a new prepared mask. Wide code only.
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

    /// Drops a prepared mask.
    fn drop_by(&mut self, of: Value) {
        self.by.retain(|by| by.of != of);
        for holder in &mut self.holders {
            if matches!(holder, Holder::MaskDistance(value) | Holder::MaskSide(value) if *value == of) {
                *holder = Holder::Nothing;
            }
        }
    }

    /// Sets the content of a register.
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

    /// Sets the slot of a value.
    pub(crate) fn set_slot(&mut self, value: Value, slot: u32) {
        self.homes[value.0 as usize].slot = Some(slot);
    }

    /// Ends an item that made some values: frees all values that are no longer needed.
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

    /// Gives the register of a value to another value that is equal.
    pub(crate) fn rename(&mut self, from: Value, to: Value) {
        if let Some(register) = self.homes[from.0 as usize].register.take() {
            self.hold(register, Holder::Value(to));
        }
    }

    /// Returns the moves for the path around the branch from a gate to item `join`, which bring all values to their
    /// places after the branch. `results` are the values that the join makes, and the values that they equal on this
    /// path.
    pub(crate) fn resolve(&mut self, gate: &Snapshot, join: u32, results: &[(Value, Value)]) -> Vec<Move> {
        // Masks that only one of the two paths has prepared are dropped.
        let lost: Vec<PreparedMask> = self.by.iter().filter(|by| !gate.by.contains(by)).copied().collect();
        lost.iter().for_each(|by| self.drop_by(by.of));
        let register_then = |value: Value| gate.holders.iter().position(|holder| *holder == Holder::Value(value));
        let (mut stores, mut loads, mut spare) = (Vec::new(), Vec::new(), Vec::new());
        // Slots that were assigned inside of the branch.
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
            // The value that the register must have.
            let then = result.map_or(value, |(_, otherwise)| *otherwise);
            let home = &self.homes[then.0 as usize];
            let is_needed = home.uses.last().is_some_and(|last| *last >= join);
            if register_then(then) == Some(register) || !is_needed {
                continue;
            }
            let to = register as Reg;
            if let Some(source) = home.source {
                loads.push(Move::Fetch(to, source));
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
        // All stores come before all loads, so that no load overwrites a register that is still to be stored.
        stores.extend(loads);
        stores
    }
}

/// Returns the first use from `at` on.
fn next(uses: &[u32], at: u32) -> u32 {
    uses.get(uses.partition_point(|item| *item < at)).copied().unwrap_or(NEVER)
}

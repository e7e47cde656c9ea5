//! Branches, which are jumped over when their results are not needed.

use crate::assembler::{OTHER_MASK, Reg, Result, SCRATCH_MASK, VectorPlace};
use crate::program::Item;
use crate::registers::{Holder, Move};
use crate::translate::Translator;
use iced_x86::code_asm::CodeLabel;

/// Code path around a branch.
pub(crate) struct Skip {
    skipped: CodeLabel,
    moves: Vec<Move>,
    end: CodeLabel,
}

impl Translator<'_> {
    /// Jumps over a branch if it is closed in all vectors side by side.
    pub(crate) fn gate(&mut self, parts: &[Item], closed: f32) -> Result {
        let vectors: [Reg; 2] = self.take_all()?;
        let [found, other] = if self.asm.wide { [SCRATCH_MASK, OTHER_MASK] } else { vectors };
        for (index, part) in parts.iter().enumerate() {
            let Item::Gate { t, .. } = part else { continue };
            let x = self.value(*t)?;
            if index == 0 {
                self.asm.equals(found, x, closed)?;
            } else {
                self.asm.equals(other, x, closed)?;
                self.asm.both(found, other)?;
            }
        }
        let label = self.asm.label();
        self.asm.jump_if_all(found, label)?;
        self.give_back(&vectors);
        self.gates.push((self.registers.snapshot(), label));
        Ok(())
    }

    /// Ends a branch. The path through the branch needs no moves: the path around it moves values to the same places.
    pub(crate) fn join(&mut self, parts: &[Item]) -> Result {
        let Some((snapshot, skipped)) = self.gates.pop() else { unreachable!("every join has its gate") };
        let mut results = Vec::new();
        for part in parts {
            let Item::Join { inside, otherwise, to } = part else { continue };
            for ((inside, otherwise), to) in inside.iter().zip(otherwise).zip(to) {
                let register = self.value(*inside)?;
                if self.registers.is_last(*inside, self.at) && self.registers.find(*inside).is_some() {
                    self.registers.rename(*inside, *to);
                } else {
                    let copy = self.take()?;
                    self.asm.copy(copy, register)?;
                    self.registers.hold(copy, Holder::Value(*to));
                }
                results.push((*to, *otherwise));
                self.made.push(*to);
            }
        }
        let moves = self.registers.resolve(&snapshot, self.at, &results);
        let mut end = self.asm.label();
        self.asm.place(&mut end)?;
        self.skips.push(Skip { skipped, moves, end });
        Ok(())
    }

    /// Emits the paths around branches, outside of the loop.
    pub(crate) fn around(&mut self) -> Result {
        for Skip { mut skipped, moves, end } in std::mem::take(&mut self.skips) {
            self.asm.place(&mut skipped)?;
            for step in moves {
                match step {
                    Move::Store(register, slot) => self.asm.store(VectorPlace::Slot(slot), register)?,
                    Move::Load(register, slot) => self.asm.load(register, VectorPlace::Slot(slot))?,
                    Move::Fetch(register, source) => self.fetch(register, source)?,
                }
            }
            self.asm.jump(end)?;
        }
        Ok(())
    }
}

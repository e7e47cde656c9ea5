//! Translation of weights that sum to 1, and of blends by them, which are computed in f64.

use crate::assembler::{Reg, Result, SCRATCH_MASK, VectorPlace};
use crate::operations::{BinaryInstruction, Compare};
use crate::program::Value;
use crate::translate::Translator;

impl Translator<'_> {
    /// Blends three channels: Σ wᵢ·cᵢ, in f64.
    pub(crate) fn blend(&mut self, colors: &[[Value; 3]], weights: &[Value], to: [Value; 3]) -> Result {
        let sums: [Reg; 6] = self.take_all()?;
        for sum in sums {
            self.asm.zero(sum)?;
        }
        let [low, high, value_low, value_high] = self.take_all()?;
        for (color, weight) in colors.iter().zip(weights) {
            let x = self.value(*weight)?;
            self.asm.widen(low, high, x)?;
            self.give_back(&[x]);
            for (channel, value) in color.iter().enumerate() {
                let (sum_low, sum_high) = (sums[2 * channel], sums[2 * channel + 1]);
                if let Some(constant) = self.constant(*value).filter(|constant| constant.is_finite()) {
                    // A finite number times 0 adds nothing.
                    self.asm.binary_double(BinaryInstruction::FmaDouble, sum_low, low, constant.into())?;
                    self.asm.binary_double(BinaryInstruction::FmaDouble, sum_high, high, constant.into())?;
                    continue;
                }
                let x = self.value(*value)?;
                self.asm.widen(value_low, value_high, x)?;
                self.give_back(&[x]);
                for (sum, weight, value) in [(sum_low, low, value_low), (sum_high, high, value_high)] {
                    if self.asm.wide {
                        self.asm.compare_double_zero(SCRATCH_MASK, Compare::NotEqual, weight)?;
                        self.asm.fma_double_where(sum, SCRATCH_MASK, weight, value)?;
                    } else {
                        // The product is exact.
                        self.asm.binary(BinaryInstruction::MulDouble, value, value, weight)?;
                        let mask = self.take()?;
                        self.asm.compare_double_zero(mask, Compare::NotEqual, weight)?;
                        self.asm.and(value, value, mask)?;
                        self.asm.binary(BinaryInstruction::AddDouble, sum, sum, value)?;
                        self.give_back(&[mask]);
                    }
                }
            }
        }
        for (channel, value) in to.into_iter().enumerate() {
            let (sum_low, sum_high) = (sums[2 * channel], sums[2 * channel + 1]);
            self.asm.narrow(sum_low, sum_low, sum_high)?;
            self.define(value, sum_low);
        }
        Ok(())
    }

    /// Rounds weights to multiples of 2⁻²⁴; the residual goes to the first of the largest.
    pub(crate) fn partition(&mut self, weights: &[Value], to: &[Value]) -> Result {
        // Indices of weights are stored as the bits of f32, and compared as integers.
        let number = |index: usize| f32::from_bits(index as u32);
        let [best, owner, big, sum_low, sum_high] = self.take_all()?;
        self.asm.fill(best, f32::NEG_INFINITY)?;
        for register in [owner, big, sum_low, sum_high] {
            self.asm.zero(register)?;
        }
        let [low, high, rounded, spare] = self.take_all()?;
        let mut slots = Vec::with_capacity(weights.len());
        for (index, weight) in weights.iter().enumerate() {
            let x = self.value(*weight)?;
            self.round(rounded, x, spare)?;
            let mask = self.asm.scratch(spare);
            self.asm.compare(mask, Compare::Greater, x, best)?;
            self.asm.select_constant(owner, mask, owner, number(index))?;
            self.asm.select(best, mask, best, x)?;
            self.asm.select(big, mask, big, rounded)?;
            self.give_back(&[x]);
            self.asm.widen(low, high, rounded)?;
            self.asm.binary(BinaryInstruction::AddDouble, sum_low, sum_low, low)?;
            self.asm.binary(BinaryInstruction::AddDouble, sum_high, sum_high, high)?;
            let slot = self.registers.new_slot();
            self.asm.store(VectorPlace::Slot(slot), rounded)?;
            slots.push(slot);
        }
        self.asm.widen(low, high, big)?;
        for (half, sum) in [(low, sum_low), (high, sum_high)] {
            self.asm.fill_double(spare, 1.0)?;
            self.asm.binary(BinaryInstruction::SubDouble, sum, spare, sum)?;
            self.asm.binary(BinaryInstruction::AddDouble, half, half, sum)?;
        }
        self.asm.narrow(big, low, high)?;
        self.give_back(&[best, rounded, sum_low, sum_high, high]);
        for ((index, value), slot) in to.iter().enumerate().zip(slots) {
            let d = self.take()?;
            self.asm.load(d, VectorPlace::Slot(slot))?;
            let mask = self.asm.scratch(low);
            self.asm.equals(mask, owner, number(index))?;
            self.asm.select(d, mask, d, big)?;
            // From now on the weight has its slot if its register is needed.
            self.asm.store(VectorPlace::Slot(slot), d)?;
            self.registers.set_slot(*value, slot);
            self.define(*value, d);
            self.registers.give_back(d);
        }
        Ok(())
    }

    /// Computes `round_weight`: no change from ½ up, below ½ by adding and subtracting ½.
    fn round(&mut self, to: Reg, x: Reg, spare: Reg) -> Result {
        self.asm.binary_constant(BinaryInstruction::Add, to, x, 0.5)?;
        self.asm.binary_constant(BinaryInstruction::Sub, to, to, 0.5)?;
        let mask = self.asm.scratch(spare);
        self.asm.compare_constant(mask, Compare::AtLeast, x, 0.5)?;
        self.asm.select(to, mask, to, x)
    }

    pub(crate) fn see_sum(&mut self, weights: &[Value], state: u32) -> Result {
        let [sum_low, sum_high, low, high] = self.take_all()?;
        self.asm.zero(sum_low)?;
        self.asm.zero(sum_high)?;
        for weight in weights {
            let x = self.value(*weight)?;
            self.asm.widen(low, high, x)?;
            self.give_back(&[x]);
            self.asm.binary(BinaryInstruction::AddDouble, sum_low, sum_low, low)?;
            self.asm.binary(BinaryInstruction::AddDouble, sum_high, sum_high, high)?;
        }
        for (sum, state) in [(sum_low, state), (sum_high, state + 1)] {
            self.asm.binary_double(BinaryInstruction::SubDouble, sum, sum, 1.0)?;
            self.asm.magnitude(sum)?;
            self.asm.load(high, VectorPlace::State(state))?;
            // If either operand is NaN, the instruction returns the second one, here `sum`.
            self.asm.binary(BinaryInstruction::MaxDouble, high, high, sum)?;
            self.asm.store(VectorPlace::State(state), high)?;
        }
        Ok(())
    }
}

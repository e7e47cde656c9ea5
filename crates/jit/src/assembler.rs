//! Emits instructions by their purpose, for both vector widths.

use crate::operations::{BinaryInstruction, Compare, instruction};
use iced_x86::IcedError;
use iced_x86::code_asm::*;
use std::collections::HashMap;

pub(crate) type Result<T = ()> = std::result::Result<T, IcedError>;

/// Number of a vector register or of a mask: wide code has mask registers, in narrow code masks are in vector
/// registers.
pub(crate) type Reg = u8;

const ZMM: [AsmRegisterZmm; 32] = [
    zmm0, zmm1, zmm2, zmm3, zmm4, zmm5, zmm6, zmm7, zmm8, zmm9, zmm10, zmm11, zmm12, zmm13, zmm14, zmm15, zmm16, zmm17,
    zmm18, zmm19, zmm20, zmm21, zmm22, zmm23, zmm24, zmm25, zmm26, zmm27, zmm28, zmm29, zmm30, zmm31,
];
const YMM: [AsmRegisterYmm; 32] = [
    ymm0, ymm1, ymm2, ymm3, ymm4, ymm5, ymm6, ymm7, ymm8, ymm9, ymm10, ymm11, ymm12, ymm13, ymm14, ymm15, ymm16, ymm17,
    ymm18, ymm19, ymm20, ymm21, ymm22, ymm23, ymm24, ymm25, ymm26, ymm27, ymm28, ymm29, ymm30, ymm31,
];
const XMM: [AsmRegisterXmm; 16] =
    [xmm0, xmm1, xmm2, xmm3, xmm4, xmm5, xmm6, xmm7, xmm8, xmm9, xmm10, xmm11, xmm12, xmm13, xmm14, xmm15];
const MASKS: [AsmRegisterK; 8] = [k0, k1, k2, k3, k4, k5, k6, k7];

/// Mask register for short-lived masks, and another one, which cannot serve as a write mask.
pub(crate) const SCRATCH_MASK: Reg = 7;
pub(crate) const OTHER_MASK: Reg = 0;

/// Registers for pointers to rows; further pointers are loaded when they are needed.
const POINTERS: [AsmRegister64; 8] = [r10, r11, rbx, rbp, r12, r13, r14, r15];
/// Registers that must be saved for the caller.
const SAVED: [AsmRegister64; 6] = [rbx, rbp, r12, r13, r14, r15];
/// Distance of prefetches in bytes, the same as in the interpreter.
const AHEAD: i32 = 1024;

/// A vector in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum VectorPlace {
    /// Current samples of a row: its number in the table, and the index among the vectors processed side by side.
    Row(usize, u32),
    State(u32),
    Slot(u32),
}

/// Emits the loop. `rdi` has the table of rows, `rsi` the constants, `rdx` the state, `rcx` the slots, `r8` the bytes
/// per row, `r9` the position of the loop.
pub(crate) struct Assembler {
    a: CodeAssembler,
    /// Whether vectors have sixteen lanes rather than eight.
    pub(crate) wide: bool,
    pool: Vec<u32>,
    known: HashMap<Vec<u32>, i32>,
    rows: usize,
    /// Number of vectors processed side by side.
    parts: u32,
    top: CodeLabel,
}

/// Emits one instruction for either width.
macro_rules! both {
    ($self:ident.$method:ident($($operand:expr),*)) => {
        if $self.wide {
            $self.a.$method($(ZMM[$operand as usize]),*)
        } else {
            $self.a.$method($(YMM[$operand as usize]),*)
        }
    };
}

impl Assembler {
    /// Starts a loop over a number of rows that processes `parts` vectors side by side.
    pub(crate) fn new(wide: bool, parts: u32, rows: usize) -> Result<Self> {
        let mut a = CodeAssembler::new(64)?;
        for register in SAVED {
            a.push(register)?;
        }
        for (index, pointer) in POINTERS.iter().enumerate().take(rows) {
            a.mov(*pointer, qword_ptr(rdi + 8 * index as i32))?;
        }
        a.xor(r9d, r9d)?;
        let top = a.create_label();
        Ok(Self { a, wide, pool: Vec::new(), known: HashMap::new(), rows, parts, top })
    }

    /// Starts the loop body.
    pub(crate) fn begin(&mut self) -> Result {
        self.a.set_label(&mut self.top)
    }

    /// Ends the loop body.
    pub(crate) fn repeat(&mut self) -> Result {
        self.a.add(r9, self.bytes() * self.parts as i32)?;
        self.a.cmp(r9, r8)?;
        self.a.jb(self.top)
    }

    /// Returns a register for a short-lived mask: in narrow code the given vector register.
    pub(crate) fn scratch(&self, vector: Reg) -> Reg {
        if self.wide { SCRATCH_MASK } else { vector }
    }

    /// Returns the bytes per vector.
    fn bytes(&self) -> i32 {
        if self.wide { 64 } else { 32 }
    }

    /// Emits the return to the caller.
    pub(crate) fn leave(&mut self) -> Result {
        self.a.vzeroupper()?;
        for register in SAVED.into_iter().rev() {
            self.a.pop(register)?;
        }
        self.a.ret()
    }

    /// Returns the code and its constants.
    pub(crate) fn finish(mut self) -> Result<(Vec<u8>, Vec<u32>)> {
        Ok((self.a.assemble(0)?, self.pool))
    }

    /// Returns the offset of a constant: stored once for wide code, which broadcasts it, or in all lanes for narrow
    /// code.
    fn constant(&mut self, bits: &[u32]) -> i32 {
        let (pool, copies) = (&mut self.pool, if self.wide { 1 } else { 8 / bits.len() });
        *self.known.entry(bits.to_vec()).or_insert_with(|| {
            // Doubles start at even indices.
            if pool.len() % bits.len() == 1 {
                pool.push(0);
            }
            let at = 4 * pool.len() as i32;
            (0..copies).for_each(|_| pool.extend(bits));
            at
        })
    }

    /// Returns an f32 constant in memory as an operand.
    fn single(&mut self, value: f32) -> AsmMemoryOperand {
        let at = rsi + self.constant(&[value.to_bits()]);
        if self.wide { dword_bcst(at) } else { ymmword_ptr(at) }
    }

    /// Returns an f64 constant in memory as an operand.
    fn double(&mut self, value: f64) -> AsmMemoryOperand {
        let bits = value.to_bits();
        let at = rsi + self.constant(&[bits as u32, (bits >> 32) as u32]);
        if self.wide { qword_bcst(at) } else { ymmword_ptr(at) }
    }

    /// Returns a register with the address of a row.
    fn row(&mut self, row: usize) -> Result<AsmRegister64> {
        debug_assert!(row < self.rows);
        Ok(match POINTERS.get(row) {
            Some(pointer) => *pointer,
            None => {
                self.a.mov(rax, qword_ptr(rdi + 8 * row as i32))?;
                rax
            }
        })
    }

    fn address(&mut self, place: VectorPlace) -> Result<AsmMemoryOperand> {
        let size = |wide: bool| if wide { zmmword_ptr } else { ymmword_ptr };
        Ok(match place {
            VectorPlace::Row(row, part) => {
                let pointer = self.row(row)?;
                size(self.wide)(pointer + r9 + self.bytes() * part as i32)
            }
            VectorPlace::State(index) => size(self.wide)(rdx + 64 * index as i32),
            VectorPlace::Slot(index) => size(self.wide)(rcx + 64 * index as i32),
        })
    }

    pub(crate) fn load(&mut self, to: Reg, place: VectorPlace) -> Result {
        let from = self.address(place)?;
        if self.wide { self.a.vmovups(ZMM[to as usize], from) } else { self.a.vmovups(YMM[to as usize], from) }
    }

    pub(crate) fn store(&mut self, place: VectorPlace, from: Reg) -> Result {
        let to = self.address(place)?;
        if self.wide { self.a.vmovups(to, ZMM[from as usize]) } else { self.a.vmovups(to, YMM[from as usize]) }
    }

    /// Emits a store around the cache.
    pub(crate) fn stream(&mut self, place: VectorPlace, from: Reg) -> Result {
        let to = self.address(place)?;
        if self.wide { self.a.vmovntps(to, ZMM[from as usize]) } else { self.a.vmovntps(to, YMM[from as usize]) }
    }

    /// Prefetches samples of a row.
    pub(crate) fn fetch(&mut self, row: usize, part: u32) -> Result {
        let pointer = self.row(row)?;
        self.a.prefetcht0(byte_ptr(pointer + r9 + AHEAD + self.bytes() * part as i32))
    }

    pub(crate) fn copy(&mut self, to: Reg, from: Reg) -> Result {
        both!(self.vmovaps(to, from))
    }

    pub(crate) fn zero(&mut self, to: Reg) -> Result {
        if self.wide {
            let to = ZMM[to as usize];
            self.a.vpxord(to, to, to)
        } else {
            let to = YMM[to as usize];
            self.a.vxorps(to, to, to)
        }
    }

    /// Loads the single number of a line into all lanes.
    pub(crate) fn line(&mut self, to: Reg, row: usize) -> Result {
        let from = dword_ptr(self.row(row)? + 0);
        if self.wide {
            self.a.vbroadcastss(ZMM[to as usize], from)
        } else {
            self.a.vbroadcastss(YMM[to as usize], from)
        }
    }

    /// Loads a constant into all lanes.
    pub(crate) fn fill(&mut self, to: Reg, value: f32) -> Result {
        let at = rsi + self.constant(&[value.to_bits()]);
        if self.wide {
            self.a.vbroadcastss(ZMM[to as usize], dword_ptr(at))
        } else {
            self.a.vmovups(YMM[to as usize], ymmword_ptr(at))
        }
    }

    pub(crate) fn fill_double(&mut self, to: Reg, value: f64) -> Result {
        let bits = value.to_bits();
        let at = rsi + self.constant(&[bits as u32, (bits >> 32) as u32]);
        if self.wide {
            self.a.vbroadcastsd(ZMM[to as usize], qword_ptr(at))
        } else {
            self.a.vmovups(YMM[to as usize], ymmword_ptr(at))
        }
    }

    /// Loads one constant into the lanes of a mask and another into the other lanes. Narrow code uses bit operations,
    /// since a select would occupy the multipliers.
    pub(crate) fn choose(&mut self, to: Reg, mask: Reg, others: f32, lanes: f32) -> Result {
        if self.wide {
            if others.to_bits() != 0 {
                self.fill(to, others)?;
                return self.select_constant(to, mask, to, lanes);
            }
            let from = dword_ptr(rsi + self.constant(&[lanes.to_bits()]));
            return self.a.vbroadcastss(masked(to, mask).z(), from);
        }
        let change = self.single(f32::from_bits(others.to_bits() ^ lanes.to_bits()));
        self.a.vandps(YMM[to as usize], YMM[mask as usize], change)?;
        if others.to_bits() != 0 {
            let from = self.single(others);
            self.a.vxorps(YMM[to as usize], YMM[to as usize], from)?;
        }
        Ok(())
    }

    /// Selects b in the lanes of a mask, else a.
    pub(crate) fn select(&mut self, to: Reg, mask: Reg, a: Reg, b: Reg) -> Result {
        if self.wide {
            self.a.vblendmps(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
        } else {
            self.a.vblendvps(YMM[to as usize], YMM[a as usize], YMM[b as usize], YMM[mask as usize])
        }
    }

    /// Selects a constant in the lanes of a mask, else a.
    pub(crate) fn select_constant(&mut self, to: Reg, mask: Reg, a: Reg, value: f32) -> Result {
        let from = self.single(value);
        if self.wide {
            self.a.vblendmps(masked(to, mask), ZMM[a as usize], from)
        } else {
            self.a.vblendvps(YMM[to as usize], YMM[a as usize], from, YMM[mask as usize])
        }
    }

    /// Emits a bitwise and. Narrow code only.
    pub(crate) fn and(&mut self, to: Reg, a: Reg, b: Reg) -> Result {
        self.a.vandps(YMM[to as usize], YMM[a as usize], YMM[b as usize])
    }

    pub(crate) fn binary(&mut self, op: BinaryInstruction, to: Reg, a: Reg, b: Reg) -> Result {
        let (to, a, b) = (to as usize, a as usize, b as usize);
        if self.wide {
            instruction!(self.a, op, ZMM[to], ZMM[a], ZMM[b])
        } else {
            instruction!(self.a, op, YMM[to], YMM[a], YMM[b])
        }
    }

    /// Emits an operation with a memory operand as the second operand.
    fn binary_address(&mut self, op: BinaryInstruction, to: Reg, a: Reg, b: AsmMemoryOperand) -> Result {
        let (to, a) = (to as usize, a as usize);
        if self.wide {
            instruction!(self.a, op, ZMM[to], ZMM[a], b)
        } else {
            instruction!(self.a, op, YMM[to], YMM[a], b)
        }
    }

    /// Emits an operation with an f32 constant as the second operand.
    pub(crate) fn binary_constant(&mut self, op: BinaryInstruction, to: Reg, a: Reg, value: f32) -> Result {
        debug_assert!(!op.is_double());
        let from = self.single(value);
        self.binary_address(op, to, a, from)
    }

    /// Emits an operation with an f64 constant as the second operand.
    pub(crate) fn binary_double(&mut self, op: BinaryInstruction, to: Reg, a: Reg, value: f64) -> Result {
        debug_assert!(op.is_double());
        let from = self.double(value);
        self.binary_address(op, to, a, from)
    }

    /// Emits a − b in the lanes of a mask; other lanes do not change. Wide code only.
    pub(crate) fn sub_where(&mut self, to: Reg, mask: Reg, a: Reg, b: Reg) -> Result {
        self.a.vsubps(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
    }

    /// Emits d + a·b in the lanes of a mask, in f64. Wide code only.
    pub(crate) fn fma_double_where(&mut self, to: Reg, mask: Reg, a: Reg, b: Reg) -> Result {
        self.a.vfmadd231pd(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
    }

    /// Emits an operation with a vector in memory as the second operand.
    pub(crate) fn binary_memory(&mut self, op: BinaryInstruction, to: Reg, a: Reg, place: VectorPlace) -> Result {
        let from = self.address(place)?;
        self.binary_address(op, to, a, from)
    }

    /// Shifts all lanes left by one bit.
    pub(crate) fn shift(&mut self, to: Reg, from: Reg) -> Result {
        if self.wide {
            self.a.vpslld(ZMM[to as usize], ZMM[from as usize], 1)
        } else {
            self.a.vpslld(YMM[to as usize], YMM[from as usize], 1)
        }
    }

    /// Computes |x| in f64.
    pub(crate) fn magnitude(&mut self, of: Reg) -> Result {
        let from = self.double(f64::from_bits(u64::MAX >> 1));
        if self.wide {
            self.a.vpandq(ZMM[of as usize], ZMM[of as usize], from)
        } else {
            self.a.vandpd(YMM[of as usize], YMM[of as usize], from)
        }
    }

    /// Compares two vectors into a mask.
    pub(crate) fn compare(&mut self, mask: Reg, how: Compare, a: Reg, b: Reg) -> Result {
        if self.wide {
            self.a.vcmpps(MASKS[mask as usize], ZMM[a as usize], ZMM[b as usize], how as i32)
        } else {
            self.a.vcmpps(YMM[mask as usize], YMM[a as usize], YMM[b as usize], how as i32)
        }
    }

    /// Compares a vector with a constant into a mask.
    pub(crate) fn compare_constant(&mut self, mask: Reg, how: Compare, a: Reg, value: f32) -> Result {
        let from = self.single(value);
        if self.wide {
            self.a.vcmpps(MASKS[mask as usize], ZMM[a as usize], from, how as i32)
        } else {
            self.a.vcmpps(YMM[mask as usize], YMM[a as usize], from, how as i32)
        }
    }

    /// Compares f64 lanes with 0 into a mask.
    pub(crate) fn compare_double_zero(&mut self, mask: Reg, how: Compare, a: Reg) -> Result {
        let from = self.double(0.0);
        if self.wide {
            self.a.vcmppd(MASKS[mask as usize], ZMM[a as usize], from, how as i32)
        } else {
            self.a.vcmppd(YMM[mask as usize], YMM[a as usize], from, how as i32)
        }
    }

    /// Compares the bits of all lanes with those of a constant into a mask.
    pub(crate) fn equals(&mut self, mask: Reg, a: Reg, value: f32) -> Result {
        let from = self.single(value);
        if self.wide {
            self.a.vpcmpeqd(MASKS[mask as usize], ZMM[a as usize], from)
        } else {
            self.a.vpcmpeqd(YMM[mask as usize], YMM[a as usize], from)
        }
    }

    /// Intersects a mask with another mask.
    pub(crate) fn both(&mut self, mask: Reg, other: Reg) -> Result {
        if self.wide {
            self.a.kandw(MASKS[mask as usize], MASKS[mask as usize], MASKS[other as usize])
        } else {
            self.and(mask, mask, other)
        }
    }

    pub(crate) fn label(&mut self) -> CodeLabel {
        self.a.create_label()
    }

    pub(crate) fn place(&mut self, label: &mut CodeLabel) -> Result {
        self.a.set_label(label)?;
        // One instruction cannot have two labels.
        self.a.nop()
    }

    pub(crate) fn jump(&mut self, to: CodeLabel) -> Result {
        self.a.jmp(to)
    }

    /// Jumps if a mask includes all lanes.
    pub(crate) fn jump_if_all(&mut self, found: Reg, to: CodeLabel) -> Result {
        if self.wide {
            self.a.kortestw(MASKS[found as usize], MASKS[found as usize])?;
            return self.a.jb(to);
        }
        self.a.vmovmskps(eax, YMM[found as usize])?;
        self.a.cmp(eax, 0xff)?;
        self.a.je(to)
    }

    /// Converts the lower and the upper half of the lanes to f64. `high` must not be `from`.
    pub(crate) fn widen(&mut self, low: Reg, high: Reg, from: Reg) -> Result {
        if self.wide {
            self.a.vextractf64x4(YMM[high as usize], ZMM[from as usize], 1)?;
            self.a.vcvtps2pd(ZMM[high as usize], YMM[high as usize])?;
            self.a.vcvtps2pd(ZMM[low as usize], YMM[from as usize])
        } else {
            self.a.vextractf128(XMM[high as usize], YMM[from as usize], 1)?;
            self.a.vcvtps2pd(YMM[high as usize], XMM[high as usize])?;
            self.a.vcvtps2pd(YMM[low as usize], XMM[from as usize])
        }
    }

    /// Rounds two halves to f32 and joins them; overwrites `low` and `high`.
    pub(crate) fn narrow(&mut self, to: Reg, low: Reg, high: Reg) -> Result {
        if self.wide {
            self.a.vcvtpd2ps(YMM[low as usize], ZMM[low as usize])?;
            self.a.vcvtpd2ps(YMM[high as usize], ZMM[high as usize])?;
            self.a.vinsertf64x4(ZMM[to as usize], ZMM[low as usize], YMM[high as usize], 1)
        } else {
            self.a.vcvtpd2ps(XMM[low as usize], YMM[low as usize])?;
            self.a.vcvtpd2ps(XMM[high as usize], YMM[high as usize])?;
            self.a.vinsertf128(YMM[to as usize], YMM[low as usize], XMM[high as usize], 1)
        }
    }
}

/// Returns a register as a destination with a write mask.
fn masked(register: Reg, mask: Reg) -> AsmRegisterZmm {
    let register = ZMM[register as usize];
    match mask {
        1 => register.k1(),
        2 => register.k2(),
        3 => register.k3(),
        4 => register.k4(),
        5 => register.k5(),
        6 => register.k6(),
        7 => register.k7(),
        _ => unreachable!("masks are 1 to 7"),
    }
}

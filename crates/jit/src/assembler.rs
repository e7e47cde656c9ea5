//! Instructions by what they do, for both widths of vector.

use crate::operations::{Compare, Two, instruction};
use iced_x86::IcedError;
use iced_x86::code_asm::*;
use std::collections::HashMap;

pub(crate) type Result<T = ()> = std::result::Result<T, IcedError>;

/// A vector register, by number.
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

/// The mask register that nothing keeps.
pub(crate) const SCRATCH_MASK: u8 = 7;

/// Registers for pointers to rows; further ones are fetched when they are needed.
const POINTERS: [AsmRegister64; 8] = [r10, r11, rbx, rbp, r12, r13, r14, r15];
/// Those of them that belong to the caller.
const SAVED: [AsmRegister64; 6] = [rbx, rbp, r12, r13, r14, r15];
/// Bytes by which rows are fetched ahead, as the interpreter does.
const AHEAD: i32 = 1024;

/// A vector in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// The samples at hand of a row: its number in the table, and which of the vectors worked on side by side.
    Row(usize, u32),
    State(u32),
    Slot(u32),
}

/// Writes the loop. `rdi` holds the table of rows, `rsi` the constants, `rdx` the state, `rcx` the slots, `r8` the bytes
/// of a row, `r9` how far the loop is.
pub(crate) struct Assembler {
    a: CodeAssembler,
    /// Sixteen lanes, or eight.
    pub(crate) wide: bool,
    pool: Vec<u32>,
    known: HashMap<(u64, bool), i32>,
    rows: usize,
    /// Vectors worked on side by side.
    parts: u32,
    top: CodeLabel,
}

/// One instruction for both widths.
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
    /// Begins a loop over so many rows that works on `parts` vectors side by side.
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

    /// Begins what is repeated.
    pub(crate) fn begin(&mut self) -> Result {
        self.a.set_label(&mut self.top)
    }

    /// Ends what is repeated.
    pub(crate) fn repeat(&mut self) -> Result {
        self.a.add(r9, self.bytes() * self.parts as i32)?;
        self.a.cmp(r9, r8)?;
        self.a.jb(self.top)
    }

    /// Bytes of a vector.
    fn bytes(&self) -> i32 {
        if self.wide { 64 } else { 32 }
    }

    /// Returns to the caller.
    pub(crate) fn leave(&mut self) -> Result {
        self.a.vzeroupper()?;
        for register in SAVED.into_iter().rev() {
            self.a.pop(register)?;
        }
        self.a.ret()
    }

    /// The code, and its constants.
    pub(crate) fn finish(mut self) -> Result<(Vec<u8>, Vec<u32>)> {
        Ok((self.a.assemble(0)?, self.pool))
    }

    /// Where a constant lies.
    fn constant(&mut self, value: f32) -> i32 {
        let bits = value.to_bits();
        let pool = &mut self.pool;
        *self.known.entry((bits.into(), false)).or_insert_with(|| {
            pool.push(bits);
            4 * (pool.len() as i32 - 1)
        })
    }

    fn double(&mut self, value: f64) -> i32 {
        let bits = value.to_bits();
        let pool = &mut self.pool;
        *self.known.entry((bits, true)).or_insert_with(|| {
            if pool.len() % 2 == 1 {
                pool.push(0);
            }
            pool.extend([bits as u32, (bits >> 32) as u32]);
            4 * (pool.len() as i32 - 2)
        })
    }

    /// The register that holds a row's address.
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

    fn address(&mut self, place: Place) -> Result<AsmMemoryOperand> {
        let size = |wide: bool| if wide { zmmword_ptr } else { ymmword_ptr };
        Ok(match place {
            Place::Row(row, part) => {
                let pointer = self.row(row)?;
                size(self.wide)(pointer + r9 + self.bytes() * part as i32)
            }
            Place::State(index) => size(self.wide)(rdx + 64 * index as i32),
            Place::Slot(index) => size(self.wide)(rcx + 64 * index as i32),
        })
    }

    pub(crate) fn load(&mut self, to: Reg, place: Place) -> Result {
        let from = self.address(place)?;
        if self.wide { self.a.vmovups(ZMM[to as usize], from) } else { self.a.vmovups(YMM[to as usize], from) }
    }

    pub(crate) fn store(&mut self, place: Place, from: Reg) -> Result {
        let to = self.address(place)?;
        if self.wide { self.a.vmovups(to, ZMM[from as usize]) } else { self.a.vmovups(to, YMM[from as usize]) }
    }

    /// Stores around the cache.
    pub(crate) fn stream(&mut self, place: Place, from: Reg) -> Result {
        let to = self.address(place)?;
        if self.wide { self.a.vmovntps(to, ZMM[from as usize]) } else { self.a.vmovntps(to, YMM[from as usize]) }
    }

    /// Asks for a row's samples ahead.
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

    /// The one number of a line, in all lanes.
    pub(crate) fn line(&mut self, to: Reg, row: usize) -> Result {
        let from = dword_ptr(self.row(row)? + 0);
        if self.wide {
            self.a.vbroadcastss(ZMM[to as usize], from)
        } else {
            self.a.vbroadcastss(YMM[to as usize], from)
        }
    }

    /// A constant in all lanes.
    pub(crate) fn fill(&mut self, to: Reg, value: f32) -> Result {
        let from = dword_ptr(rsi + self.constant(value));
        if self.wide {
            self.a.vbroadcastss(ZMM[to as usize], from)
        } else {
            self.a.vbroadcastss(YMM[to as usize], from)
        }
    }

    pub(crate) fn fill_double(&mut self, to: Reg, value: f64) -> Result {
        let from = qword_ptr(rsi + self.double(value));
        if self.wide {
            self.a.vbroadcastsd(ZMM[to as usize], from)
        } else {
            self.a.vbroadcastsd(YMM[to as usize], from)
        }
    }

    /// A constant in the lanes of a mask, 0 in the others. Wide only.
    pub(crate) fn fill_masked(&mut self, to: Reg, mask: u8, value: f32) -> Result {
        let from = dword_ptr(rsi + self.constant(value));
        self.a.vbroadcastss(masked(to, mask).z(), from)
    }

    /// A constant in the lanes of a mask; the others stay. Wide only.
    pub(crate) fn fill_where(&mut self, to: Reg, mask: u8, value: f32) -> Result {
        let from = dword_ptr(rsi + self.constant(value));
        self.a.vbroadcastss(masked(to, mask), from)
    }

    /// The lanes of a mask; the others stay. Wide only.
    pub(crate) fn copy_where(&mut self, to: Reg, mask: u8, from: Reg) -> Result {
        self.a.vmovaps(masked(to, mask), ZMM[from as usize])
    }

    /// b in the lanes of a mask, else a. Wide only.
    pub(crate) fn select(&mut self, to: Reg, mask: u8, a: Reg, b: Reg) -> Result {
        self.a.vblendmps(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
    }

    /// A constant in the lanes of a mask, else a. Wide only.
    pub(crate) fn select_constant(&mut self, to: Reg, mask: u8, a: Reg, value: f32) -> Result {
        let from = dword_bcst(rsi + self.constant(value));
        self.a.vblendmps(masked(to, mask), ZMM[a as usize], from)
    }

    /// b where the sign of the mask is set, else a. Narrow only.
    pub(crate) fn blend(&mut self, to: Reg, mask: Reg, a: Reg, b: Reg) -> Result {
        self.a.vblendvps(YMM[to as usize], YMM[a as usize], YMM[b as usize], YMM[mask as usize])
    }

    /// Narrow only.
    pub(crate) fn and(&mut self, to: Reg, a: Reg, b: Reg) -> Result {
        self.a.vandps(YMM[to as usize], YMM[a as usize], YMM[b as usize])
    }

    pub(crate) fn two(&mut self, op: Two, to: Reg, a: Reg, b: Reg) -> Result {
        let (to, a, b) = (to as usize, a as usize, b as usize);
        if self.wide {
            instruction!(self.a, op, ZMM[to], ZMM[a], ZMM[b])
        } else {
            instruction!(self.a, op, YMM[to], YMM[a], YMM[b])
        }
    }

    /// With memory as the second operand.
    fn two_address(&mut self, op: Two, to: Reg, a: Reg, b: AsmMemoryOperand) -> Result {
        let (to, a) = (to as usize, a as usize);
        if self.wide {
            instruction!(self.a, op, ZMM[to], ZMM[a], b)
        } else {
            instruction!(self.a, op, YMM[to], YMM[a], b)
        }
    }

    /// With a constant as the second operand; `spare` is lost (narrow vectors have to load it there).
    pub(crate) fn two_constant(&mut self, op: Two, to: Reg, a: Reg, value: f32, spare: Reg) -> Result {
        debug_assert!(!op.is_double());
        if self.wide {
            let from = dword_bcst(rsi + self.constant(value));
            self.two_address(op, to, a, from)
        } else {
            self.fill(spare, value)?;
            self.two(op, to, a, spare)
        }
    }

    /// The same in f64.
    pub(crate) fn two_double(&mut self, op: Two, to: Reg, a: Reg, value: f64, spare: Reg) -> Result {
        debug_assert!(op.is_double());
        if self.wide {
            let from = qword_bcst(rsi + self.double(value));
            self.two_address(op, to, a, from)
        } else {
            self.fill_double(spare, value)?;
            self.two(op, to, a, spare)
        }
    }

    /// a − b in the lanes of a mask; the others stay. Wide only.
    pub(crate) fn sub_where(&mut self, to: Reg, mask: u8, a: Reg, b: Reg) -> Result {
        self.a.vsubps(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
    }

    /// d + a·b in the lanes of a mask, in f64. Wide only.
    pub(crate) fn fma_double_where(&mut self, to: Reg, mask: u8, a: Reg, b: Reg) -> Result {
        self.a.vfmadd231pd(masked(to, mask), ZMM[a as usize], ZMM[b as usize])
    }

    /// With a vector in memory as the second operand.
    pub(crate) fn two_memory(&mut self, op: Two, to: Reg, a: Reg, place: Place) -> Result {
        let from = self.address(place)?;
        self.two_address(op, to, a, from)
    }

    /// All lanes shifted left by one bit.
    pub(crate) fn shift(&mut self, to: Reg, from: Reg) -> Result {
        if self.wide {
            self.a.vpslld(ZMM[to as usize], ZMM[from as usize], 1)
        } else {
            self.a.vpslld(YMM[to as usize], YMM[from as usize], 1)
        }
    }

    /// |x| in f64; `spare` is lost.
    pub(crate) fn magnitude(&mut self, of: Reg, spare: Reg) -> Result {
        let mask = f64::from_bits(u64::MAX >> 1);
        if self.wide {
            let from = qword_bcst(rsi + self.double(mask));
            self.a.vpandq(ZMM[of as usize], ZMM[of as usize], from)
        } else {
            self.fill_double(spare, mask)?;
            self.a.vandpd(YMM[of as usize], YMM[of as usize], YMM[spare as usize])
        }
    }

    /// Compares with a constant into a mask register. Wide only.
    pub(crate) fn compare_constant(&mut self, mask: u8, how: Compare, a: Reg, value: f32) -> Result {
        let from = dword_bcst(rsi + self.constant(value));
        self.a.vcmpps(MASKS[mask as usize], ZMM[a as usize], from, how as i32)
    }

    /// Compares two vectors into a mask register. Wide only.
    pub(crate) fn compare(&mut self, mask: u8, how: Compare, a: Reg, b: Reg) -> Result {
        self.a.vcmpps(MASKS[mask as usize], ZMM[a as usize], ZMM[b as usize], how as i32)
    }

    /// Compares f64 with 0 into a mask register. Wide only.
    pub(crate) fn compare_double_zero(&mut self, mask: u8, how: Compare, a: Reg) -> Result {
        let from = qword_bcst(rsi + self.double(0.0));
        self.a.vcmppd(MASKS[mask as usize], ZMM[a as usize], from, how as i32)
    }

    /// Compares two vectors into one of all ones or zeros. Narrow only.
    pub(crate) fn compare_narrow(&mut self, to: Reg, how: Compare, a: Reg, b: Reg) -> Result {
        self.a.vcmpps(YMM[to as usize], YMM[a as usize], YMM[b as usize], how as i32)
    }

    /// The same of f64. Narrow only.
    pub(crate) fn compare_double_narrow(&mut self, to: Reg, how: Compare, a: Reg, b: Reg) -> Result {
        self.a.vcmppd(YMM[to as usize], YMM[a as usize], YMM[b as usize], how as i32)
    }

    /// Keeps in the scratch mask, or in `to`, only the lanes that have the bits of a constant in `a` as well; `spare` is
    /// lost.
    pub(crate) fn equals_too(&mut self, to: Reg, a: Reg, value: f32, spare: Reg) -> Result {
        if self.wide {
            let from = dword_bcst(rsi + self.constant(value));
            let (found, other) = (MASKS[SCRATCH_MASK as usize], MASKS[0]);
            self.a.vpcmpeqd(other, ZMM[a as usize], from)?;
            self.a.kandw(found, found, other)
        } else {
            self.fill(spare, value)?;
            self.a.vpcmpeqd(YMM[spare as usize], YMM[a as usize], YMM[spare as usize])?;
            self.and(to, to, spare)
        }
    }

    /// Which lanes have the bits of a constant: into the scratch mask, or into `to`; `spare` is lost.
    pub(crate) fn equals(&mut self, to: Reg, a: Reg, value: f32, spare: Reg) -> Result {
        if self.wide {
            let from = dword_bcst(rsi + self.constant(value));
            self.a.vpcmpeqd(MASKS[SCRATCH_MASK as usize], ZMM[a as usize], from)
        } else {
            self.fill(spare, value)?;
            self.a.vpcmpeqd(YMM[to as usize], YMM[a as usize], YMM[spare as usize])
        }
    }

    pub(crate) fn label(&mut self) -> CodeLabel {
        self.a.create_label()
    }

    pub(crate) fn place(&mut self, label: &mut CodeLabel) -> Result {
        self.a.set_label(label)?;
        // Two labels may stand at one place, which one instruction cannot.
        self.a.nop()
    }

    pub(crate) fn jump(&mut self, to: CodeLabel) -> Result {
        self.a.jmp(to)
    }

    /// Jumps if what [`equals`](Self::equals) found, in all lanes.
    pub(crate) fn jump_if_all(&mut self, found: Reg, to: CodeLabel) -> Result {
        if self.wide {
            self.a.kortestw(MASKS[SCRATCH_MASK as usize], MASKS[SCRATCH_MASK as usize])?;
            return self.a.jb(to);
        }
        self.a.vmovmskps(eax, YMM[found as usize])?;
        self.a.cmp(eax, 0xff)?;
        self.a.je(to)
    }

    /// The lower and the upper half of the lanes, as f64. `high` must not be `from`.
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

    /// Both halves rounded to f32 and put together; `low` and `high` are lost.
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

/// A register of which an instruction writes the lanes of a mask.
fn masked(register: Reg, mask: u8) -> AsmRegisterZmm {
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

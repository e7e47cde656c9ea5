//! Operations with two operands, and their instructions.

/// Comparisons, with the numbers that the processor uses.
#[derive(Clone, Copy)]
pub(crate) enum Compare {
    Less = 0x11,
    NotLess = 0x15,
    AtLeast = 0x1d,
    Greater = 0x1e,
    NotEqual = 0x04,
}

/// Operations with two operands, on f32, on bits, and on f64.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum BinaryInstruction {
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    /// d + a·b.
    Fma,
    /// d − a·b.
    Fnma,
    MinBits,
    MaxBits,
    AddDouble,
    SubDouble,
    MulDouble,
    MaxDouble,
    /// d + a·b.
    FmaDouble,
    /// d − a·b.
    FnmaDouble,
}

impl BinaryInstruction {
    pub(crate) fn is_double(self) -> bool {
        matches!(
            self,
            Self::AddDouble | Self::SubDouble | Self::MulDouble | Self::MaxDouble | Self::FmaDouble | Self::FnmaDouble
        )
    }
}

/// Returns the instruction of an operation, for registers of either width and for memory operands.
macro_rules! instruction {
    ($assembler:expr, $op:expr, $to:expr, $a:expr, $b:expr) => {
        match $op {
            BinaryInstruction::Add => $assembler.vaddps($to, $a, $b),
            BinaryInstruction::Sub => $assembler.vsubps($to, $a, $b),
            BinaryInstruction::Mul => $assembler.vmulps($to, $a, $b),
            BinaryInstruction::Div => $assembler.vdivps($to, $a, $b),
            BinaryInstruction::Min => $assembler.vminps($to, $a, $b),
            BinaryInstruction::Max => $assembler.vmaxps($to, $a, $b),
            BinaryInstruction::Fma => $assembler.vfmadd231ps($to, $a, $b),
            BinaryInstruction::Fnma => $assembler.vfnmadd231ps($to, $a, $b),
            BinaryInstruction::MinBits => $assembler.vpminud($to, $a, $b),
            BinaryInstruction::MaxBits => $assembler.vpmaxud($to, $a, $b),
            BinaryInstruction::AddDouble => $assembler.vaddpd($to, $a, $b),
            BinaryInstruction::SubDouble => $assembler.vsubpd($to, $a, $b),
            BinaryInstruction::MulDouble => $assembler.vmulpd($to, $a, $b),
            BinaryInstruction::MaxDouble => $assembler.vmaxpd($to, $a, $b),
            BinaryInstruction::FmaDouble => $assembler.vfmadd231pd($to, $a, $b),
            BinaryInstruction::FnmaDouble => $assembler.vfnmadd231pd($to, $a, $b),
        }
    };
}
pub(crate) use instruction;

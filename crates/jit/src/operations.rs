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
pub(crate) enum Two {
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

impl Two {
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
            Two::Add => $assembler.vaddps($to, $a, $b),
            Two::Sub => $assembler.vsubps($to, $a, $b),
            Two::Mul => $assembler.vmulps($to, $a, $b),
            Two::Div => $assembler.vdivps($to, $a, $b),
            Two::Min => $assembler.vminps($to, $a, $b),
            Two::Max => $assembler.vmaxps($to, $a, $b),
            Two::Fma => $assembler.vfmadd231ps($to, $a, $b),
            Two::Fnma => $assembler.vfnmadd231ps($to, $a, $b),
            Two::MinBits => $assembler.vpminud($to, $a, $b),
            Two::MaxBits => $assembler.vpmaxud($to, $a, $b),
            Two::AddDouble => $assembler.vaddpd($to, $a, $b),
            Two::SubDouble => $assembler.vsubpd($to, $a, $b),
            Two::MulDouble => $assembler.vmulpd($to, $a, $b),
            Two::MaxDouble => $assembler.vmaxpd($to, $a, $b),
            Two::FmaDouble => $assembler.vfmadd231pd($to, $a, $b),
            Two::FnmaDouble => $assembler.vfnmadd231pd($to, $a, $b),
        }
    };
}
pub(crate) use instruction;

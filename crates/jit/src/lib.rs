//! Machine code for straight-line programs over rows of samples, made while a program runs.
//!
//! A [`Program`] describes the computation of one sample; [`Code::compile`] makes a loop that processes as many
//! samples at a time as the processor's vectors have lanes, with values in registers. The results equal those of
//! `trochoid_weights::arithmetic`, which defines the operations, bit for bit. The crate does not depend on graphs.
//!
//! ```
//! use trochoid_jit::{Code, Op, Program, Run, Scratch, Set, Stores};
//! use trochoid_memory::Target;
//!
//! let mut program = Program::new(2, 0, 1, 0);
//! let (t, u) = (program.compute(Op::Input(0)), program.compute(Op::Input(1)));
//! let product = program.compute(Op::Product(t, u));
//! program.output(product, 0);
//! // `None` on processors, or in processes, that cannot run such code.
//! if let Some(code) = Code::compile(&program, Set::Avx2, Stores::Cached) {
//!     let (a, b, mut c) = ([0.5; 32], [0.25; 32], [0.0; 32]);
//!     let run = Run { inputs: &[&a, &b], lines: &[], start: 0, count: 32 };
//!     code.run(&run, &mut [Target::new(&mut c)], &mut [], &mut Scratch::default());
//!     assert_eq!(c, [0.125; 32]);
//! }
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

use std::sync::atomic::AtomicPtr;

mod program;

#[cfg(target_arch = "x86_64")]
mod assembler;
#[cfg(target_arch = "x86_64")]
mod branches;
#[cfg(target_arch = "x86_64")]
mod code;
#[cfg(target_arch = "x86_64")]
mod operations;
#[cfg(target_arch = "x86_64")]
mod partition;
#[cfg(target_arch = "x86_64")]
mod registers;
#[cfg(target_arch = "x86_64")]
mod schedule;
#[cfg(target_arch = "x86_64")]
mod translate;

#[cfg(not(target_arch = "x86_64"))]
#[path = "no_code.rs"]
mod code;

#[cfg(test)]
mod tests;

pub use code::Code;
pub use program::{Op, Program, Value};

/// Number of samples of which every [`Code`] processes whole multiples; see [`Code::step`].
pub const STEP: usize = 32;

/// A vector of bits: state that is carried from one run to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(64))]
pub struct Lanes(pub [u32; 16]);

/// Memory that runs need beside their rows, for one thread.
#[derive(Debug, Default)]
#[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "no code runs"))]
pub struct Scratch {
    /// Values that do not fit into registers.
    slots: Vec<Lanes>,
    /// Table of rows: pointers that may move to another thread between runs, as nothing reads them there.
    table: Vec<AtomicPtr<f32>>,
}

/// Instruction set to compile for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// AVX-512: sixteen samples per vector.
    Avx512,
    /// AVX2 with fused multiply–add: eight samples per vector.
    Avx2,
}

/// Stores for outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stores {
    /// Through the cache.
    Cached,
    /// Around the cache: targets must be whole cache lines, lent by `write_around`.
    Around,
}

/// Inputs and range of a run.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Inputs: rows of at least `count` samples.
    pub inputs: &'a [&'a [f32]],
    /// Lines: at least one number each.
    pub lines: &'a [&'a [f32]],
    /// Position of the first sample in the targets.
    pub start: usize,
    /// Number of samples, a multiple of the code's [`step`](Code::step).
    pub count: usize,
}

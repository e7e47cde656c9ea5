//! Compiles a pointwise program to fused instructions and runs them, 128 pixels at a time.
//!
//! A *chunk* is 128 samples of one row: long enough that choosing an instruction costs little, short enough that the
//! values of a long program stay in L1. The last color computed is in the *accumulator*, three chunks that most
//! instructions both read and write; other values are in separate chunks, which are reused once their last reader has
//! run. Mixes of constants are computed where they are used, in registers. Planes from outside are read in place and
//! prefetched; the last instruction writes the result to its destination, around the cache if requested.
//!
//! Where that pays, the code is translated to machine code once (`native.rs`), which keeps values in registers and
//! needs no instruction dispatch; its bits are the same.
//!
//! Values that vary only along x are computed once per tile, values that vary only along y once per row. A branch
//! behind a mask that is 0 (or 1) on a whole chunk is jumped over.
//!
//! Masks are checked against [0, 1] and colors against their palette's bounding box while the program runs: the bits
//! of floating-point numbers ≥ 0 sort like integers, and NaN and negative numbers sort above all of them, so that one
//! unsigned maximum and minimum detect every violation.

mod audit;
mod code;
mod color;
mod compile;
mod generate;
#[cfg_attr(not(feature = "jit"), path = "no_native.rs")]
mod native;
mod order;
mod partition;
mod run;
mod sweep;

pub(crate) use audit::{ValueRule, WeightAudit};
#[cfg(test)]
pub(crate) use code::Fault;
pub(crate) use code::{CHUNK, Chunk, CompiledProgram, Origin, Plane};
pub(crate) use compile::{Options, compile};
pub(crate) use run::{Chunks, Look, Machine, Range, TakeRow};

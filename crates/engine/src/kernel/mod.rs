//! Compiles a pointwise program to fused instructions and runs them, 128 pixels at a time.
//!
//! A *chunk* is 128 samples of one row: long enough that choosing an instruction costs little, short enough that the
//! values of a long program stay in L1. The last color computed stands in the *accumulator*, three chunks that most
//! instructions both read and write; other values stand in chunks of their own, reused once their last reader has run.
//! Mixes of constants are computed where they are used, in registers. Planes from outside are read in place and
//! fetched ahead; the last instruction writes the result where it belongs, around the cache if that is asked for.
//!
//! Where that pays, the code is translated to machine code once (`native.rs`), which keeps values in registers and
//! chooses nothing; its bits are the same.
//!
//! What varies along x alone runs once a tile, what varies along y alone once a row. A branch behind a mask that is 0
//! (or 1) on a whole chunk is jumped over.
//!
//! Masks are held against [0, 1] and colors against their palette's box in passing: bits of floating-point numbers ≥ 0
//! order like integers, and NaN and negative numbers come out above all of them, so that one unsigned maximum and
//! minimum see everything.

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

pub(crate) use audit::{Legal, WeightAudit};
#[cfg(test)]
pub(crate) use code::Fault;
pub(crate) use code::{CHUNK, Chunk, Compiled, Origin, Plane};
pub(crate) use compile::{Options, compile};
pub(crate) use run::{Chunks, Look, Machine, Range, TakeRow};

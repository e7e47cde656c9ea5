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
//!
//! ```
//! use trochoid_graph::{Color, NodeId, Op, Program, Scalar, Slot, Variance};
//! use trochoid_kernel::{Chunks, Machine, Options, Plane, compile};
//!
//! // Black to white by the first channel of node 0.
//! let node = NodeId(0);
//! let mut program = Program::default();
//! let t = Scalar(program.push(Op::Load(Slot { node, output: 0, channel: 0 }), node));
//! let a = Color(program.push(Op::ConstantColor([0.0; 3]), node));
//! let b = Color(program.push(Op::ConstantColor([1.0; 3]), node));
//! let mix = program.push(Op::Mix { a, b, t }, node);
//!
//! let options = Options {
//!     hoist: true,
//!     fuse: true,
//!     everything: false,
//!     instructions: Default::default(),
//!     audits: true,
//!     native: false,
//!     variance: &|_| Variance::Pixel,
//!     rule: &|_| None,
//! };
//! let compiled = compile(&program, &[mix], &options);
//! let mut chunks = Chunks::of([&compiled]);
//! let mut machine = Machine::new(&compiled, &mut chunks.all());
//! let plane = Plane { samples: &[0.0, 0.25, 1.0], start: 0, stride: 3 };
//! let mut red = Vec::new();
//! machine.tile(&[plane], 3, 1, &mut |_root, channel, _y, row| {
//!     if channel == 0 {
//!         red = row.to_vec();
//!     }
//! });
//! assert_eq!(red, [0.0, 0.25, 1.0]);
//! assert_eq!(machine.audit().min, 0.0, "no weight was below 0 or above 1");
//! ```

mod audit;
mod block;
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
mod variance;

pub use audit::{ValueRule, WeightAudit};
#[cfg(feature = "faults")]
pub use code::Fault;
pub use code::{BLOCK, Block, CHUNK, Chunk, CompiledProgram, Origin, Plane};
pub use compile::{Options, compile};
pub use run::{Chunks, Look, Machine, Range, TakeRow, TilePlanes};
pub use variance::variance;

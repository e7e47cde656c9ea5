//! Memory of pixels: aligned buffers on large pages, prefetch, streaming stores; and an allocator that counts and
//! bounds the memory of a program ([`Heap`]).
//!
//! With `trochoid-jit` the only crate beneath the facade with `unsafe` code; all of it is behind interfaces that cannot be
//! misused.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod buffer;
mod dispatch;
mod heap;
mod pages;
mod prefetch;
mod recycle;
mod scratch;
mod target;

pub use buffer::{Buffer, zeros};
pub use dispatch::{Instructions, Kernel, dispatch};
pub use heap::{Exhausted, Heap, exit_at_once, fallible};
pub use prefetch::prefetch;
pub use recycle::emptied;
pub use scratch::Scratch;
pub use target::{Line, Lines, Stream, Target, write_around};

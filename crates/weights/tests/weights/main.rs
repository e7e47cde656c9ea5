//! Tests of the crate from outside, in one program.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod arithmetic;
mod audit;
mod hull;
mod kernel;
mod paint;
mod partitions;
mod stored;
mod sums;

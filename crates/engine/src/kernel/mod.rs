//! Compiles a pointwise program to instructions over short rows and runs them.
//!
//! Every value of the program is one or more rows of f32, as long as the tile is wide. Rows are reused once
//! their last reader has run, so that a program of any length works in a few rows that stay in L1. Planes from
//! outside are read in place.

mod compile;
mod run;

#[cfg(test)]
pub(crate) use compile::Fault;
pub(crate) use compile::{Compiled, compile};
pub(crate) use run::{Machine, Plane, Sink, WeightAudit};

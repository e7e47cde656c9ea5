//! Replacement for platforms without machine code.

use crate::{Lanes, Program, Run, Scratch, Set, Stores};
use trochoid_memory::Target;

/// Type without values: no code can be made.
#[derive(Debug)]
pub enum Code {}

impl Code {
    /// Returns `None`.
    pub fn compile(_program: &Program, _set: Set, _stores: Stores) -> Option<Self> {
        None
    }

    /// Never called.
    pub fn step(&self) -> usize {
        match *self {}
    }

    /// Never called.
    pub fn run(&self, _run: &Run<'_>, _out: &mut [Target<'_>], _state: &mut [Lanes], _scratch: &mut Scratch) {
        match *self {}
    }
}

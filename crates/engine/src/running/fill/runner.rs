//! Runs the pointwise program before a stage.

use crate::running::certify::Trace;
use trochoid_kernel::{Chunk, CompiledProgram, Machine, Plane, TakeRow, WeightAudit};

/// Runs the program alone, or with bounds on its errors.
#[derive(Debug)]
pub(super) enum Runner<'p> {
    Machine(Box<Machine<'p>>),
    Trace(Trace<'p>),
}

impl<'p> Runner<'p> {
    pub(super) fn new(compiled: &'p CompiledProgram, bounding: bool, chunks: &mut &'p mut [Chunk]) -> Self {
        if bounding {
            Self::Trace(Trace::new(compiled))
        } else {
            Self::Machine(Box::new(Machine::new(compiled, chunks)))
        }
    }

    pub(super) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, take: TakeRow<'_>) {
        match self {
            Self::Machine(machine) => machine.tile(planes, width, height, take),
            Self::Trace(trace) => trace.tile(planes, width, height, take),
        }
    }

    /// Returns the extremes of weights over everything that ran.
    pub(super) fn audit(&self) -> WeightAudit {
        match self {
            Self::Machine(machine) => machine.audit(),
            Self::Trace(_) => WeightAudit::default(),
        }
    }
}

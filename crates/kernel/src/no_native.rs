//! Stands in for `native.rs` if machine code is not compiled in.

use crate::code::Code;
use crate::run::{CodeFrame, KernelInputs, Look};
use fearless_simd::Level;
use trochoid_memory::Target;

/// A type without values, since there is no machine code.
#[derive(Clone, Debug)]
pub(crate) enum Native {}

#[derive(Debug, Default)]
pub(crate) struct NativeMemory {}

impl Native {
    pub(crate) fn new(_code: &Code, _planes: usize, _columns: usize, _lines: usize, _level: Level) -> Option<Self> {
        None
    }

    #[allow(clippy::too_many_arguments, reason = "as the other")]
    pub(crate) fn row(
        &self,
        _frame: &mut CodeFrame<'_>,
        _inputs: KernelInputs<'_>,
        _width: usize,
        _out: &mut [Target<'_>],
        _start: usize,
        _look: Option<Look<'_>>,
        _scratch: &mut NativeMemory,
    ) -> bool {
        match *self {}
    }

    pub(crate) fn make_ready(&self) -> Option<usize> {
        match *self {}
    }

    pub(crate) fn samples(
        &self,
        _frame: &mut CodeFrame<'_>,
        _inputs: &[&[f32]],
        _count: usize,
        _outputs: &mut [Target<'_>],
        _scratch: &mut NativeMemory,
    ) -> bool {
        match *self {}
    }
}

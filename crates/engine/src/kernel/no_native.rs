//! Stands in for `native.rs` if machine code is not compiled in.

use super::code::Code;
use super::run::{Frame, Given, Look};
use fearless_simd::Level;
use trochoid_memory::Target;

/// A type without values, since there is no machine code.
#[derive(Clone, Debug)]
pub(crate) enum Native {}

#[derive(Debug, Default)]
pub(super) struct Space {}

impl Native {
    pub(super) fn new(_code: &Code, _planes: usize, _columns: usize, _lines: usize, _level: Level) -> Option<Self> {
        None
    }

    #[allow(clippy::too_many_arguments, reason = "as the other")]
    pub(super) fn row(
        &self,
        _frame: &mut Frame<'_>,
        _given: Given<'_>,
        _width: usize,
        _out: &mut [Target<'_>],
        _start: usize,
        _look: Option<Look<'_>>,
        _space: &mut Space,
    ) -> bool {
        match *self {}
    }
}

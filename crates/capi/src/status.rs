//! Statuses and other words of the interface.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Result of a function. The numbers are the exit codes of the program, as far as it has them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum trochoid_status {
    /// Done.
    TROCHOID_OK = 0,
    /// Files cannot be read, or their data are bad.
    TROCHOID_IO = 1,
    /// The document is invalid, or an argument is wrong.
    TROCHOID_INVALID = 2,
    /// Inputs have too few channels or samples, or illegal samples.
    TROCHOID_BUFFER = 4,
    /// Memory, or threads, do not suffice.
    TROCHOID_MEMORY = 5,
    /// The progress callback asked to stop.
    TROCHOID_CANCELLED = 130,
    /// The library failed; please report it.
    TROCHOID_PANIC = 255,
}

/// What happens to illegal samples of inputs, such as a weight of 1.1 or NaN.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum trochoid_illegal {
    /// The batch is refused with TROCHOID_BUFFER, and the input and sample are told.
    TROCHOID_REFUSE = 0,
    /// They become the nearest legal number, and NaN becomes 0. Weights are divided by their sum.
    TROCHOID_CLAMP = 1,
}

/// Kind of an input, or of the output.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum trochoid_kind {
    /// Three channels in the working space of the document; finite numbers >= 0.
    TROCHOID_COLOR = 0,
    /// One channel; numbers in [0, 1].
    TROCHOID_MASK = 1,
    /// A channel for each weight; numbers in [0, 1] that sum to 1 within 0.001.
    TROCHOID_WEIGHTS = 2,
    /// A channel for each component; any numbers but NaN.
    TROCHOID_FIELD = 3,
}

/// Runs a function of the interface; a panic becomes a status.
pub(crate) fn guarded(run: impl FnOnce() -> trochoid_status) -> trochoid_status {
    or_panic(trochoid_status::TROCHOID_PANIC, run)
}

/// Runs a function of the interface that has no status; after a panic it returns `otherwise`.
pub(crate) fn or_panic<R>(otherwise: R, run: impl FnOnce() -> R) -> R {
    // What was in use is not used again: the header says so.
    catch_unwind(AssertUnwindSafe(run)).unwrap_or(otherwise)
}

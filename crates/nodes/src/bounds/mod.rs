//! What is certain of values: spans, and bounds of stages' errors that follow from them.

mod known;

#[cfg(feature = "io")]
pub(crate) use known::bound_exact;
pub(crate) use known::{bound_at, bound_by, certain, known, where_covered};

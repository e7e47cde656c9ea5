//! Rules for each operation of the pointwise program besides how to compute it.
//!
//! Each rule is one exhaustive match, so an operation cannot be added without all of its rules.

pub(crate) mod blame;
pub(crate) mod error;
pub(crate) mod evaluate;
pub(crate) mod interval;

//! The items of a toon sea and its prepared form.

mod bursts;
mod exact;
mod prepared;

pub(crate) use bursts::{Burst, FloatingBody, Guide, TimedPath};
pub(crate) use prepared::{GridLayout, PreparedToonSea};

//! The items of a toon sea and its prepared form.

mod bursts;
mod check;
mod exact;
mod kept;
mod prepared;

pub(crate) use bursts::{Burst, FloatingBody, Guide, TimedPath};
pub(crate) use check::check;
pub(crate) use prepared::{GridLayout, PreparedToonSea};

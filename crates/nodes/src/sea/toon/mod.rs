//! The items of a toon sea and its prepared form.

mod bursts;
mod prepared;

pub(crate) use bursts::{Afloat, Burst, Guide, Way};
pub(crate) use prepared::{Place, PreparedToon};

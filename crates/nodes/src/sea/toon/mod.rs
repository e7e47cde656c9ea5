//! What a toon sea is made of, and what is prepared of it.

mod bursts;
mod prepared;

pub(crate) use bursts::{Afloat, Burst, Guide, Way};
pub(crate) use prepared::{Place, PreparedToon};

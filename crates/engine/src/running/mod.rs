//! Executes a [`Plan`](crate::Plan): prepares stages, fills tiles, runs programs over them, judges pixels and hands
//! them on.
//!
//! `run` evaluates a frame: `prepare` prepares its stages within the limit that `memory` checks, `fill` fills their
//! planes for a `tile` of a `tile_size`, in one of several `steps`, and `bands` receive the finished rows. The other
//! modules produce something other than a picture: `certify` bounds on its errors, `inspect` one pixel in detail, `held` a
//! list of planes, `reference` the slow f64 result, `examine` faults of input files.

pub(crate) mod adaptive;
mod bands;
pub(crate) mod buffer_fault;
pub(crate) mod buffers;
pub(crate) mod certify;
mod check_headers;
pub(crate) mod fill;
pub(crate) mod foreign;
pub(crate) mod frame;
pub(crate) mod held;
pub(crate) mod inspect;
pub(crate) mod keep;
pub(crate) mod memory;
pub(crate) mod prepare;
pub(crate) mod reference;
pub(crate) mod run;
pub(crate) mod steps;
pub(crate) mod tile;
mod tile_memory;
mod tile_size;

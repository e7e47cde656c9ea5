//! What is done with a [`Plan`](crate::Plan): stages prepared, tiles filled, programs run over them, pixels judged and
//! handed on.
//!
//! `run` evaluates a frame: `prepare` readies its stages within what `memory` reckons, `fill` fills their planes for a `tile`,
//! and `bands` take the rows that are finished. The others give something else than a picture: `certify` bounds on its errors,
//! `inspect` one pixel in detail, `points` batches of a renderer's samples, `reference` the slow f64 result, `examine` what is
//! wrong with input files.

pub(crate) mod bands;
pub(crate) mod buffers;
pub(crate) mod certify;
mod examine;
pub(crate) mod fill;
pub(crate) mod foreign;
pub(crate) mod frame;
pub(crate) mod inspect;
pub(crate) mod keep;
pub(crate) mod memory;
pub(crate) mod points;
pub(crate) mod prepare;
pub(crate) mod reference;
pub(crate) mod run;
pub(crate) mod tile;

//! Tests of `trochoid-io` on files made here with the `exr` and `image` crates. They are a package of their own: what
//! they use of these crates is compiled with them, and is not worth being optimized as `trochoid-io` is.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod damage;
mod exr_kinds;
mod headers;
mod make;
mod rasters;
mod round_trip;
mod streams;
mod tiffs;

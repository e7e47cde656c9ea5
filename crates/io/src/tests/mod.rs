//! Tests across the crate's modules, on files made here with the `exr` and `image` crates.

mod damage;
mod exr_kinds;
mod headers;
mod make;
mod rasters;
mod round_trip;
mod streams;
mod tiffs;

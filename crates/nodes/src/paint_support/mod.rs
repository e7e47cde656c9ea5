//! What the painter's nodes share: random numbers of strokes, where strokes begin, and their shape.

mod layer;
mod random;
#[cfg(feature = "scene")]
mod ribbon;
mod seeds;
mod stroke;

pub(crate) use layer::{LAYERS, Layer, MARGIN, STRIDES, layers, reach};
pub(crate) use random::{draw, key};
#[cfg(feature = "scene")]
pub(crate) use ribbon::{Ribbon, Shape};
#[cfg(feature = "scene")]
pub(crate) use seeds::within;
pub(crate) use seeds::{Cells, Corner, Seed, placed, seeds_of};
pub(crate) use stroke::{Around, Manner, Stroke, pixels};

//! What the painter's nodes share: random numbers of strokes, where strokes begin, what they see around them, and their shape.

mod canvas;
#[cfg(feature = "scene")]
mod claw;
mod layer;
mod random;
#[cfg(feature = "scene")]
mod ribbon;
mod seeds;
mod stroke;

pub(crate) use canvas::{Canvas, Planes, RESTS, Seen, index, sample};
#[cfg(feature = "scene")]
pub(crate) use claw::{Claw, Places, VALUES, covered};
pub(crate) use layer::{LAYERS, Layer, MARGIN, STRIDES, layers, reach};
pub(crate) use random::{draw, key};
#[cfg(feature = "scene")]
pub(crate) use ribbon::{Ribbon, Shape};
pub(crate) use seeds::{Cells, Corner, Seed, placed, seeds_of};
pub(crate) use stroke::{Around, Manner, Stroke, pixels};

//! Palettes of finished pictures: few colors whose hull encloses every pixel.
//!
//! [`Cloud`] collects the colors of pictures as they are displayed, [`extract`] finds palettes of them. A palette
//! *encloses* the pixels if none lies outside of the convex hull of its colors, so that every pixel is a mix of them with
//! weights that are ≥ 0 and sum to 1. That is decided in whole numbers: colors are on a grid of 8-bit steps, or of a
//! sixteenth or a 256th of a step. To find the least number of colors is NP-hard, so what is found need not be the least.

#![forbid(unsafe_code)]

mod block;
mod cloud;
mod corner;
mod decompose;
mod extract;
mod few;
mod found;
mod grid;
mod ignore;
mod lattice;
mod mesh;
mod order;
mod program;
mod simplex;
mod solid;
mod together;
mod tones;
mod vector;

pub use cloud::Cloud;
pub use decompose::{Decomposer, MOST_COLORS};
pub use extract::{Asked, extract};
pub use found::{Enclosing, Extraction, Outside, Palette, Short};
pub use tones::Tones;

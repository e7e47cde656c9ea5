//! Nodes that paint and draw (strokes, hooks, line sets), and what they share: random numbers, the seeds and shapes of
//! strokes, and access to their surroundings.

mod brush;
mod canvas;
mod found;
mod groups;
#[cfg(feature = "scene")]
mod hooks;
mod layer;
#[cfg(feature = "scene")]
pub(crate) mod line_set;
mod painting;
mod planes;
pub(crate) mod scan;
pub(crate) mod seeds;
mod stroke;
mod strokes;

pub(crate) use brush::{Brush, Ground, LANES, Rows};
pub(crate) use canvas::{BlockSurroundings, Canvas, RESTS, ReferenceSurroundings, StrokeInputs};
pub(crate) use layer::{Layer, LayerKnobs, MARGIN, STRIDES, layers, reach};
pub(crate) use seeds::{Cells, Corner, Seed, seeds_of};
pub(crate) use stroke::{Stroke, StrokeSettings, StrokeSurroundings, ceiling, floor, pixels};

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[
    #[cfg(feature = "scene")]
    NodeType::of::<hooks::Hooks>(),
    #[cfg(feature = "scene")]
    NodeType::of::<line_set::LineSet>(),
    NodeType::of::<strokes::Strokes>(),
];

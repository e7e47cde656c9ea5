//! Nodes that make fields and masks: screen coordinates, noise, grain, shapes, broken paint and formulas.

mod expression;
mod field_math;
mod function_span;
mod grain;
mod noise;
#[cfg_attr(not(feature = "scene"), allow(dead_code, reason = "only lines on water ask for slopes"))]
mod octaves;
mod parser;
mod program;
mod screen;
mod screen_x;
mod screen_y;
mod scumble;
mod shape;

pub(crate) use expression::Expression;
pub(crate) use octaves::{Axes, Noise, NoiseKind, noise_reference, noise_span};
#[cfg(feature = "scene")]
pub(crate) use octaves::{Octave, edges_reference};
pub(crate) use parser::parse;
pub(crate) use program::Program;
pub(crate) use screen::Screen;

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[
    NodeType::of::<field_math::FieldMath>(),
    NodeType::of::<grain::Grain>(),
    NodeType::of::<noise::Noise>(),
    NodeType::of::<screen_x::ScreenX>(),
    NodeType::of::<screen_y::ScreenY>(),
    NodeType::of::<scumble::Scumble>(),
    NodeType::of::<shape::Shape>(),
];

//! Nodes that make fields and masks: screen coordinates, noise, grain, shapes, broken paint and formulas.

mod field_math;
mod grain;
mod noise;
mod screen;
mod screen_x;
mod screen_y;
mod scumble;
mod shape;

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

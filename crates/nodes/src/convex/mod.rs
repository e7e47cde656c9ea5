//! Nodes that combine colors and weights sample by sample, and make weights from fields.

mod bands;
mod blend;
mod clamp;
mod constant;
mod invert;
mod mix;
mod multiply;
mod normalize;
mod patch;
mod pick_weight;
mod ramp;
mod screen;
mod sheet;
mod stack;
mod switch;

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[
    NodeType::of::<bands::Bands>(),
    NodeType::of::<blend::Blend>(),
    NodeType::of::<clamp::Clamp>(),
    NodeType::of::<constant::Constant>(),
    NodeType::of::<invert::Invert>(),
    NodeType::of::<mix::Mix>(),
    NodeType::of::<multiply::Multiply>(),
    NodeType::of::<normalize::Normalize>(),
    NodeType::of::<patch::Patch>(),
    NodeType::of::<pick_weight::PickWeight>(),
    NodeType::of::<ramp::Ramp>(),
    NodeType::of::<screen::Screen>(),
    NodeType::of::<sheet::Sheet>(),
    NodeType::of::<stack::Stack>(),
    NodeType::of::<switch::Switch>(),
];

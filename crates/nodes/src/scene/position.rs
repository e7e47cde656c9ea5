//! Position: where things are.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::PositionX, Channel::PositionY, Channel::PositionZ];

static DECLARATION: Declaration = Declaration {
    name: "Position",
    end: End::Front,
    summary: "The seen point in the world.",
    formula: "P",
    edge_cases: "(0, 0, 0) where nothing is seen.",
    source: "The field's position pass.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("position", Kind::Field(3), "World position, m.")],
    revision: 1,
};

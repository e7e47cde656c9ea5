//! Depth: how far away things are.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::Depth];

static DECLARATION: Declaration = Declaration {
    name: "Depth",
    end: End::Front,
    summary: "The planar distance from the camera, along its axis.",
    formula: "(P − P_C) · axis",
    edge_cases: "+∞ where nothing is seen; Clamp takes it to 1.",
    source: "Thesis 3.2.3.4, Z_s.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("depth", Kind::Field(1), "Planar distance, m.").stored_as(&["Z"])],
    revision: 1,
};

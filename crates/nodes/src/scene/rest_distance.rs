//! RestDistance: how far a particle has moved.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::RestDistance];

static DECLARATION: Declaration = Declaration {
    name: "RestDistance",
    end: End::Front,
    summary: "The distance of the seen particle from its rest point.",
    formula: "|P − P₀|",
    edge_cases: "0 where nothing is seen.",
    source: "Thesis 3.1.2, depth component: distance of a shading point to its rest point.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("distance", Kind::Field(1), "Distance, m.")],
    revision: 1,
};

//! Rest: where the seen point was before anything moved it.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::RestX, Channel::RestY, Channel::RestZ];

static DECLARATION: Declaration = Declaration {
    name: "Rest",
    end: End::Front,
    summary: "The rest point of what is seen: patterns over it move with the surface.",
    formula: "P₀: of a sea the particle's place on the rest level, of a model the point in the model's own space",
    edge_cases: "(0, 0, 0) where nothing is seen.",
    source: "The field's rest (reference position) pass.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("rest", Kind::Field(3), "Rest point, m.")],
    revision: 1,
};

//! UV: where on its texture the seen point lies.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::U, Channel::V];

static DECLARATION: Declaration = Declaration {
    name: "UV",
    end: End::Front,
    summary: "The texture coordinates of the seen point.",
    formula: "(u, v): of a patch its parameters, of rails 0 to 1 over the whole sheet, of a mesh those of its file",
    edge_cases: "(0, 0) where nothing is seen. Surfaces without texture coordinates, such as a sea, have the rest \
                 point's x and z instead, in meters. A FieldMath takes one of them: a.x is u, a.y is v.",
    source: "The field's UV pass.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("uv", Kind::Field(2), "Texture coordinates u, v.")],
    revision: 1,
};

//! Normal: which way things face.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::NormalX, Channel::NormalY, Channel::NormalZ];

static DECLARATION: Declaration = Declaration {
    name: "Normal",
    end: End::Front,
    summary: "The unit normal of the seen point.",
    formula: "N/|N|",
    edge_cases: "(0, 1, 0) where nothing is seen or the normal is degenerate.",
    source: "The field's normal pass.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("normal", Kind::Field(3), "Unit normal in the world.")],
    revision: 1,
};

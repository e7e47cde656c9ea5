//! Height: how high the surface stands.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::Height];

static DECLARATION: Declaration = Declaration {
    name: "Height",
    end: End::Front,
    summary: "The height of the seen point above its surface's rest level.",
    formula: "P.y − level",
    edge_cases: "0 where nothing is seen.",
    source: "Thesis 3.1.2: color varies from trough to crest.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("height", Kind::Field(1), "Height, m.")],
    revision: 1,
};

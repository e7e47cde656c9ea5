//! FoldFoam: foam where the water's surface is squeezed.

use crate::scene_support::{Ramp, ViewMask};
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewMask {
    declaration: &DECLARATION,
    channels: &[Channel::Jacobian],
    ramps: |node| vec![Ramp::Falling { from: node.number("threshold"), width: node.number("width") }],
};

static DECLARATION: Declaration = Declaration {
    name: "FoldFoam",
    end: End::Front,
    summary: "A mask of foam where waves squeeze the surface: it starts before crests fold over.",
    formula: "(threshold − det J)/width, limited to [0, 1]; det J is the area of the displaced surface over that at \
              rest: 1 on calm water, 0 where it begins to fold, negative in folds.",
    edge_cases: "0 where nothing is seen. Width 0 is a step: 1 below the threshold.",
    source: "Tessendorf, Simulating Ocean Water, 2001 (the Jacobian of the choppy sea); the threshold after many \
             seas that look broken long before they fold.",
    items: &[
        Port::one("view", Accepts::View, "The water."),
        Knob::number("threshold", 0.4, -100.0, 100.0, "The Jacobian below which foam starts.").item(),
        Knob::number("width", 0.3, 0.0, 100.0, "How far below the threshold it covers everything.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The foam.")],
    revision: 1,
};

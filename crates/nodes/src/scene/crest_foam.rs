//! CrestFoam: foam on crests that are high and flat.

use crate::scene_support::{Ramp, ViewMask};
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewMask {
    declaration: &DECLARATION,
    channels: &[Channel::Height, Channel::NormalY],
    ramps: |node| {
        let [height, rise, flatness, softness] =
            ["height", "rise", "flatness", "softness"].map(|knob| node.number(knob));
        vec![Ramp::Rising { from: height, width: rise }, Ramp::Rising { from: flatness, width: softness }]
    },
};

static DECLARATION: Declaration = Declaration {
    name: "CrestFoam",
    end: End::Front,
    summary: "A mask of foam on the crests of waves: where they stand high and their tops lie flat.",
    formula: "R((h − height)/rise) · R((n.y − flatness)/softness), R limits to [0, 1]; h is the height above the rest \
              level, n the unit normal.",
    edge_cases: "0 where nothing is seen. Rise or softness 0 is a step that includes its threshold; flatness −1 with \
                 softness 0 leaves the height alone to decide.",
    source: "A toon water after Hokusai: where the normal is steepest above a height, the crest turns and foams.",
    items: &[
        Port::one("view", Accepts::View, "The water."),
        Knob::number("height", 0.5, -1e5, 1e5, "Height from which on there is foam.").unit("m").item(),
        Knob::number("rise", 0.5, 0.0, 1e5, "How much higher it is full.").unit("m").item(),
        Knob::number("flatness", 0.9, -1.0, 1.0, "The normal's y from which on there is foam; 1 is level.").item(),
        Knob::number("softness", 0.05, 0.0, 2.0, "How much more it is full.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The foam.")],
    revision: 1,
};

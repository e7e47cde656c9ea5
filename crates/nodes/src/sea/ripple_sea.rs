//! RippleSea: the crossed ripples of cartoon water.

use crate::scene_support::{REST, Standing, memory, stability};
use trochoid_graph::*;
use trochoid_scene::SeaSurface;
use trochoid_sea::{Ripple, Sea, Wave};

pub(crate) static NODE: &dyn NodeType = &RippleSea;

struct RippleSea;

static DECLARATION: Declaration = Declaration {
    name: "RippleSea",
    end: End::Front,
    summary: "An endless chessboard of bumps and hollows that travels: the water of a cartoon.",
    formula: "y = A·sin(k₁a − ωt + φ)·cos(k₂b) at places a along `direction` and b across it; A = `height`, k = \
              2π/length, ω = √(g·√(k₁² + k₂²)). convention \"literal\": y = A·sin(k₁a + ωt + φ)·cos(k₂b + ωt), ω = 1. \
              Both are the sum of two crossed waves of height A/2, which fade as those of a GerstnerSea.",
    edge_cases: "`height` 0 is a flat sea. As printed one of the two waves runs at 2ω and the other stands still. Several \
                 ripples of different lengths make a livelier water: set them in a GerstnerSea as `waves`.",
    source: "Creation of a cartoon shader of water for the web, part 2: pos.y += cos(pos.z·5 + t)·0.1·sin(pos.x·5 + t).",
    items: &[
        Knob::number("height", 0.1, -1e4, 1e4, "Height of the bumps over the rest level.").unit("m").item(),
        Knob::number("along", 1.2566, 1e-3, 1e6, "Bump to bump along the direction.").unit("m").item(),
        Knob::number("across", 1.2566, 1e-3, 1e6, "Bump to bump across it; large makes long crests.").unit("m").item(),
        Knob::number("direction", 0.0, -3600.0, 3600.0, "Where they travel: 0 is +X, 90 is +Z.").unit("degrees").item(),
        Knob::number("frequency", 1.0, -1e4, 1e4, "Angular frequency ω; if unset deep water decides, or 1 as printed.")
            .optional()
            .unit("rad/s")
            .item(),
        Knob::number("phase", 0.0, -1e6, 1e6, "Phase φ.").unit("degrees").item(),
        Knob::choice("convention", &["settled", "literal"], "Phases so that all travels, or as printed.").item(),
        Knob::number("level", 0.0, -1e5, 1e5, "World y of the sea at rest.").unit("m").item(),
    ],
    outputs: &[Output::new("surface", Kind::Surface, "The sea at the frame's time.")],
    revision: 1,
};

/// The waves that the knobs describe.
fn waves(node: &Settled) -> Result<[Wave; 2], String> {
    let ripple = Ripple {
        height: node.number("height"),
        lengths: ["along", "across"].map(|knob| node.number(knob)),
        direction: node.number("direction").to_radians(),
        frequency: node.is_set("frequency").then(|| node.number("frequency")),
        phase: node.number("phase").to_radians(),
        literal: node.text("convention") == "literal",
    };
    ripple.waves().map_err(|error| error.to_string())
}

impl NodeType for RippleSea {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn stability(&self, node: &Settled) -> Option<Stability> {
        Some(stability::waves(waves(node).ok()?.to_vec()))
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for RippleSea {
    fn timed(&self) -> bool {
        true
    }

    fn formatted(&self) -> bool {
        false
    }

    fn offers(&self) -> &'static [&'static str] {
        &[REST]
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        let _ = node;
        memory::of_sea(1.0, reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = Sea::new(waves(node).map_err(NodeError::new)?.to_vec());
        Ok(Box::new(Standing::new(SeaSurface::new(&sea, prepare.frame.time, node.number("level")))))
    }
}

//! Float: bodies that ride on a sea.

use crate::scene_support::{REST, Standing, SurfaceHandle, check_sea};
use trochoid_graph::*;
use trochoid_scene::{Floating, Pose, RigidBodies};

pub(crate) static NODE: &dyn NodeType = &Float;

struct Float;

static DECLARATION: Declaration = Declaration {
    name: "Float",
    end: End::Front,
    summary: "Makes a model ride on a sea, at one place or at many: it rises, pitches and rolls with the water under it.",
    formula: "The plane y = h + a·u + b·v through the water at 9 × 5 points under the hull, by least squares, u toward the \
              bow, v to starboard. The model's up is the plane's normal, slopes times `tilt`; its origin stands `lift` \
              along it above (x, h, z). The water at a place is that of the rest point which waves carry there.",
    edge_cases: "Waves that are shorter than the hull hardly move it: those shorter than the points lie apart are \
                 smoothed away, the rest averages out. Where waves fold over, the body follows one of the sheets. Beside \
                 a finite sea the heights of its edge go on. Nothing depends on the frames before: no momentum, no drift; \
                 key `x`, `z` and `heading` to let it sail. The water takes no notice of the body.",
    source: "Creation of a cartoon shader of water for the web, part 2 (buoyancy); linear least squares.",
    items: &[
        Port::one("model", Accepts::Surface, "What floats: bow along +x, y up, y = 0 its waterline."),
        Port::one("sea", Accepts::Surface, "The water: GerstnerSea, RippleSea or ToonSea."),
        Knob::number("length", 4.0, 1e-3, 1e6, "Length of the hull under water.").unit("m").item(),
        Knob::number("width", 2.0, 1e-3, 1e6, "Width of the hull under water.").unit("m").item(),
        Knob::number("tilt", 1.0, 0.0, 10.0, "Share of the water's slope that bodies take: 0 stays upright.").item(),
        List::of("bodies", BODY, 1, 64, "Where the model floats."),
    ],
    outputs: &[Output::new("surface", Kind::Surface, "The floating bodies, as one surface.")],
    revision: 1,
};

static BODY: &[Item] = &[
    Knob::number("x", 0.0, -1e8, 1e8, "World x of its middle.").unit("m").item(),
    Knob::number("z", 0.0, -1e8, 1e8, "World z of its middle.").unit("m").item(),
    Knob::number("heading", 0.0, -36e5, 36e5, "Where its bow points: 0 is +X, 90 is +Z.").unit("degrees").item(),
    Knob::number("lift", 0.0, -1e5, 1e5, "How far it floats above its waterline; negative sinks it.").unit("m").item(),
];

impl NodeType for Float {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_sea(node, check, "sea");
        let Some(model) = node.all("model").first().and_then(|source| check.upstream(source)) else { return };
        if model.ty.declaration().name == DECLARATION.name {
            let found = format!("\"{}\", which floats already: its places count as a part of the model", model.name);
            let remedy = "connect its model here too, or list all places in its \"bodies\"";
            check.warning("model", found, "a model that stands still", remedy);
        }
        if model.offers(REST) {
            let found = format!("\"{}\", a {}, which is water itself", model.name, model.ty.declaration().name);
            check.error("model", found, "a model that floats", "connect a Mesh or a BezierModel");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Float {
    fn formatted(&self) -> bool {
        false
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        let bodies = node.list("bodies").len() as u64;
        let seen = reckoning.all(node, "model").fold(0, |sum: u64, taken| sum.saturating_add(taken.seen));
        MemoryUse::default().seen(seen.saturating_mul(bodies))
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let handles = |port: &str| prepare.handles::<SurfaceHandle>(node, port);
        let (model, sea) = (handles("model")?.swap_remove(0), handles("sea")?.swap_remove(0));
        let poses: Option<Vec<Pose>> = node
            .list("bodies")
            .iter()
            .map(|body| {
                let floating = Floating {
                    place: [body.number("x"), body.number("z")],
                    heading: body.number("heading").to_radians(),
                    hull: [node.number("length"), node.number("width")],
                    lift: body.number("lift"),
                    tilt: node.number("tilt"),
                };
                floating.pose(sea.as_ref())
            })
            .collect();
        match poses {
            Some(poses) => Ok(Box::new(Standing::new(RigidBodies::new(model, poses)))),
            None => Err(NodeError::new(
                "\"sea\": found a model; expected water to float on: connect a GerstnerSea, RippleSea or ToonSea",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{Frame, graph, refused};
    use std::path::Path;

    #[test]
    fn only_water_floats_things() {
        let nodes = |sea: &str| {
            format!(
                r#""c": {{ "type": "Camera" }}, "water": {{ "type": "RippleSea" }},
                "m": {{ "type": "BezierModel", "patches": [{{ "points": [{{ "at": [0, 0, 0] }}, {{ "at": [1, 0, 0] }},
                    {{ "at": [0, 0, 1] }}, {{ "at": [1, 0, 1] }}] }}] }},
                "f": {{ "type": "Float", "model": "m", "sea": "{sea}", "bodies": [{{ "x": 1 }}, {{ "x": 4 }}] }},
                "v": {{ "type": "Render", "camera": "c", "surfaces": ["f"] }},
                "out": {{ "type": "Depth", "view": "v" }}"#
            )
        };
        assert!(Frame::new(graph("field", &nodes("water"), Path::new(".")).unwrap()).is_ok());
        let faults = refused("field", &nodes("m"));
        assert!(faults.contains("which has no plane at rest") && faults.contains("RippleSea or ToonSea"), "{faults}");
    }
}

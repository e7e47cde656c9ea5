//! Light: directional, point, or spot.

use crate::scene_support::vector;
use trochoid_graph::*;
use trochoid_scene as scene;

pub(crate) static NODE: &dyn NodeType = &Light;

struct Light;

static DECLARATION: Declaration = Declaration {
    name: "Light",
    end: End::Front,
    summary: "A light as far as geometry is concerned: its color is the back end's business.",
    formula: "Directional: the unit vector along `direction`, which points toward the light. Point and spot: the \
              unit vector from the shading point to `position`; a spot's edge falls by t²(3 − 2t) over `soft`.",
    edge_cases: "No falloff with distance. In the light's own place, and for a direction of length 0, light comes \
                 from straight above.",
    source: "Thesis 3.2.3.1 (spotlight) and 3.2.3.2 (light source P_L).",
    items: &[
        Knob::choice("kind", &["directional", "point", "spot"], "What sort of light.").item(),
        Knob::vector("direction", &[0.3, 1.0, 0.5], "Toward the light, of any length; directional only.").item(),
        Knob::vector("position", &[0.0, 10.0, 0.0], "Where it stands; point and spot.").unit("m").item(),
        Knob::vector("target", &[0.0, 0.0, 0.0], "What it is aimed at; spot.").unit("m").item(),
        Knob::number("angle", 30.0, 0.0, 180.0, "Half angle of the cone; spot.").unit("degrees").item(),
        Knob::number("soft", 5.0, 0.0, 180.0, "Width of the soft edge inside the cone; spot.").unit("degrees").item(),
    ],
    outputs: &[Output::new("light", Kind::Light, "The light.")],
    revision: 1,
};

impl NodeType for Light {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if node.text("kind") == "directional" && node.vector3("direction") == [0.0; 3] {
            check.error("direction", "[0, 0, 0]", "a direction toward the light", "write for example [0, 1, 0]");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Light {
    fn formatted(&self) -> bool {
        false
    }

    fn prepare(&self, node: &Settled, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (position, target) = (vector(node, "position"), vector(node, "target"));
        Ok(Box::new(Shining(match node.text("kind") {
            "point" => scene::Light::Point { position },
            "spot" => scene::Light::Spot {
                position,
                target,
                angle: node.number("angle").to_radians(),
                soft: node.number("soft").to_radians(),
            },
            _ => scene::Light::Directional { direction: vector(node, "direction") },
        })))
    }
}

struct Shining(scene::Light);

impl Prepared for Shining {
    fn handle(&self) -> Option<Handle> {
        Some(std::sync::Arc::new(self.0))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(std::sync::Arc::new(self.0))])
    }
}

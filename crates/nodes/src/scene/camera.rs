//! Camera: a point of view.

use crate::scene_support::vector;
use trochoid_graph::*;
use trochoid_scene as scene;

pub(crate) static NODE: &dyn NodeType = &Camera;

struct Camera;

static DECLARATION: Declaration = Declaration {
    name: "Camera",
    end: End::Front,
    summary: "A point of view: where it stands, what it looks at, and how it projects.",
    formula: "The ray of a pixel leaves `position` through the picture plane; `fov` is the horizontal angle. \
              Orthographic rays are parallel, and the picture is `height` meters high.",
    edge_cases: "Position and target alike: it looks along −Z. Straight up or down: −Z or +Z is up in the picture.",
    source: "The field's convention: right-handed, Y up, the camera looks along its own −Z.",
    items: &[
        Knob::vector("position", &[0.0, 2.0, 10.0], "Where the camera stands.").unit("m").item(),
        Knob::vector("target", &[0.0, 0.0, 0.0], "The point at the center of the picture.").unit("m").item(),
        Knob::number("roll", 0.0, -360.0, 360.0, "Turn about the view axis, clockwise.").unit("degrees").item(),
        Knob::choice("projection", &["perspective", "orthographic"], "How rays leave the camera.").item(),
        Knob::number("fov", 50.0, 0.01, 179.0, "Horizontal angle of view, of a perspective camera.")
            .unit("degrees")
            .item(),
        Knob::number("height", 10.0, 1e-6, 1e9, "Height of the picture, of an orthographic camera.").unit("m").item(),
    ],
    outputs: &[Output::new("camera", Kind::Camera, "The camera.")],
    revision: 1,
};

/// Coordinates beyond this leave nothing of a scene.
const FARTHEST: f64 = 1e10;

impl NodeType for Camera {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        for knob in ["position", "target"] {
            let place = node.vector3(knob);
            if place.iter().any(|part| part.abs() > FARTHEST) {
                let expected = format!("coordinates within ±{FARTHEST:e} m, where a picture still shows something");
                check.error(knob, format!("{place:?}"), expected, "move the camera nearer to the scene");
            }
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Camera {
    fn formatted(&self) -> bool {
        false
    }

    fn prepare(&self, node: &Settled, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let projection = match node.text("projection") {
            "orthographic" => scene::Projection::Orthographic { height: node.number("height") },
            _ => scene::Projection::Perspective { fov: node.number("fov").to_radians() },
        };
        Ok(Box::new(Standing(scene::Camera {
            position: vector(node, "position"),
            target: vector(node, "target"),
            roll: node.number("roll").to_radians(),
            projection,
        })))
    }
}

struct Standing(scene::Camera);

impl Prepared for Standing {
    fn handle(&self) -> Option<Handle> {
        Some(std::sync::Arc::new(self.0))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(std::sync::Arc::new(self.0))])
    }
}

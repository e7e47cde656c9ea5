//! Camera: a point of view.

use super::Handed;
use trochoid_graph::*;
use trochoid_scene as scene;

/// A point of view: where it stands, what it looks at, and how it projects.
///
/// # Formula
/// The ray of a pixel leaves `position` through the picture plane; `fov` is the horizontal angle. Orthographic rays are
/// parallel, and the picture is `height` meters high.
///
/// # Edge cases
/// Position and target alike: it looks along −Z. Straight up or down: −Z or +Z is up in the picture.
///
/// # Source
/// The field's convention: right-handed, Y up, the camera looks along its own −Z.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, role = Camera, output(camera: Kind::Camera = "The camera."))]
#[also_called("Camera3D", "PerspectiveCamera", "Viewpoint")]
pub(crate) struct Camera {
    /// Where the camera stands.
    #[knob(default = [0.0, 2.0, 10.0], unit = "m")]
    pub(crate) position: [f64; 3],
    /// The point at the center of the picture.
    #[knob(default = [0.0; 3], unit = "m")]
    pub(crate) target: [f64; 3],
    /// Turn about the view axis, clockwise.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    pub(crate) roll: f64,
    /// How rays leave the camera.
    pub(crate) projection: Projection,
    /// Horizontal angle of view, of a perspective camera.
    #[knob(default = 50.0, range = 0.01..=179.0, unit = "degrees")]
    pub(crate) fov: f64,
    /// Height of the picture, of an orthographic camera.
    #[knob(default = 10.0, range = 1e-6..=1e9, unit = "m")]
    pub(crate) height: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Projection {
    Perspective,
    Orthographic,
}

/// Coordinates beyond this leave nothing of a scene.
const FARTHEST: f64 = 1e10;

impl Node for Camera {
    fn check(&self, check: &mut Check<'_>) {
        for (knob, place) in [(Self::POSITION, self.position), (Self::TARGET, self.target)] {
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

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let projection = match self.projection {
            Projection::Perspective => scene::Projection::Perspective { fov: self.fov.to_radians() },
            Projection::Orthographic => scene::Projection::Orthographic { height: self.height },
        };
        Ok(Box::new(Handed(scene::Camera {
            position: self.position.into(),
            target: self.target.into(),
            roll: self.roll.to_radians(),
            projection,
        })))
    }
}

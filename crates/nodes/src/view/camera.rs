//! Camera: a viewpoint.

use super::PreparedHandle;
use trochoid_graph::*;
use trochoid_scene as scene;

/// A viewpoint: position, target and projection.
///
/// # Formula
/// The ray of a pixel leaves `position` through the picture plane; `fov` is the horizontal angle. Orthographic rays
/// are parallel, and the picture is `height` meters high. Exactly: see Definitions in the book.
///
/// # Edge cases
/// A level orthographic camera sees a flat sea, and one whose crests it looks along, exactly from the side, as nothing. A
/// section of such a sea: look straight down, and clamp Height less the height that ScreenY stands for (the book has
/// an example). If position and target are equal, the camera looks along −Z. If it looks straight up or down, −Z or +Z points up in
/// the picture.
///
/// # Source
/// Field convention: right-handed, Y up, the camera looks along its own −Z.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, role = Camera, output(camera: Kind::Camera = "The camera."))]
#[also_called("Camera3D", "PerspectiveCamera", "Viewpoint")]
pub(crate) struct Camera {
    /// Position of the camera.
    #[knob(default = [0.0, 2.0, 10.0], unit = "m", places = Position)]
    pub(crate) position: [f64; 3],
    /// Point at the center of the picture.
    #[knob(default = [0.0; 3], unit = "m", places = Target)]
    pub(crate) target: [f64; 3],
    /// Clockwise rotation about the view axis.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    pub(crate) roll: f64,
    /// Projection: "perspective", or "orthographic" with parallel rays.
    pub(crate) projection: Projection,
    /// Horizontal angle of view, for perspective cameras.
    #[knob(default = 50.0, range = 0.01..=179.0, unit = "degrees")]
    pub(crate) fov: f64,
    /// Height of the picture, for orthographic cameras.
    #[knob(default = 10.0, range = 1e-6..=1e9, unit = "m")]
    pub(crate) height: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Projection {
    Perspective,
    Orthographic,
}

/// Largest coordinate; beyond it, nothing of a scene remains visible.
const FARTHEST: f64 = 1e10;

impl Node for Camera {
    fn check(&self, check: &mut Check<'_>) {
        for (knob, place) in [(Self::POSITION, self.position), (Self::TARGET, self.target)] {
            if place.iter().any(|part| part.abs() > FARTHEST) {
                let expected = format!("coordinates within ±{FARTHEST:e} m");
                check.error(knob, format!("{place:?}"), expected, "move the camera closer to the scene");
            }
        }
    }
}

impl Stage for Camera {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let projection = match self.projection {
            Projection::Perspective => scene::Projection::Perspective { fov: self.fov.to_radians() },
            Projection::Orthographic => scene::Projection::Orthographic { height: self.height },
        };
        Ok(Box::new(PreparedHandle(scene::Camera {
            position: self.position.into(),
            target: self.target.into(),
            roll: self.roll.to_radians(),
            projection,
        })))
    }
}

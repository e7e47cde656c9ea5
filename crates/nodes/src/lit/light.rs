//! Light: directional, point, or spot.

use crate::view::Handed;
use trochoid_graph::*;
use trochoid_scene as scene;

/// A light as far as geometry is concerned: its color is the back end's business.
///
/// # Formula
/// Directional: the unit vector along `direction`, which points toward the light. Point and spot: the unit vector from the
/// shading point to `position`; a spot's edge falls by t²(3 − 2t) over `soft`.
///
/// # Edge cases
/// No falloff with distance. In the light's own place, and for a direction of length 0, light comes from straight above.
///
/// # Source
/// Thesis 3.2.3.1 (spotlight) and 3.2.3.2 (light source P_L).
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, role = Light, output(light: Kind::Light = "The light."))]
#[also_called("DirectLight", "Sun", "PointLight", "SpotLight", "DistantLight")]
pub(crate) struct Light {
    /// What sort of light.
    kind: Sort,
    /// Toward the light, of any length; directional only.
    #[knob(default = [0.3, 1.0, 0.5])]
    direction: [f64; 3],
    /// Where it stands; point and spot.
    #[knob(default = [0.0, 10.0, 0.0], unit = "m")]
    position: [f64; 3],
    /// What it is aimed at; spot.
    #[knob(default = [0.0; 3], unit = "m")]
    target: [f64; 3],
    /// Half angle of the cone; spot.
    #[knob(default = 30.0, range = 0.0..=180.0, unit = "degrees")]
    angle: f64,
    /// Width of the soft edge inside the cone; spot.
    #[knob(default = 5.0, range = 0.0..=180.0, unit = "degrees")]
    soft: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Sort {
    Directional,
    Point,
    Spot,
}

impl Node for Light {
    fn check(&self, check: &mut Check<'_>) {
        if self.kind == Sort::Directional && self.direction == [0.0; 3] {
            check.error(Self::DIRECTION, "[0, 0, 0]", "a direction toward the light", "write for example [0, 1, 0]");
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

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (position, target) = (self.position.into(), self.target.into());
        Ok(Box::new(Handed(match self.kind {
            Sort::Directional => scene::Light::Directional { direction: self.direction.into() },
            Sort::Point => scene::Light::Point { position },
            Sort::Spot => {
                let [angle, soft] = [self.angle, self.soft].map(f64::to_radians);
                scene::Light::Spot { position, target, angle, soft }
            }
        })))
    }
}

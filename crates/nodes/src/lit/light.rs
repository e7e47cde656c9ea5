//! Light: a directional, point or spot light.

use crate::view::PreparedHandle;
use trochoid_graph::*;
use trochoid_scene as scene;

/// Defines a directional, point or spot light. Lights have no color: passes turn them into masks, and masks weight the
/// colors.
///
/// # Formula
/// Direction to the light: the unit vector along `direction` (directional), or from the shaded point to `position`
/// (point, spot). Intensity of a spot: t²(3 − 2t) with t = (`angle` − angle off the axis)/`soft`, limited to [0, 1].
///
/// # Edge cases
/// Intensity does not fall off with distance. At the position of the light itself, and for a direction of length 0, the
/// light comes from straight above. A disc drawn for a directional light (see `Shape`) belongs at x = A/2·(1 + r·d/(f·d)/T),
/// y = ½ − A/2·u·d/(f·d)/T in picture heights: d is `direction`, f, r and u point forward, right and up from the camera,
/// A = width/height, T = tan(fov/2).
///
/// # Source
/// Thesis 3.2.3.1 (spotlight) and 3.2.3.2 (light source P_L).
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, role = Light, output(light: Kind::Light = "The light."))]
#[also_called("DirectLight", "Sun", "PointLight", "SpotLight", "DistantLight")]
pub(crate) struct Light {
    /// Type of light: directional (like the sun), point or spot.
    kind: LightKind,
    /// Direction toward the light; its length does not matter. Directional lights only.
    #[knob(default = [0.3, 1.0, 0.5], places = Direction)]
    direction: [f64; 3],
    /// Position of the light. Point and spot lights only.
    #[knob(default = [0.0, 10.0, 0.0], unit = "m", places = Position)]
    position: [f64; 3],
    /// Point at which the light is aimed. Spot lights only.
    #[knob(default = [0.0; 3], unit = "m", places = Target)]
    target: [f64; 3],
    /// Half angle of the light's cone. Spot lights only.
    #[knob(default = 30.0, range = 0.0..=180.0, unit = "degrees")]
    angle: f64,
    /// Width of the soft edge inside the cone; 0 gives a hard edge. Spot lights only.
    #[knob(default = 5.0, range = 0.0..=180.0, unit = "degrees")]
    soft: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum LightKind {
    Directional,
    Point,
    Spot,
}

impl Node for Light {
    fn check(&self, check: &mut Check<'_>) {
        if self.kind == LightKind::Directional && self.direction == [0.0; 3] {
            check.error(Self::DIRECTION, "[0, 0, 0]", "a direction toward the light", "write for example [0, 1, 0]");
        }
    }
}

impl Stage for Light {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (position, target) = (self.position.into(), self.target.into());
        Ok(Box::new(PreparedHandle(match self.kind {
            LightKind::Directional => scene::Light::Directional { direction: self.direction.into() },
            LightKind::Point => scene::Light::Point { position },
            LightKind::Spot => {
                let [angle, soft] = [self.angle, self.soft].map(f64::to_radians);
                scene::Light::Spot { position, target, angle, soft }
            }
        })))
    }
}

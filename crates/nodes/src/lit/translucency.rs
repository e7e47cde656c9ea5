//! Translucency: light that shines through thin water.

use super::{Combine, Lights, eye, toward_eye};
use crate::view::{Facets, Quantity, Rays, Seen, Traces, Way};
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;

/// A mask of the light that shines through thin water toward the eye, such as crests against a low sun.
///
/// # Formula
/// exp(−t/a)·fᵖ, times the light's intensity there; t is the thickness toward the light as Thickness has it, a =
/// `absorption`, f = (1 − V · L)/2, 1 where the eye looks into the light, p = `facing`.
///
/// # Edge cases
/// 0 where nothing is seen, and where water lies all the way to a light below the horizon. Facing 0 takes light from
/// anywhere.
///
/// # Source
/// Thesis 3.1.2: translucent crests; the law of Beer and Lambert.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "How much light shines through."))]
pub(crate) struct Translucency {
    /// What is seen, a Render.
    view: One<port::View>,
    /// What shines through.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How several lights become one mask.
    combine: Combine,
    /// Thickness that leaves 1/e = 37 % of the light.
    #[knob(default = 2.5, range = 1e-6..=1e6, unit = "m")]
    absorption: f64,
    /// How strictly the eye has to look toward the light.
    #[knob(default = 2.0, range = 0.0..=100.0)]
    facing: f64,
    #[items]
    way: Way,
    #[items]
    facets: Facets,
}

impl Traces for Translucency {
    const RATE: Rate = Rate::Surface;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError> {
        let eye = eye(prepare, &self.view, prepare.frame.format)?;
        let lights = Lights::of(&self.lights, self.combine, prepare)?;
        let &Self { absorption, facing: power, way, .. } = self;
        Ok(Box::new(move |seen: &Seen, rays: Rays<'_>| {
            let view = unit_or_up(toward_eye(&eye, seen.point));
            lights.reference(seen.point, |light| {
                let facing = (0.5 * (1.0 - view.dot(light))).clamp(0.0, 1.0);
                let length = way.length(seen, light, rays.first);
                libm::exp(-length / absorption) * libm::pow(facing, power)
            })
        }))
    }
}

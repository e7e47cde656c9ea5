//! Translucency: light that shines through thin water toward the eye.

use super::{Combine, Lights, eye, toward_eye};
use crate::view::{Facets, PathKnobs, Quantity, RayQuantity, Rays, SeenPoint};
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;

/// A mask of the light that shines through thin water toward the eye, for example through crests in front of a low sun.
///
/// # Formula
/// exp(−t/a)·fᵖ, times the intensity of the light at this point. t is the thickness of the water toward the light, as
/// the node Thickness measures it; a = `absorption`; f = (1 − V · L)/2, which is 1 where the eye looks straight into
/// the light; p = `facing`.
///
/// # Edge cases
/// 0 where no surface is seen. Toward a light below the horizon the water has no end; then t = `distance`, which leaves
/// almost no light. With `facing` 0, light counts from all directions alike.
///
/// # Source
/// Thesis 3.1.2: translucent crests; the Beer–Lambert law.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The light that shines through."))]
pub(crate) struct Translucency {
    /// View of the water, from a Render.
    view: One<port::View>,
    /// Lights that shine through the water.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How the masks of several lights are combined: screen, max or mean.
    combine: Combine,
    /// Thickness of water that lets 1/e = 37 % of the light through.
    #[knob(default = 2.5, range = 1e-6..=1e6, unit = "m")]
    absorption: f64,
    /// Exponent; larger values show only light that comes straight toward the eye, 0 shows light from all directions.
    #[knob(default = 2.0, range = 0.0..=100.0)]
    facing: f64,
    #[items]
    path_knobs: PathKnobs,
    #[items]
    facets: Facets,
}

impl RayQuantity for Translucency {
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
        let &Self { absorption, facing: power, path_knobs, .. } = self;
        Ok(Box::new(move |seen: &[SeenPoint], rays: &dyn Rays| {
            let starts = path_knobs.starts(seen, rays);
            lights.within_reach(seen.iter().map(|seen| seen.point), |lit| {
                let paths = lit.iter().map(|lit| (starts[lit.index], lit.direction));
                let lengths = path_knobs.lengths(paths, rays);
                let masks = lit.iter().zip(&lengths).map(|(lit, length)| {
                    let view = unit_or_up(toward_eye(&eye, seen[lit.index].point));
                    let facing = (0.5 * (1.0 - view.dot(lit.direction))).clamp(0.0, 1.0);
                    libm::exp(-length / absorption) * libm::pow(facing, power)
                });
                masks.collect()
            })
        }))
    }
}

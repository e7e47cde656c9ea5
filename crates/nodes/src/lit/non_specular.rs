//! NonSpecular: diffuse shading, that is everything but reflections.

use super::{BoundedDirection, Combine, Facing, LitShader, Vectors3};
use trochoid_graph::*;
use trochoid_scene::DVec3;
use trochoid_scene::shading::lambert;

/// A mask of diffuse light on the surface: Lambert's cosine, mapped from [−1, 1] to [0, 1].
///
/// # Formula
/// Cᵖ with C = (N · L + 1)/2 and p = `power`, times the intensity of the light at this point
///
/// # Edge cases
/// 0 where no surface is seen. A degenerate normal counts as pointing up.
///
/// # Source
/// Thesis 3.2.3.2; `power` 2 is its C².
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, role = Clay, output(mask: Kind::MASK = "The diffuse light."))]
#[also_called("Diffuse", "Lambert", "Shading")]
pub(crate) struct NonSpecular {
    /// View of the surfaces that are lit.
    view: One<port::View>,
    /// Lights that shine on the surfaces.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How the masks of several lights are combined: screen, max or mean.
    combine: Combine,
    /// Exponent applied to the mask; 1 leaves it unchanged, larger values darken its mid-tones, smaller ones brighten
    /// them.
    #[knob(default = 1.0, range = 0.01..=100.0)]
    power: f64,
}

impl LitShader for NonSpecular {
    const NEEDS_EYE: bool = false;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn lights(&self) -> (&Many<port::Light>, Combine) {
        (&self.lights, self.combine)
    }

    fn fill(&self, seen: Facing<Vectors3<'_>, &[f32]>, light: Vectors3<'_>, mask: &mut [f32]) {
        lambert::fill(seen.normal, light, self.power as f32, mask);
    }

    fn reference(&self, seen: Facing<DVec3, f64>, light: DVec3) -> f64 {
        lambert::reference(seen.normal, light, self.power)
    }

    fn span(&self, seen: Facing<BoundedDirection, Span>, light: BoundedDirection) -> Span {
        seen.normal.cosine(light).through(|cosine| libm::pow((cosine + 1.0) / 2.0, self.power))
    }
}

//! Fresnel: how much of the light a surface reflects, by the angle at which it is seen.

use super::{BoundedDirection, Combine, Facing, LitShader, Vectors3};
use trochoid_graph::*;
use trochoid_scene::DVec3;
use trochoid_scene::shading::fresnel;

/// A mask of the fraction of light that the surface reflects, which grows toward grazing angles.
///
/// # Formula
/// F₀ + (1 − F₀)(1 − cos θ)⁵ with F₀ = ((η − 1)/(η + 1))²; cos θ = N · V, or, if `cosine` is half, H · V,
/// times the intensity of the light at this point
///
/// # Edge cases
/// 0 where no surface is seen. With `cosine` view, 1 where the surface faces away from the eye. η = 1 reflects at
/// grazing angles only. Where light and eye are in opposite directions, H · V is 0.
///
/// # Source
/// Thesis 3.2.3.3; Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The reflected fraction."))]
pub(crate) struct Fresnel {
    /// View of the reflecting surfaces.
    view: One<port::View>,
    /// Lights that define the half vector H; used only if `cosine` is half.
    #[port(0..=64)]
    lights: Many<port::Light>,
    /// How the masks of several lights are combined: screen, max or mean.
    combine: Combine,
    /// Index of refraction of the surface relative to its surroundings; 1.333 is water in air.
    #[knob(default = 1.333, range = 1e-3..=1e3)]
    eta: f64,
    /// Cosine in the formula: view is N · V (normal and view direction); half is H · V (half vector and view
    /// direction), as in the thesis.
    cosine: Cosine,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Cosine {
    View,
    Half,
}

impl From<Cosine> for fresnel::Cosine {
    fn from(cosine: Cosine) -> Self {
        match cosine {
            Cosine::View => Self::View,
            Cosine::Half => Self::Half,
        }
    }
}

impl LitShader for Fresnel {
    const NEEDS_EYE: bool = true;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn lights(&self) -> (&Many<port::Light>, Combine) {
        (&self.lights, self.combine)
    }

    fn is_lit(&self) -> bool {
        self.cosine == Cosine::Half
    }

    fn check(&self, check: &mut Check<'_>) {
        if self.cosine == Cosine::Half && self.lights.is_empty() {
            let remedy = "connect \"lights\", or use \"view\"";
            check.error(Self::COSINE, "half without lights", "at least one light", remedy);
        }
    }

    fn fill(&self, seen: Facing<Vectors3<'_>, &[f32]>, light: Vectors3<'_>, mask: &mut [f32]) {
        fresnel::fill(seen.normal, light, seen.eye, self.eta, self.cosine.into(), mask);
    }

    fn reference(&self, seen: Facing<DVec3, f64>, light: DVec3) -> f64 {
        fresnel::reference(seen.normal, light, seen.eye, self.eta, self.cosine.into())
    }

    fn span(&self, seen: Facing<BoundedDirection, Span>, light: BoundedDirection) -> Span {
        let cosine = match self.cosine {
            Cosine::View => seen.normal.cosine(seen.eye),
            Cosine::Half => light.half_cosine(seen.eye),
        };
        cosine.through(|cosine| fresnel::schlick(cosine, self.eta))
    }
}

//! Fresnel: how much of what reaches the eye is mirrored.

use super::{Combine, Facing, Shades, Toward, Vectors3};
use trochoid_graph::*;
use trochoid_scene::DVec3;
use trochoid_scene::shading::fresnel;

/// A mask of the share of light that the surface mirrors, which grows toward grazing angles.
///
/// # Formula
/// F₀ + (1 − F₀)(1 − cos θ)⁵, F₀ = ((η − 1)/(η + 1))²; cos θ = N · V, or H · V with `cosine` half
///
/// # Edge cases
/// 0 where nothing is seen; 1 where the surface faces away from the eye. η = 1 mirrors at grazing angles only.
///
/// # Source
/// Thesis 3.2.3.3; Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The mirrored share."))]
pub(crate) struct Fresnel {
    /// What mirrors.
    view: One<port::View>,
    /// The lights of H; for `cosine` half only.
    #[port(0..=64)]
    lights: Many<port::Light>,
    /// How several lights become one mask.
    combine: Combine,
    /// Ratio of refractive indices; 1.333 is air to water.
    #[knob(default = 1.333, range = 1e-3..=1e3)]
    eta: f64,
    /// N · V, or the thesis' H · V.
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

impl Shades for Fresnel {
    const LOOKS: bool = true;

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

    fn span(&self, seen: Facing<Toward, Span>, light: Toward) -> Span {
        let cosine = match self.cosine {
            Cosine::View => seen.normal.cosine(seen.eye),
            Cosine::Half => light.half_cosine(seen.eye),
        };
        cosine.through(|cosine| fresnel::schlick(cosine, self.eta))
    }
}

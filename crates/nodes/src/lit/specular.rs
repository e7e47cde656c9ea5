//! Specular: highlights, where a surface mirrors lights toward the eye.

use super::{BoundedDirection, Combine, Facing, LitShader, Vectors3};
use crate::view::POSITION;
use std::f64::consts::FRAC_PI_2;
use trochoid_graph::*;
use trochoid_scene::DVec3;
use trochoid_scene::shading::blinn;

/// A mask of the specular highlights: the blurred mirror images of lights in the surface.
///
/// # Formula
/// half: (N · H)ˢ, computed as exp(s · log1p(−½|N − H|²)), with H halfway between light and eye. reflection: (R · V)ˢ.
/// s = `shininess`/(1 + m·`shininess`·σ²), with m = ½ (half) or 2 (reflection), and σ² the slope variance of waves
/// smaller than the pixel footprint, which were filtered out. Times the intensity of the light at this point.
///
/// # Edge cases
/// 0 where no surface is seen, where the surface faces away from the light, and where light and eye are in opposite
/// directions.
///
/// # Source
/// Thesis 3.2.3.1, R = I − 2N(N · I); Blinn, Models of Light Reflection, 1977.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The highlights."))]
#[also_called("Phong", "Highlight", "Glossy", "BlinnPhong")]
pub(crate) struct Specular {
    /// View of the reflecting surfaces.
    view: One<port::View>,
    /// Lights that are reflected.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How the masks of several lights are combined: screen, max or mean.
    combine: Combine,
    /// Exponent; larger values give smaller, sharper highlights.
    #[knob(default = 60.0, range = 0.0..=1e6)]
    shininess: f64,
    /// Reflection model: half uses Blinn's half vector; reflection uses the mirrored direction, as in the thesis.
    model: Model,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Model {
    Half,
    Reflection,
}

impl From<Model> for blinn::Model {
    fn from(model: Model) -> Self {
        match model {
            Model::Half => Self::Half,
            Model::Reflection => Self::Reflection,
        }
    }
}

impl LitShader for Specular {
    const NEEDS_EYE: bool = true;
    const OPTIONAL_CHANNELS: ChannelSet = ChannelSet::of(&POSITION).union(ChannelSet::of(&[Channel::SlopeVariance]));

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn lights(&self) -> (&Many<port::Light>, Combine) {
        (&self.lights, self.combine)
    }

    fn fill(&self, seen: Facing<Vectors3<'_>, &[f32]>, light: Vectors3<'_>, mask: &mut [f32]) {
        let Facing { normal, eye, variance } = seen;
        blinn::fill(normal, light, eye, self.shininess as f32, variance, self.model.into(), mask);
    }

    fn reference(&self, seen: Facing<DVec3, f64>, light: DVec3) -> f64 {
        blinn::reference(seen.normal, light, seen.eye, self.shininess, seen.variance, self.model.into())
    }

    fn span(&self, seen: Facing<BoundedDirection, Span>, light: BoundedDirection) -> Span {
        let widened = |variance| blinn::widened(self.shininess, variance, self.model.into());
        let exponents = seen.variance.through(widened).within(0.0, self.shininess);
        self.lobe([seen.normal, light, seen.eye], exponents)
    }
}

impl Specular {
    /// Returns the span of one light's lobe over a span of exponents.
    fn lobe(&self, [normal, light, view]: [BoundedDirection; 3], exponents: Span) -> Span {
        let apart = match self.model {
            Model::Half => normal.angle(light.halfway(view)),
            Model::Reflection => normal.mirrored(light).angle(view),
        };
        let of = |angle: f64, exponent: f64| {
            let away = 2.0 * libm::sin(angle / 2.0) * libm::sin(angle / 2.0);
            if angle < FRAC_PI_2 { libm::exp(exponent * libm::log1p(-away.min(1.0))) } else { 0.0 }
        };
        let jumps = exponents.low == 0.0 && apart.holds(FRAC_PI_2);
        let lobe = Span::of(&[of(apart.high, exponents.high), of(apart.low, exponents.low)]).within(0.0, 1.0);
        let lobe = lobe.with(apart.clear && exponents.clear && !jumps);
        // A light behind the surface gives no highlight.
        let faces = normal.angle(light);
        if faces.low > FRAC_PI_2 {
            Span::exactly(0.0).with(faces.clear)
        } else if faces.high < FRAC_PI_2 {
            lobe
        } else {
            let is_dark = lobe.low == lobe.high && lobe.low == 0.0;
            lobe.or(Span::exactly(0.0)).with(is_dark)
        }
    }
}

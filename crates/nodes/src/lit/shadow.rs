//! Shadow: shadows cast by the surfaces of a view, found by rays toward the lights.

use super::{Combine, Lights, Lit};
use crate::view::{Facets, Quantity, RayQuantity, Rays, SeenPoint, landed};
use std::f64::consts::TAU;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_memory::Scratch;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Ray, Segment};

/// A mask of the shadows that the surfaces of a view cast on each other and on themselves.
///
/// # Formula
/// 1 − the fraction of `rays` that reach the light, times its intensity at this point, combined over the lights. Ray i
/// of n goes from P + bN toward L + tan(size/2)·r(u cos φ + v sin φ) with r² = (i + ½)/n, φ = i·2π/Φ² + 2π·frac(0.7549x
/// + 0.5698y), x and y in pixels; b = `bias` facets; P is the shaded point, moved onto the facets that rays meet.
///
/// # Edge cases
/// 0 where no surface is seen; 1 outside the cone of a spot light. A sea blocks a light below the horizon, and blocks
/// all light from its underside. Only surfaces within the picture, extended by `beyond` on each side, cast shadows.
///
/// # Source
/// Whitted, An Improved Illumination Model for Shaded Display, 1980; Vogel, A Better Way to Construct the Sunflower Head,
/// 1979; Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018.
#[derive(Clone, Node)]
#[node(end = Front, revision = 2, output(mask: Kind::MASK = "The shadow: 1 where no light arrives."))]
pub(crate) struct Shadow {
    /// View of the surfaces that cast and receive shadows, from a Render.
    view: One<port::View>,
    /// Lights that cast the shadows.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How the light of several lights is combined into one mask: screen, max or mean.
    combine: Combine,
    /// Angular diameter of the light; larger lights cast softer shadows. The sun has 0.53; 0 gives hard shadows.
    #[knob(default = 0.0, range = 0.0..=90.0, unit = "degrees")]
    size: f64,
    /// Number of rays from each sample to each light; lights of size 0 need only one.
    #[knob(default = 4, range = 1..=256)]
    rays: i64,
    /// Largest distance at which a surface casts shadows.
    #[knob(default = 500.0, range = 1e-3..=1e7, unit = "m")]
    distance: f64,
    /// Height above the surface at which rays start, in facets, so that they do not hit the facet they start from.
    #[knob(default = 1.5, range = 0.0..=1e3)]
    bias: f64,
    #[items]
    facets: Facets,
}

impl RayQuantity for Shadow {
    const RATE: Rate = Rate::Surface;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn work(&self, format: Format) -> Option<Work> {
        // Seconds for a ray, including the one that moves the point onto the facets.
        const RAY: f64 = 6e-8;
        let rays = if self.size > 0.0 { self.rays as f64 } else { 1.0 };
        let samples = format.window().area() as f64 * format.samples() as f64;
        let seconds = samples * (1.0 + rays * self.lights.len() as f64) * RAY;
        let remedy = "lower \"rays\", the number of lights, or the format's \"samples\"";
        Some(Work { seconds, item: Self::RAYS, remedy })
    }

    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError> {
        let lights = Lights::of(&self.lights, self.combine, prepare)?;
        let spread = libm::tan(0.5 * self.size.to_radians());
        // A light of size 0 is a point: all its rays would be the same.
        let rays = if spread > 0.0 { self.rays as u32 } else { 1 };
        let shadow = PreparedShadow { node: self.clone(), lights, spread, rays };
        Ok(Box::new(move |seen: &[SeenPoint], rays: &dyn Rays| shadow.masks(seen, rays)))
    }
}

struct PreparedShadow {
    node: Shadow,
    lights: Lights,
    /// Tangent of half the light's angular diameter.
    spread: f64,
    rays: u32,
}

/// 2π/Φ², the golden angle.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// 1/ρ and 1/ρ², ρ³ = ρ + 1: the golden ratios of two dimensions.
const PLASTIC: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

impl PreparedShadow {
    fn masks(&self, seen: &[SeenPoint], rays: &dyn Rays) -> Scratch<f64> {
        let landed = landed(seen, rays);
        let landed = landed.iter().zip(seen);
        let origins: Scratch<DVec3> =
            landed.map(|(landed, seen)| *landed + seen.normal * (self.node.bias * seen.facet)).collect();
        // Rotate the rays as differently as possible from those of neighboring pixels.
        let turn = |seen: &SeenPoint| {
            let turn = PLASTIC[0] * seen.at[0] + PLASTIC[1] * seen.at[1];
            TAU * (turn - turn.floor())
        };
        let turns: Scratch<f64> = seen.iter().map(turn).collect();
        let lit = self.lights.within_reach(seen.iter().map(|seen| seen.point), |lit| {
            let mut arrived = Scratch::of(0_u32, lit.len());
            for index in 0..self.rays {
                let radius = self.spread * ((f64::from(index) + 0.5) / f64::from(self.rays)).sqrt();
                let segment = |lit: &Lit| {
                    let aside = if self.spread > 0.0 {
                        let (u, v) = lit.direction.any_orthonormal_pair();
                        let (sin, cos) = libm::sincos(f64::from(index) * GOLDEN + turns[lit.index]);
                        (u * cos + v * sin) * radius
                    } else {
                        DVec3::ZERO
                    };
                    let direction = unit_or_up(lit.direction + aside);
                    let ray = Ray { origin: origins[lit.index], direction };
                    Segment { ray, limit: self.node.distance.min(lit.reach) }
                };
                let segments: Scratch<Segment> = lit.iter().map(segment).collect();
                for (arrived, blocked) in arrived.iter_mut().zip(&rays.blocks(&segments)) {
                    *arrived += u32::from(!blocked);
                }
            }
            arrived.iter().map(|arrived| f64::from(*arrived) / f64::from(self.rays)).collect()
        });
        lit.iter().map(|lit| 1.0 - lit).collect()
    }
}

//! Shadow: what keeps the light away.

use super::{Combine, Lights};
use crate::view::{Facets, Quantity, Rays, Seen, Traces, landed};
use std::f64::consts::TAU;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::Ray;
use trochoid_scene::shading::unit_or_up;

/// A mask of the shadows that the view's surfaces cast on each other and themselves.
///
/// # Formula
/// 1 − the share of `rays` that reach the light, combined over the lights, each times its intensity there. Ray i of n goes
/// from P + bN toward L + tan(size/2)·r(u cos φ + v sin φ), r² = (i + ½)/n, φ = i·2π/Φ² + 2π·frac(0.7549x + 0.5698y), with
/// x and y in pixels; b = `bias` facets; P on the surface as rays meet it.
///
/// # Edge cases
/// 0 where nothing is seen, 1 where a spot does not shine. A light below the horizon is kept away by the sea, and all light
/// is from what is seen of it from below. Surfaces count as far as the picture, made wider by `beyond`, holds them.
///
/// # Source
/// Whitted, An Improved Illumination Model for Shaded Display, 1980; Vogel, A Better Way to Construct the Sunflower Head,
/// 1979; Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "1 where no light arrives."))]
pub(crate) struct Shadow {
    /// What casts shadows and carries them, a Render.
    view: One<port::View>,
    /// What is kept away.
    #[port(1..=64)]
    lights: Many<port::Light>,
    /// How the light of several lights becomes one mask.
    combine: Combine,
    /// How large the light looks: the larger, the softer. The sun has 0.53.
    #[knob(default = 0.0, range = 0.0..=90.0, unit = "degrees")]
    size: f64,
    /// How many rays a sample sends to a light that has a size.
    #[knob(default = 4, range = 1..=256)]
    rays: i64,
    /// How far away what casts shadows may be.
    #[knob(default = 500.0, range = 1e-3..=1e7, unit = "m")]
    distance: f64,
    /// How far above the surface rays begin, in facets, so that they do not meet the facets on which they begin.
    #[knob(default = 1.5, range = 0.0..=1e3)]
    bias: f64,
    #[items]
    facets: Facets,
}

impl Traces for Shadow {
    const RATE: Rate = Rate::Sample;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn work(&self, format: Format) -> Option<Work> {
        // A ray, and the one that lands on the surface that rays meet.
        const RAY: f64 = 2.5e-7;
        let rays = if self.size > 0.0 { self.rays as f64 } else { 1.0 };
        let samples = format.window().area() as f64 * format.samples() as f64;
        let seconds = samples * (1.0 + rays * self.lights.len() as f64) * RAY;
        let remedy = "lower \"rays\", the number of lights, or the format's \"samples\"";
        Some(Work { seconds, item: Self::RAYS, remedy })
    }

    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError> {
        let lights = Lights::of(&self.lights, self.combine, prepare)?;
        let spread = libm::tan(0.5 * self.size.to_radians());
        // A light without size is one point, whatever number of rays.
        let rays = if spread > 0.0 { self.rays as u32 } else { 1 };
        let shadow = PreparedShadow { node: self.clone(), lights, spread, rays };
        Ok(Box::new(move |seen: &Seen, rays: Rays<'_>| shadow.mask(seen, rays)))
    }
}

struct PreparedShadow {
    node: Shadow,
    lights: Lights,
    /// Tangent of half the angle under which the light is seen.
    spread: f64,
    rays: u32,
}

/// 2π/Φ², the golden angle.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// 1/ρ and 1/ρ², ρ³ = ρ + 1: the golden ratios of two dimensions.
const PLASTIC: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

impl PreparedShadow {
    fn mask(&self, seen: &Seen, rays: Rays<'_>) -> f64 {
        let &Seen { at, point, normal, facet } = seen;
        let origin = landed(point, normal, facet, rays.first) + normal * (self.node.bias * facet);
        // Neighbors turn their rays as differently as can be.
        let turn = PLASTIC[0] * at[0] + PLASTIC[1] * at[1];
        let turn = TAU * (turn - turn.floor());
        let lit = self.lights.within_reach(point, |light, reach| {
            let (u, v) = light.any_orthonormal_pair();
            let limit = self.node.distance.min(reach);
            let arrives = |index: &u32| {
                let radius = self.spread * ((f64::from(*index) + 0.5) / f64::from(self.rays)).sqrt();
                let (sin, cos) = libm::sincos(f64::from(*index) * GOLDEN + turn);
                let direction = unit_or_up(light + (u * cos + v * sin) * radius);
                !(rays.blocks)(&Ray { origin, direction }, limit)
            };
            (0..self.rays).filter(arrives).count() as f64 / f64::from(self.rays)
        });
        1.0 - lit
    }
}

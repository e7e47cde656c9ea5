//! Shadow: what keeps the light away.

use crate::front_support::{Span, bound_by, where_covered};
use crate::scene_support::{
    BEYOND, COMBINE, DETAIL, Lights, Rays, Seen, Surroundings, asked, check_surfaces, landed, memory,
};
use std::f64::consts::TAU;
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::Ray;
use trochoid_scene::shading::unit_or_up;

pub(crate) static NODE: &dyn NodeType = &Shadow;

struct Shadow;

static DECLARATION: Declaration = Declaration {
    name: "Shadow",
    end: End::Front,
    summary: "A mask of the shadows that the view's surfaces cast on each other and themselves.",
    formula: "1 − the share of `rays` that reach the light, combined over the lights, each times its intensity there. \
              Ray i of n goes from P + bN toward L + tan(size/2)·r(u cos φ + v sin φ), r² = (i + ½)/n, φ = i·2π/Φ² + \
              2π·frac(0.7549x + 0.5698y), with x and y in pixels; b = `bias` \
              facets; P on the surface as rays meet it.",
    edge_cases: "0 where nothing is seen, 1 where a spot does not shine. A light below the horizon is kept away by \
                 the sea, and all light is from what is seen of it from below. Surfaces count as far as the picture, \
                 made wider by `beyond`, holds them.",
    source: "Whitted, An Improved Illumination Model for Shaded Display, 1980; Vogel, A Better Way to Construct the \
             Sunflower Head, 1979; Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018.",
    items: &[
        Port::one("view", Accepts::View, "What casts shadows and carries them, a Render."),
        Port::many("lights", Accepts::Light, 1, 64, "What is kept away."),
        Knob::choice("combine", COMBINE, "How the light of several lights becomes one mask.").item(),
        Knob::number("size", 0.0, 0.0, 90.0, "How large the light looks: the larger, the softer. The sun has 0.53.")
            .unit("degrees")
            .item(),
        Knob::integer("rays", 4, 1, 256, "How many rays a sample sends to a light that has a size.").item(),
        Knob::number("distance", 500.0, 1e-3, 1e7, "How far away what casts shadows may be.").unit("m").item(),
        Knob::number(
            "bias",
            1.5,
            0.0,
            1e3,
            "How far above the surface rays begin, in facets, so that they do not meet \
                                             the facets on which they begin.",
        )
        .item(),
        DETAIL,
        BEYOND,
    ],
    outputs: &[Output::new("mask", Kind::MASK, "1 where no light arrives.")],
    revision: 1,
};

impl NodeType for Shadow {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_surfaces(node, check);
    }

    fn work(&self, node: &Settled, format: Format, _time: f64) -> Option<Work> {
        // A ray, and the one that lands on the surface that rays meet.
        const RAY: f64 = 2.5e-7;
        let rays = if node.number("size") > 0.0 { node.integer("rays") as f64 } else { 1.0 };
        let samples = format.window().area() as f64 * format.samples() as f64;
        let seconds = samples * (1.0 + rays * node.all("lights").len() as f64) * RAY;
        let remedy = "lower \"rays\", the number of lights, or the format's \"samples\"";
        Some(Work { seconds, item: "rays", remedy })
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Shadow {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        asked()
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory::of_surroundings(node, reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let spread = libm::tan(0.5 * node.number("size").to_radians());
        // A light without size is one point, whatever number of rays.
        let rays = if spread > 0.0 { node.integer("rays") } else { 1 };
        Ok(Box::new(Shadowed {
            node: node.clone(),
            surroundings: Surroundings::of(node, prepare)?,
            lights: Lights::of(node, prepare)?,
            spread,
            rays: rays as u32,
            distance: node.number("distance"),
            bias: node.number("bias"),
        }))
    }
}

struct Shadowed {
    node: Settled,
    surroundings: Arc<Surroundings>,
    lights: Lights,
    /// Tangent of half the angle under which the light is seen.
    spread: f64,
    rays: u32,
    distance: f64,
    bias: f64,
}

/// 2π/Φ², the golden angle.
const GOLDEN: f64 = 2.399_963_229_728_653;

impl Shadowed {
    fn mask(&self, seen: &Seen, rays: Rays<'_>) -> f64 {
        let &Seen { at, point, normal, facet } = seen;
        let origin = landed(point, normal, facet, rays.first) + normal * (self.bias * facet);
        // Two-dimensional golden ratios: neighbors turn their rays as differently as can be.
        let turn = 0.754_877_666_246_693 * at[0] + 0.569_840_290_998_053 * at[1];
        let turn = TAU * (turn - turn.floor());
        let lit = self.lights.within_reach(point, |light, reach| {
            let (u, v) = light.any_orthonormal_pair();
            let limit = self.distance.min(reach);
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

impl Prepared for Shadowed {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        self.surroundings.fill(block, inputs, mask, |seen, rays| self.mask(seen, rays))
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // The reference's rays meet the surfaces themselves: facets may let them pass, or stop them.
        bound_by(bounding, outputs, (0, 0), |sample| where_covered(bounding, sample, || Span::unclear(0.0, 1.0)));
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let quantity = |seen: &Seen, rays: Rays<'_>| self.mask(seen, rays);
        Ok(vec![Reference::Mask(self.surroundings.quantity_reference(&self.node, inputs, quantity))])
    }

    fn bytes(&self) -> usize {
        self.surroundings.bytes()
    }
}

//! Translucency: light that shines through thin water.

use crate::front_support::{Span, bound_by, where_covered};
use crate::scene_support::{
    BEYOND, COMBINE, DETAIL, DISTANCE, INSET, Lights, Rays, Seen, Surroundings, Way, asked, check_surfaces, eye,
    memory, toward_eye,
};
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_scene::Projector;
use trochoid_scene::shading::unit_or_up;

pub(crate) static NODE: &dyn NodeType = &Translucency;

struct Translucency;

static DECLARATION: Declaration = Declaration {
    name: "Translucency",
    end: End::Front,
    summary: "A mask of the light that shines through thin water toward the eye, such as crests against a low sun.",
    formula: "exp(−t/a)·fᵖ, times the light's intensity there; t is the thickness toward the light as Thickness has \
              it, a = `absorption`, f = (1 − V · L)/2, 1 where the eye looks into the light, p = `facing`.",
    edge_cases: "0 where nothing is seen, and where water lies all the way to a light below the horizon. Facing 0 \
                 takes light from anywhere.",
    source: "Thesis 3.1.2: translucent crests; the law of Beer and Lambert.",
    items: &[
        Port::one("view", Accepts::View, "What is seen, a Render."),
        Port::many("lights", Accepts::Light, 1, 64, "What shines through."),
        Knob::choice("combine", COMBINE, "How several lights become one mask.").item(),
        Knob::number("absorption", 2.5, 1e-6, 1e6, "Thickness that leaves 1/e = 37 % of the light.").unit("m").item(),
        Knob::number("facing", 2.0, 0.0, 100.0, "How strictly the eye has to look toward the light.").item(),
        INSET,
        DISTANCE,
        DETAIL,
        BEYOND,
    ],
    outputs: &[Output::new("mask", Kind::MASK, "How much light shines through.")],
    revision: 1,
};

impl NodeType for Translucency {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_surfaces(node, check);
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Translucency {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        asked()
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory::of_surroundings(node, reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Glowing {
            node: node.clone(),
            surroundings: Surroundings::of(node, prepare)?,
            eye: eye(node, prepare, prepare.frame.format)?,
            lights: Lights::of(node, prepare)?,
            absorption: node.number("absorption"),
            facing: node.number("facing"),
            way: Way::of(node),
        }))
    }
}

struct Glowing {
    node: Settled,
    surroundings: Arc<Surroundings>,
    eye: Projector,
    lights: Lights,
    absorption: f64,
    facing: f64,
    way: Way,
}

impl Glowing {
    fn mask(&self, seen: &Seen, rays: Rays<'_>) -> f64 {
        let view = unit_or_up(toward_eye(&self.eye, seen.point));
        self.lights.reference(seen.point, |light| {
            let facing = (0.5 * (1.0 - view.dot(light))).clamp(0.0, 1.0);
            let length = self.way.length(seen, light, rays.first);
            libm::exp(-length / self.absorption) * libm::pow(facing, self.facing)
        })
    }
}

impl Prepared for Glowing {
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

//! Translucency: light that shines through thin water.

use crate::scene_support::{
    BEYOND, COMBINE, DETAIL, DISTANCE, First, INSET, Lights, NORMAL, POSITION, Surroundings, Way, eye, is_covered,
    nothing, toward_eye, view_planes, view_vector,
};
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Projector};

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

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Translucency {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(ChannelSet::of(&POSITION)).union(ViewChannel::Coverage.into())
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
    fn mask(&self, point: DVec3, normal: DVec3, first: First<'_>) -> f64 {
        let (normal, facet) = (unit_or_up(normal), self.surroundings.facet(point));
        let view = unit_or_up(toward_eye(&self.eye, point));
        self.lights.reference(point, |light| {
            let facing = (0.5 * (1.0 - view.dot(light))).clamp(0.0, 1.0);
            let length = self.way.length(point, normal, light, facet, first);
            libm::exp(-length / self.absorption) * libm::pow(facing, self.facing)
        })
    }
}

impl Prepared for Glowing {
    fn fill(&self, _block: &Block, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        let (points, normals) = (view_planes(inputs, POSITION), view_planes(inputs, NORMAL));
        let coverage = inputs.view("view", ViewChannel::Coverage);
        let vector = |planes: [&[f32]; 3], index: usize| DVec3::from(planes.map(|plane| f64::from(plane[index])));
        for (index, mask) in mask.iter_mut().enumerate() {
            *mask = if coverage[index] > 0.0 {
                let first = |ray: &_, limit| self.surroundings.first(ray, limit);
                self.mask(vector(points, index), vector(normals, index), &first) as f32
            } else {
                0.0
            };
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(&self.node, inputs) {
            return Ok(nothing());
        }
        let (point, normal) = (view_vector(&self.node, inputs, POSITION), view_vector(&self.node, inputs, NORMAL));
        let first = |ray: &_, limit| self.surroundings.first_reference(ray, limit);
        Ok(vec![Reference::Mask(self.mask(point, normal, &first))])
    }

    fn bytes(&self) -> usize {
        self.surroundings.bytes()
    }
}

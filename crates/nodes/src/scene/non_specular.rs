//! NonSpecular: how much light reaches a point, all but reflections.

use crate::front_support::{bound_by, where_covered};
use crate::scene_support::{
    COMBINE, Lights, NORMAL, Near, POSITION, Toward, is_bare, is_covered, nothing, uncover, view_planes, view_vector,
};
use trochoid_graph::*;
use trochoid_scene::shading::lambert;

pub(crate) static NODE: &dyn NodeType = &NonSpecular;

struct NonSpecular;

static DECLARATION: Declaration = Declaration {
    name: "NonSpecular",
    end: End::Front,
    summary: "A mask of the light that reaches the surface: Lambert's cosine, mapped to [0, 1].",
    formula: "Cᵖ with C = (N · L + 1)/2 and p = `power`, times the light's intensity there",
    edge_cases: "0 where nothing is seen. A degenerate normal points up.",
    source: "Thesis 3.2.3.2; power 2 is its C².",
    items: &[
        Port::one("view", Accepts::View, "What is lit."),
        Port::many("lights", Accepts::Light, 1, 64, "By what."),
        Knob::choice("combine", COMBINE, "How several lights become one mask.").item(),
        Knob::number("power", 1.0, 0.01, 100.0, "Contrast: the mask is raised to this power.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "How much light arrives.")],
    revision: 1,
};

impl NodeType for NonSpecular {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for NonSpecular {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
    }

    fn prefers(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&POSITION)
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let lights = Lights::of(node, prepare)?;
        Ok(Box::new(Lit { node: node.clone(), lights, power: node.number("power") }))
    }
}

struct Lit {
    node: Settled,
    lights: Lights,
    power: f64,
}

impl Prepared for Lit {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        if is_bare(inputs) {
            mask.fill(0.0);
            return Ok(());
        }
        let normals = view_planes(inputs, NORMAL);
        self.lights.fill(inputs, mask, |light, out| lambert::fill(normals, light, self.power as f32, out))?;
        uncover(inputs, mask);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bound_by(bounding, outputs, (0, 0), |sample| {
            where_covered(bounding, sample, || {
                let normal = Toward::normal(bounding, sample);
                let share = |cosine: f64| libm::pow((cosine + 1.0) / 2.0, self.power);
                self.lights.may_give(Near::point(bounding, sample), |light| normal.cosine(light).through(share))
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(&self.node, inputs) {
            return Ok(nothing());
        }
        let normal = view_vector(&self.node, inputs, NORMAL);
        let point = view_vector(&self.node, inputs, POSITION);
        let mask = self.lights.reference(point, |light| lambert::reference(normal, light, self.power));
        Ok(vec![Reference::Mask(mask)])
    }
}

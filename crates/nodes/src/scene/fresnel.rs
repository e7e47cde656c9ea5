//! Fresnel: how much of what reaches the eye is mirrored.

use crate::front_support::{bound_by, where_covered};
use crate::scene_support::{
    COMBINE, Lights, NORMAL, Near, POSITION, Toward, eye, is_bare, is_covered, nothing, toward_eye, uncover,
    view_directions, view_planes, view_vector,
};
use trochoid_graph::*;
use trochoid_scene::Projector;
use trochoid_scene::shading::fresnel::{self, Cosine};

pub(crate) static NODE: &dyn NodeType = &Fresnel;

struct Fresnel;

static DECLARATION: Declaration = Declaration {
    name: "Fresnel",
    end: End::Front,
    summary: "A mask of the share of light that the surface mirrors, which grows toward grazing angles.",
    formula: "F₀ + (1 − F₀)(1 − cos θ)⁵, F₀ = ((η − 1)/(η + 1))²; cos θ = N · V, or H · V with `cosine` half",
    edge_cases: "0 where nothing is seen; 1 where the surface faces away from the eye. η = 1 mirrors at grazing \
                 angles only.",
    source: "Thesis 3.2.3.3; Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994.",
    items: &[
        Port::one("view", Accepts::View, "What mirrors."),
        Port::many("lights", Accepts::Light, 0, 64, "The lights of H; for `cosine` half only."),
        Knob::choice("combine", COMBINE, "How several lights become one mask.").item(),
        Knob::number("eta", 1.333, 1e-3, 1e3, "Ratio of refractive indices; 1.333 is air to water.").item(),
        Knob::choice("cosine", &["view", "half"], "N · V, or the thesis' H · V.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The mirrored share.")],
    revision: 1,
};

impl NodeType for Fresnel {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if node.text("cosine") == "half" && node.all("lights").is_empty() {
            check.error("cosine", "half without lights", "at least one light", "connect \"lights\", or use \"view\"");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Fresnel {
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
        let cosine = if node.text("cosine") == "half" { Cosine::Half } else { Cosine::View };
        Ok(Box::new(Mirror {
            node: node.clone(),
            lights: Lights::of(node, prepare)?,
            eye: eye(node, prepare, prepare.frame.format)?,
            eta: node.number("eta"),
            cosine,
        }))
    }
}

struct Mirror {
    node: Settled,
    lights: Lights,
    eye: Projector,
    eta: f64,
    cosine: Cosine,
}

impl Prepared for Mirror {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        if is_bare(inputs) {
            mask.fill(0.0);
            return Ok(());
        }
        let normals = view_planes(inputs, NORMAL);
        let views = view_directions(inputs, &self.eye, mask.len())?;
        let views = [&views[0][..], &views[1], &views[2]];
        match self.cosine {
            Cosine::View => fresnel::fill(normals, [&[]; 3], views, self.eta, Cosine::View, mask),
            Cosine::Half => self.lights.fill(inputs, mask, |light, out| {
                fresnel::fill(normals, light, views, self.eta, Cosine::Half, out);
            })?,
        }
        uncover(inputs, mask);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let share = |cosine: f64| fresnel::schlick(cosine, self.eta);
        bound_by(bounding, outputs, (0, 0), |sample| {
            where_covered(bounding, sample, || {
                let point = Near::point(bounding, sample);
                let view = Toward::eye(&self.eye, point);
                match self.cosine {
                    Cosine::View => Toward::normal(bounding, sample).cosine(view).through(share).within(0.0, 1.0),
                    Cosine::Half => self.lights.may_give(point, |light| light.half_cosine(view).through(share)),
                }
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
        let view = toward_eye(&self.eye, point);
        let mask = match self.cosine {
            Cosine::View => fresnel::reference(normal, view, view, self.eta, Cosine::View),
            Cosine::Half => {
                self.lights.reference(point, |light| fresnel::reference(normal, light, view, self.eta, Cosine::Half))
            }
        };
        Ok(vec![Reference::Mask(mask)])
    }
}

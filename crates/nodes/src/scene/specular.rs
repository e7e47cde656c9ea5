//! Specular: where a light is mirrored toward the eye.

use crate::front_support::{Span, bound_by, certain, where_covered};
use crate::scene_support::{
    COMBINE, Lights, NORMAL, Near, POSITION, Toward, eye, is_bare, is_covered, nothing, toward_eye, uncover,
    view_directions, view_planes, view_vector,
};
use std::f64::consts::FRAC_PI_2;
use trochoid_graph::*;
use trochoid_scene::Projector;
use trochoid_scene::shading::blinn::{self, Model};

pub(crate) static NODE: &dyn NodeType = &Specular;

struct Specular;

static DECLARATION: Declaration = Declaration {
    name: "Specular",
    end: End::Front,
    summary: "A mask of the lights' mirror image in the surface.",
    formula: "half: exp(s · log1p(−½|N − H|²)), H halfway between light and eye, which is (N · H)ˢ; reflection: \
              (R · V)ˢ. s = `shininess`, lowered where the footprint took waves away.",
    edge_cases: "0 where nothing is seen, where the surface faces away from the light, and where light and eye are \
                 opposite.",
    source: "Thesis 3.2.3.1, R = I − 2N(N · I); Blinn, Models of Light Reflection, 1977.",
    items: &[
        Port::one("view", Accepts::View, "What mirrors."),
        Port::many("lights", Accepts::Light, 1, 64, "What is mirrored."),
        Knob::choice("combine", COMBINE, "How several lights become one mask.").item(),
        Knob::number("shininess", 60.0, 0.0, 1e6, "Exponent: the higher, the sharper.").item(),
        Knob::choice("model", &["half", "reflection"], "Blinn's half vector, or the thesis' mirror form.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "How much of the lights is mirrored.")],
    revision: 1,
};

impl NodeType for Specular {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Specular {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
    }

    fn prefers(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&POSITION).union(Channel::SlopeVariance.into())
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let model = if node.text("model") == "reflection" { Model::Reflection } else { Model::Half };
        Ok(Box::new(Mirror {
            node: node.clone(),
            lights: Lights::of(node, prepare)?,
            eye: eye(node, prepare, prepare.frame.format)?,
            shininess: node.number("shininess"),
            model,
        }))
    }
}

struct Mirror {
    node: Settled,
    lights: Lights,
    eye: Projector,
    shininess: f64,
    model: Model,
}

impl Mirror {
    /// What the lobe may be of one light, for exponents of a span.
    fn lobe(&self, [normal, light, view]: [Toward; 3], exponents: Span) -> Span {
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
        // Seen from behind the surface there is no light.
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

impl Prepared for Mirror {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        if is_bare(inputs) {
            mask.fill(0.0);
            return Ok(());
        }
        let normals = view_planes(inputs, NORMAL);
        let views = view_directions(inputs, &self.eye, mask.len())?;
        let variances = inputs.view_if_any("view", Channel::SlopeVariance).unwrap_or_default();
        self.lights.fill(inputs, mask, |light, out| {
            let views = [&views[0][..], &views[1], &views[2]];
            blinn::fill(normals, light, views, self.shininess as f32, variances, self.model, out);
        })?;
        uncover(inputs, mask);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bound_by(bounding, outputs, (0, 0), |sample| {
            where_covered(bounding, sample, || {
                let (point, normal) = (Near::point(bounding, sample), Toward::normal(bounding, sample));
                let view = Toward::eye(&self.eye, point);
                let variance = certain(bounding, Channel::SlopeVariance, sample);
                let exponents = variance.through(|variance| blinn::widened(self.shininess, variance, self.model));
                let exponents = exponents.within(0.0, self.shininess);
                self.lights.may_give(point, |light| self.lobe([normal, light, view], exponents))
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
        let variance = inputs.view(self.node.source("view"), Channel::SlopeVariance);
        let mask = self
            .lights
            .reference(point, |light| blinn::reference(normal, light, view, self.shininess, variance, self.model));
        Ok(vec![Reference::Mask(mask)])
    }
}

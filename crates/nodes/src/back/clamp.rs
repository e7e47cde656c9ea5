//! Clamp: the gate from Fields to weights.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Clamp;

struct Clamp;

static DECLARATION: Declaration = Declaration {
    name: "Clamp",
    end: End::Back,
    summary: "Maps a field to a mask: 0 below `min`, 1 above `max`, straight between.",
    formula: "1 where max ≤ x; (x − min)/(max − min) where min ≤ x; else 0. \
              Then t²(3 − 2t) if `smooth`, then tᵖ with p = `power`.",
    edge_cases: "min = max is a step that includes its threshold. +∞ (the sky's depth) gives 1, −∞ gives 0.",
    source: "Thesis 3.2.4.2, Clamp(t, max, min); `power` is the C² of 3.2.3.2.",
    items: &[
        Port::one("field", Accepts::Scalar, "What is measured against the range."),
        Knob::number("min", 0.0, LOWEST, HIGHEST, "Where the mask begins to rise, in the field's unit.").item(),
        Knob::number("max", 1.0, LOWEST, HIGHEST, "Where the mask reaches 1, in the field's unit.").item(),
        Knob::bool("smooth", false, "Ease in and out, t²(3 − 2t).").item(),
        Knob::number("power", 1.0, 1.0, 1000.0, "Contrast: the mask is raised to this power.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The mask.")],
    revision: 1,
};

/// Bounds beyond every f32 would reach kernels as infinities.
const LOWEST: f64 = -HIGHEST;
const HIGHEST: f64 = f32::MAX as f64;

impl NodeType for Clamp {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let (min, max) = (node.number("min"), node.number("max"));
        if max < min {
            check.error("max", format!("min {min} above max {max}"), "min ≤ max", "exchange them, and Invert the mask");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Clamp {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(node.source("field"));
        let (min, max) = (node.number("min") as f32, node.number("max") as f32);
        let mut t = lowering.build.clamp(x, min, max);
        if node.bool("smooth") {
            t = lowering.build.smooth(t);
        }
        Value::Weights(Weights::mask(lowering.build.power(t, node.number("power") as f32)))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let x = inputs.scalar(node.source("field"));
        let (min, max) = (node.number("min"), node.number("max"));
        let mut t = if max <= x {
            1.0
        } else if min <= x {
            (x - min) / (max - min)
        } else {
            0.0
        };
        if node.bool("smooth") {
            t = t * t * (3.0 - 2.0 * t);
        }
        Reference::Mask(libm::pow(t, node.number("power")))
    }
}

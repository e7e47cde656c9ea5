//! Mix: the barycentric operation on two colors.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Mix;

struct Mix;

static DECLARATION: Declaration = Declaration {
    name: "Mix",
    end: End::Back,
    summary: "Mixes two colors by a mask.",
    formula: "(1 − t)·a + t·b",
    edge_cases: "Exactly `a` at t = 0, `b` at t = 1, and their common value where they are equal.",
    source: "Thesis 3.2.4.2, Mix(C₀, C₁, t).",
    items: &[
        Port::one("a", Accepts::Color, "The color where the weight is 0."),
        Port::one("b", Accepts::Color, "The color where the weight is 1."),
        Port::one("weight", Accepts::Mask, "How much of `b`."),
    ],
    outputs: &[Output::new("color", Kind::Color, "The mixed color.")],
    revision: 1,
};

impl NodeType for Mix {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Mix {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let (a, b) = (lowering.color(node.source("a")), lowering.color(node.source("b")));
        let t = lowering.mask(node.source("weight"));
        Value::Color(lowering.build.mix(a, b, t))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let (a, b) = (inputs.color(node.source("a")), inputs.color(node.source("b")));
        let t = inputs.scalar(node.source("weight"));
        Reference::Color([0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]))
    }
}

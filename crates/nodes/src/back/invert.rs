//! Invert: the other side of a mask.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Invert;

struct Invert;

static DECLARATION: Declaration = Declaration {
    name: "Invert",
    end: End::Back,
    summary: "Gives the complement of a mask.",
    formula: "1 − t",
    edge_cases: "Exact at 0, ½ and 1. Twice inverted, a mask below 2⁻²⁴ loses its last digits; \
                 a Mix with `a` and `b` exchanged loses none.",
    source: "The second weight of a partition of unity in two.",
    items: &[Port::one("weight", Accepts::Mask, "The mask.")],
    outputs: &[Output::new("mask", Kind::MASK, "The complement.")],
    revision: 1,
};

impl NodeType for Invert {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Invert {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let t = lowering.mask(node.source("weight"));
        Value::Weights(Weights::mask(lowering.build.complement(t)))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        Reference::Mask(1.0 - inputs.scalar(node.source("weight")))
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::agrees;

    #[test]
    fn weights_change_sides() {
        agrees("weights", r#""x": { "type": "ScreenX" }, "out": { "type": "Invert", "weight": "x" }"#);
        agrees("weights", r#""out": { "type": "Invert", "weight": 0.3 }"#);
    }
}

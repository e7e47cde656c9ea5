//! Multiply: all masks at once.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Multiply;

struct Multiply;

static DECLARATION: Declaration = Declaration {
    name: "Multiply",
    end: End::Back,
    summary: "Gives the mask of where all masks are.",
    formula: "Π tᵢ",
    edge_cases: "0 where any mask is 0, exactly; masks of 1 change nothing.",
    source: "Product of the second weights of partitions in two.",
    items: &[Port::many("weights", Accepts::Mask, 2, 64, "The masks, in any order.")],
    outputs: &[Output::new("mask", Kind::MASK, "The product.")],
    revision: 1,
};

impl NodeType for Multiply {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Multiply {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let mut product = lowering.mask(node.source("weights"));
        for source in &node.all("weights")[1..] {
            let t = lowering.mask(source);
            product = lowering.build.product(product, t);
        }
        Value::Weights(Weights::mask(product))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        Reference::Mask(node.all("weights").iter().map(|source| inputs.scalar(source)).product())
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::agrees;

    #[test]
    fn all_masks_at_once() {
        let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
        agrees("weights", &format!(r#"{xy}, "out": {{ "type": "Multiply", "weights": ["x", "y", 0.5] }}"#));
    }
}

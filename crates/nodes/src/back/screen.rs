//! Screen: any of several masks.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Screen;

struct Screen;

static DECLARATION: Declaration = Declaration {
    name: "Screen",
    end: End::Back,
    summary: "Gives the mask of where any mask is.",
    formula: "1 − Π(1 − tᵢ)",
    edge_cases: "1 where any mask is 1, 0 where all are 0, exactly. Masks below 2⁻²⁴ may vanish.",
    source: "Complement of the product of complements (De Morgan).",
    items: &[Port::many("weights", Accepts::Mask, 2, 64, "The masks, in any order.")],
    outputs: &[Output::new("mask", Kind::MASK, "The union.")],
    revision: 1,
};

impl NodeType for Screen {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Screen {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let sources = node.all("weights");
        let first = lowering.mask(&sources[0]);
        let mut left = lowering.build.complement(first);
        for source in &sources[1..] {
            let t = lowering.mask(source);
            let open = lowering.build.complement(t);
            left = lowering.build.product(left, open);
        }
        Value::Weights(Weights::mask(lowering.build.complement(left)))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        // t + u − t·u keeps the digits of small masks.
        let either = |t: f64, u: f64| t + u - t * u;
        Reference::Mask(node.all("weights").iter().map(|source| inputs.scalar(source)).fold(0.0, either))
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::agrees;

    #[test]
    fn any_of_the_masks() {
        let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
        agrees("weights", &format!(r#"{xy}, "out": {{ "type": "Screen", "weights": ["x", "y", 0.25] }}"#));
    }
}

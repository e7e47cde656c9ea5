//! Multiply: all masks at once.

use trochoid_graph::*;

/// Gives the mask of where all masks are.
///
/// # Formula
/// Π tᵢ
///
/// # Edge cases
/// 0 where any mask is 0, exactly; masks of 1 change nothing.
///
/// # Source
/// Product of the second weights of partitions in two.
#[derive(Clone, Node)]
#[node(end = Back, revision = 1, output(mask: Kind::MASK = "The product."))]
pub(crate) struct Multiply {
    /// The masks, in any order.
    #[port(2..=64)]
    weights: Many<port::Mask>,
}

impl Node for Multiply {
    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Multiply {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let mut product = lowering.mask(&self.weights[0]);
        for source in &self.weights[1..] {
            let t = lowering.mask(source);
            product = lowering.build.product(product, t);
        }
        Value::Weights(Weights::mask(product))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        Reference::Mask(self.weights.iter().map(|source| inputs.scalar(source)).product())
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

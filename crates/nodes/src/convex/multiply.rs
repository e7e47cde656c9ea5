//! Multiply: the intersection of masks.

use trochoid_graph::*;

/// Multiplies masks; the result is 1 only where every mask is 1.
///
/// # Formula
/// Π tᵢ
///
/// # Edge cases
/// Exactly 0 where any mask is 0. A mask of 1 changes nothing.
///
/// # Source
/// The product of the second weights of partitions of unity with two weights each.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(mask: Kind::MASK = "The product."))]
pub(crate) struct Multiply {
    /// Masks to multiply; their order does not matter.
    #[port(2..=64)]
    weights: Many<port::Mask>,
}

impl Node for Multiply {}

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

//! Invert: the complement of a mask.

use trochoid_graph::*;

/// Inverts a mask: 0 becomes 1 and 1 becomes 0.
///
/// # Formula
/// 1 − t
///
/// # Edge cases
/// Exact at 0, ½ and 1. Inverting a mask below 2⁻²⁴ twice loses its last digits; swapping `a` and `b` of a Mix instead
/// loses none.
///
/// # Source
/// The second weight of a partition of unity with two weights.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(mask: Kind::MASK = "The inverted mask."))]
pub(crate) struct Invert {
    /// Mask to invert.
    weight: One<port::Mask>,
}

impl Node for Invert {}

impl Pointwise for Invert {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let t = lowering.mask(&self.weight);
        Value::Weights(Weights::mask(lowering.build.complement(t)))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        Reference::Mask(1.0 - inputs.scalar(&self.weight))
    }
}

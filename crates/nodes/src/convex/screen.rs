//! Screen: the union of masks.

use trochoid_graph::*;

/// Combines masks like a screen blend; the result is 1 where any mask is 1.
///
/// # Formula
/// 1 − Π(1 − tᵢ)
///
/// # Edge cases
/// Exactly 1 where any mask is 1, and exactly 0 where all are 0. Masks below 2⁻²⁴ may be rounded to 0.
///
/// # Source
/// The complement of the product of complements (De Morgan).
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(mask: Kind::MASK = "The combined mask."))]
pub(crate) struct Screen {
    /// Masks to combine; their order does not matter.
    #[port(2..=64)]
    weights: Many<port::Mask>,
}

impl Node for Screen {}

impl Pointwise for Screen {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let first = lowering.mask(&self.weights[0]);
        let mut left = lowering.build.complement(first);
        for source in &self.weights[1..] {
            let t = lowering.mask(source);
            let open = lowering.build.complement(t);
            left = lowering.build.product(left, open);
        }
        Value::Weights(Weights::mask(lowering.build.complement(left)))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        // 1 − (1 − t)(1 − u), but without losing the digits of small masks.
        let either = |t: f64, u: f64| t + u - t * u;
        Reference::Mask(self.weights.iter().map(|source| inputs.scalar(source)).fold(0.0, either))
    }
}

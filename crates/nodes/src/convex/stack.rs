//! Stack: weights of layers, from masks on top of each other.

use trochoid_graph::*;

/// Turns masks into the weights of layers, the first on top; one more weight, the last, takes the remainder.
///
/// # Formula
/// wᵢ = tᵢ·Πⱼ₍ⱼ<ᵢ₎(1 − tⱼ); the last weight is Π(1 − tⱼ).
///
/// # Edge cases
/// Where a mask is 1, the layers below it have exactly the weight 0. A mask of 0 changes nothing. With a single mask t,
/// the weights are t and 1 − t.
///
/// # Source
/// Porter, Duff, Compositing Digital Images, 1984: the over operator, on colors that are not premultiplied.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(weights: Kind::ANY_WEIGHTS = "One weight per mask, then the remainder."))]
#[also_called("Layer", "Layers", "Composite", "Comp", "AlphaOver", "LayerStack")]
pub(crate) struct Stack {
    /// Masks of the layers, top layer first.
    #[port(1..=255)]
    weights: Many<port::Mask>,
}

impl Node for Stack {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![Kind::Weights(self.weights.len() + 1)])
    }
}

impl Pointwise for Stack {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let masks = self.weights.iter().map(|source| lowering.mask(source)).collect();
        Value::Weights(lowering.build.stack(masks))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let mut left = 1.0;
        let mut weights = Vec::with_capacity(self.weights.len() + 1);
        for source in self.weights.iter() {
            let t = inputs.scalar(source);
            weights.push(left * t);
            left *= 1.0 - t;
        }
        if weights.len() == 1 {
            return Reference::Mask(left);
        }
        weights.push(left);
        Reference::Weights(weights)
    }
}

//! PickWeight: one of several weights, as a mask.

use trochoid_graph::*;

/// Makes a mask of one of several weights.
///
/// A port of any node may name it in short: `"parts.2"` is the weight with index 2 of `parts`.
///
/// # Formula
/// w[index]
///
/// # Edge cases
/// A mask t has the weights 1 − t and t. Of layers of masks, a weight is the share that shows beneath the others.
///
/// # Source
/// A weight of a partition of unity is from 0 to 1, as masks are.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, role = Pick, output(mask: Kind::MASK = "The weight."))]
#[also_called("Shuffle", "ChannelShuffle", "ReadMask" => "one weight of several")]
pub(crate) struct PickWeight {
    /// Weights to pick from.
    weights: One<port::Weights>,
    /// Index of the weight, counted from 0.
    #[knob(required, range = 0..=MOST - 1)]
    index: i64,
}

/// Largest number of weights.
const MOST: i64 = 256;

impl PickWeight {
    fn index(&self) -> usize {
        usize::try_from(self.index).unwrap_or_default()
    }
}

impl Node for PickWeight {
    fn check(&self, check: &mut Check<'_>) {
        let Some(Kind::Weights(count)) = check.kind(&self.weights) else { return };
        if self.index() >= count {
            let found = format!("{}, of {count} weights", self.index);
            let expected = format!("a whole number from 0 to {}", count - 1);
            check.error(Self::INDEX, found, expected, "weights are counted from 0, in the order of their colors");
        }
    }
}

impl Pointwise for PickWeight {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let weights = lowering.weights(&self.weights);
        Value::Weights(Weights::mask(lowering.build.weight(&weights, self.index())))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        Reference::Mask(inputs.weights(&self.weights)[self.index()])
    }
}

//! Duotone: two colors by a mask, with a hardness.

use trochoid_graph::*;

/// Maps a mask to two colors, with a transition of any hardness between them.
///
/// # Formula
/// (1 − u)·a + u·b with u = clamp((t − ½)·h + ½)
///
/// # Edge cases
/// A hardness of 1 is a plain mix.
///
/// # Source
/// Two-color printing.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
pub(crate) struct Duotone {
    /// Color where the mask is 0.
    a: One<port::Color>,
    /// Color where the mask is 1.
    b: One<port::Color>,
    /// Mask of the second color.
    weight: One<port::Mask>,
    /// How many times as steep the transition is as that of the mask.
    #[knob(default = 1.0, range = 1.0..=1000.0)]
    hardness: f64,
}

impl Duotone {
    /// Returns where the transition begins and ends.
    fn ends(&self) -> [f64; 2] {
        let half = 0.5 / self.hardness;
        [0.5 - half, 0.5 + half]
    }
}

impl Node for Duotone {}

impl Pointwise for Duotone {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let (a, b, t) = (lowering.color(&self.a), lowering.color(&self.b), lowering.scalar(&self.weight));
        // A clamp makes a weight, and colors are mixed by weights alone: whatever a node does, its colors stay between
        // those that it gets.
        let [min, max] = self.ends();
        let u = lowering.build.clamp(t, min, max);
        Value::Color(lowering.build.mix(a, b, u))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let (a, b, t) = (inputs.color(&self.a), inputs.color(&self.b), inputs.scalar(&self.weight));
        let [min, max] = self.ends();
        let u = ((t - min) / (max - min)).clamp(0.0, 1.0);
        Reference::Color([0, 1, 2].map(|c| (1.0 - u) * a[c] + u * b[c]))
    }
}

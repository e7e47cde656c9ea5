//! Mix: the barycentric combination of two colors.

use trochoid_graph::*;

/// Mixes two colors by a mask.
///
/// # Formula
/// (1 − t)·a + t·b
///
/// # Edge cases
/// Exactly `a` at t = 0 and exactly `b` at t = 1. Where both are equal, the result is that color for every t.
///
/// # Source
/// Thesis 3.2.4.2, Mix(C₀, C₁, t).
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The mixed color."))]
#[also_called("Lerp", "Dissolve", "Crossfade", "CrossDissolve", "MixRGB", "MixColor", "Keymix")]
pub(crate) struct Mix {
    /// Color where the weight is 0.
    a: One<port::Color>,
    /// Color where the weight is 1.
    b: One<port::Color>,
    /// Weight of `b`: 0 shows only `a`, 1 shows only `b`.
    weight: One<port::Mask>,
}

impl Node for Mix {}

impl Pointwise for Mix {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let (a, b, t) = (lowering.color(&self.a), lowering.color(&self.b), lowering.mask(&self.weight));
        Value::Color(lowering.build.mix(a, b, t))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let (a, b, t) = (inputs.color(&self.a), inputs.color(&self.b), inputs.scalar(&self.weight));
        Reference::Color([0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]))
    }
}

//! Normalize: turns fields into weights that sum to 1.

use trochoid_graph::*;

/// Divides fields by their sum to get weights that sum to 1; one more weight, the last, takes the remainder.
///
/// # Formula
/// wᵢ = vᵢ/max(S, τ) with vᵢ = max(fieldᵢ, 0), S = Σ vᵢ, τ = `floor`; the last weight is 1 − S/max(S, τ).
///
/// # Edge cases
/// Negative values count as 0. The last weight is 1 where all fields are 0, and 0 where their sum is at least `floor`.
/// Fields should be finite; +∞ counts as the largest finite f32.
///
/// # Source
/// Shepard's weights with a floor, which limits the slope of every quotient to 2/τ.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(weights: Kind::ANY_WEIGHTS = "One weight per field, then the remainder."))]
pub(crate) struct Normalize {
    /// Finite fields, one per weight.
    #[port(1..=255)]
    fields: Many<port::Scalar>,
    /// Sum of the fields below which the last weight begins to rise, in the fields' unit.
    #[knob(default = 0.001, range = 1e-30..=f32::MAX as f64)]
    floor: f64,
}

impl Node for Normalize {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![Kind::Weights(self.fields.len() + 1)])
    }
}

impl Pointwise for Normalize {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let values = self.fields.iter().map(|source| lowering.scalar(source)).collect();
        Value::Weights(lowering.build.normalize(values, self.floor))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let fields = self.fields.iter().map(|source| inputs.scalar(source));
        let values: Vec<f64> = fields.map(|v| v.max(0.0).min(f64::from(f32::MAX))).collect();
        let sum: f64 = values.iter().sum();
        let divisor = sum.max(self.floor);
        let remainder = (divisor - sum) / divisor;
        if values.len() == 1 {
            return Reference::Mask(remainder);
        }
        Reference::Weights(values.iter().map(|v| v / divisor).chain([remainder]).collect())
    }
}

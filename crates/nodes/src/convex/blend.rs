//! Blend: the barycentric combination of any number of colors.

use trochoid_graph::*;

/// Blends colors by weights that sum to 1.
///
/// # Formula
/// Σ ωᵢ·Cᵢ with ωᵢ ≥ 0, Σ ωᵢ = 1
///
/// # Edge cases
/// A color of weight 0 contributes exactly nothing. Blending equal colors gives that color. Weights written as numbers
/// are divided by their sum, which must be 1 within 10⁻⁶, and rounded to multiples of 2⁻²⁴ that sum to exactly 1.
///
/// # Source
/// Akleman, Liu, House, Barycentric Shaders, 2016, equation 1.
#[derive(Clone, Node)]
#[node(
    pointwise, end = Back, revision = 2,
    example = r#""weights": [0.3, 0.7]"#,
    output(color: Kind::Color = "The blended color.")
)]
#[also_called("Average", "WeightedSum", "Combine")]
pub(crate) struct Blend {
    /// Colors to blend, in the order of the weights.
    #[port(2..=4096)]
    colors: Many<port::Color>,
    /// One weight per color: a node that gives weights, or numbers that sum to 1.
    weights: One<port::Weights>,
}

impl Node for Blend {
    fn check(&self, check: &mut Check<'_>) {
        let colors = self.colors.len();
        let Some(Kind::Weights(ways)) = check.kind(&self.weights) else { return };
        if colors == ways {
            return;
        }
        // Weights without a color would be lost: the remaining ones sum to less than 1.
        let found = if colors < ways {
            format!("{colors} colors for {ways} weights: the result would be darker than each of its colors")
        } else {
            format!("{colors} colors for {ways} weights: the last {} would have no weight", colors - ways)
        };
        check.error(
            Self::COLORS,
            found,
            format!("{ways} colors"),
            format!("list exactly {ways} colors, one per weight"),
        );
    }
}

impl Pointwise for Blend {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let colors: Vec<_> = self.colors.iter().map(|source| lowering.color(source)).collect();
        let weights = lowering.weights(&self.weights);
        Value::Color(lowering.build.blend(&colors, &weights))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let weights = inputs.weights(&self.weights);
        let mut sum = [0.0; 3];
        for (source, weight) in self.colors.iter().zip(weights) {
            let color = inputs.color(source);
            sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
        }
        Reference::Color(sum)
    }
}

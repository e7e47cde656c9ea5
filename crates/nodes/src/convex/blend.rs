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
#[node(pointwise, end = Back, revision = 2, output(color: Kind::Color = "The blended color."))]
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
        // Weights without a color would be lost: the remaining ones sum to less than 1, so the result would be darker
        // than every color of the palette. The message shows this for a gray of 0.6.
        let found = if colors < ways {
            let kept = colors as f64 / ways as f64;
            format!(
                "{colors} colors for {ways} weights: with equal weights the first {colors} sum to {kept:.3}, and \
                 colors that are all 0.6 would give {:.3}",
                0.6 * kept
            )
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

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, refused};

    const XY: &str = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;

    #[test]
    fn any_weights_blend() {
        let colors = r#""colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"#;
        for weights in [
            r#"{ "type": "Stack", "weights": ["x", "y"] }"#,
            r#"{ "type": "Bands", "field": "x", "thresholds": [0.3, 0.7], "width": 0.2 }"#,
            r#"{ "type": "Normalize", "fields": ["x", "y"], "floor": 0.5 }"#,
        ] {
            let out = format!(r#"{XY}, "w": {weights}, "out": {{ "type": "Blend", {colors}, "weights": "w" }}"#);
            agrees("color", &out);
        }
        agrees("color", &format!(r#""out": {{ "type": "Blend", {colors}, "weights": [0.5, 0.3, 0.2] }}"#));
        agrees(
            "color",
            &format!(r#"{XY}, "out": {{ "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": "x" }}"#),
        );
    }

    #[test]
    fn as_many_colors_as_weights() {
        let few = r#""out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": [0.5, 0.25, 0.25] }"#;
        let text = refused("color", few);
        assert!(text.contains("2 colors for 3 weights") && text.contains("0.400"), "{text}");
        let many = r#""x": { "type": "ScreenX" },
            "out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "weights": "x" }"#;
        assert!(refused("color", many).contains("3 colors for 2 weights"));
    }

    #[test]
    fn a_disabled_mask_leaves_the_stack() {
        let nodes = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY", "disabled": true },
            "w": { "type": "Stack", "weights": ["x", "y"] },
            "out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": "w" }"#;
        agrees("color", nodes);
    }
}

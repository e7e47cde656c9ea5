//! Bands: a field cut at thresholds.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Bands;

struct Bands;

static DECLARATION: Declaration = Declaration {
    name: "Bands",
    end: End::Back,
    summary: "Cuts a field at thresholds into bands, the lowest band first.",
    formula: "cₖ = Clamp(x, θₖ − width/2, θₖ + width/2); band k ≥ 1 has the weight cₖ·Πⱼ₍ⱼ>ₖ₎(1 − cⱼ), \
              band 0 what is left: Π(1 − cⱼ).",
    edge_cases: "Width 0 is hard, with the upper band at the threshold itself. Where ramps overlap, since thresholds \
                 stand closer than `width`, the upper band goes first. +∞ belongs to the uppermost band, −∞ to the lowest.",
    source: "A stack of Clamps (thesis 3.2.4.2) from the highest threshold down.",
    items: &[
        Port::one("field", Accepts::Scalar, "What is cut into bands."),
        Knob::numbers("thresholds", 1, 255, "Where each band but the lowest begins, ascending, in the field's unit.")
            .item(),
        Knob::number("width", 0.0, 0.0, HIGHEST, "Width of the soft edge, in the field's unit.").item(),
    ],
    outputs: &[Output::new("weights", Kind::ANY_WEIGHTS, "One weight a band, the lowest first.")],
    revision: 1,
};

/// Bounds beyond every f32 would reach kernels as infinities.
const HIGHEST: f64 = f32::MAX as f64;

impl NodeType for Bands {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn outputs(&self, node: &Settled) -> Vec<Kind> {
        vec![Kind::Weights(node.numbers("thresholds").len() + 1)]
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let thresholds = node.numbers("thresholds");
        for (band, pair) in thresholds.windows(2).enumerate() {
            let found = || format!("{} after {}", pair[1], pair[0]);
            if pair[1] < pair[0] {
                check.error("thresholds", found(), "ascending thresholds", "sort them, and their colors with them");
                return;
            }
            if pair[1] == pair[0] && node.number("width") == 0.0 {
                let expected = format!("band {} to have room", band + 1);
                check.warning("thresholds", found(), expected, "it never shows: remove one, and the band's color");
            }
        }
        let half = node.number("width") / 2.0;
        if thresholds.iter().any(|at| at.abs() + half > HIGHEST) {
            check.error("width", "a soft edge that ends beyond every f32", "smaller numbers", "reduce the width");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Bands {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(node.source("field"));
        let half = 0.5 * node.number("width") as f32;
        let masks: Vec<_> = node
            .numbers("thresholds")
            .iter()
            .map(|at| {
                let threshold = *at as f32;
                let (min, max) = (threshold - half, threshold + half);
                if min < max { lowering.build.clamp(x, min, max) } else { lowering.build.step(x, threshold) }
            })
            .collect();
        Value::Weights(Weights::ladder(masks))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let x = inputs.scalar(node.source("field"));
        let width = node.number("width");
        let mut left = 1.0;
        let mut weights = Vec::with_capacity(node.numbers("thresholds").len() + 1);
        for at in node.numbers("thresholds").iter().rev() {
            let c = if x >= at + width / 2.0 {
                1.0
            } else if x >= at - width / 2.0 {
                (x - (at - width / 2.0)) / width
            } else {
                0.0
            };
            weights.push(left * c);
            left *= 1.0 - c;
        }
        if let [t] = weights[..] {
            return Reference::Mask(t);
        }
        weights.push(left);
        weights.reverse();
        Reference::Weights(weights)
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, frame, refused};

    fn bands(thresholds: &str, width: f64) -> String {
        format!(
            r#""x": {{ "type": "ScreenX" }},
            "out": {{ "type": "Bands", "field": "x", "thresholds": [{thresholds}], "width": {width} }}"#
        )
    }

    #[test]
    fn weights_agree_with_the_formula() {
        for thresholds in ["0.4", "0.2, 0.6", "0.1, 0.3, 0.31, 0.8"] {
            for width in [0.0, 0.15, 0.9] {
                agrees("weights", &bands(thresholds, width));
            }
        }
    }

    #[test]
    fn the_lowest_band_is_first_and_a_threshold_belongs_to_the_upper() {
        let hard = frame("weights", &bands("0.25, 0.5, 0.75", 0.0));
        assert_eq!(hard.lowered([0.5, 0.5]), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(hard.lowered([2.0, 0.5]), [0.0, 0.0, 1.0, 0.0]);
        assert_eq!(hard.lowered([3.5, 0.5]), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(frame("weights", &bands("0.5", 0.0)).lowered([2.0, 0.5]), [0.0, 1.0]);
    }

    #[test]
    fn thresholds_ascend() {
        assert!(refused("weights", &bands("0.5, 0.2", 0.0)).contains("0.2 after 0.5"));
        assert!(refused("weights", &bands("3e38", 3e38)).contains("beyond every f32"));
    }
}

//! Bands: cuts a field into weights at thresholds.

use trochoid_graph::*;

/// Cuts a field into bands at thresholds and gives one weight per band.
///
/// # Formula
/// cₖ = Clamp(x, θₖ − width/2, θₖ + width/2). Band k ≥ 1 has the weight cₖ·Πⱼ₍ⱼ>ₖ₎(1 − cⱼ); band 0 has the remainder,
/// Π(1 − cⱼ).
///
/// # Edge cases
/// Width 0 gives hard edges; the threshold itself belongs to the upper band. If thresholds lie closer together than
/// `width`, their soft edges overlap and the upper band takes precedence. +∞ belongs to the highest band, −∞ to the
/// lowest.
///
/// # Source
/// A Stack of Clamps (thesis 3.2.4.2), the highest threshold on top.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 2, output(weights: Kind::ANY_WEIGHTS = "One weight per band, lowest band first."))]
#[also_called("Posterize", "Threshold", "Quantize", "Step", "Toon", "CelShade")]
pub(crate) struct Bands {
    /// Field to cut into bands.
    field: One<port::Scalar>,
    /// Lower limits of all bands except the lowest, in ascending order, in the field's unit.
    #[knob(len = 1..=255)]
    thresholds: Vec<f64>,
    /// Width of the soft edges, in the field's unit; 0 gives hard edges.
    #[knob(default = 0.0, range = 0.0..=HIGHEST)]
    width: f64,
}

/// Largest finite f32. Larger thresholds would become infinities in the kernels, which compute in f32.
const HIGHEST: f64 = f32::MAX as f64;

impl Node for Bands {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![Kind::Weights(self.thresholds.len() + 1)])
    }

    fn check(&self, check: &mut Check<'_>) {
        for (band, pair) in self.thresholds.windows(2).enumerate() {
            let found = || format!("{} after {}", pair[1], pair[0]);
            if pair[1] < pair[0] {
                check.error(Self::THRESHOLDS, found(), "ascending thresholds", "sort them, and their colors with them");
                return;
            }
            if pair[1] == pair[0] && self.width == 0.0 {
                let expected = format!("thresholds that leave room for band {}", band + 1);
                check.warning(
                    Self::THRESHOLDS,
                    found(),
                    expected,
                    "the band never shows: remove one of the two thresholds, and the band's color",
                );
            }
        }
        let half = self.width / 2.0;
        if self.thresholds.iter().any(|at| at.abs() + half > HIGHEST) {
            check.error(
                Self::WIDTH,
                "a soft edge that extends beyond the range of f32",
                "smaller numbers",
                "reduce the width",
            );
        }
    }
}

impl Pointwise for Bands {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(&self.field);
        let half = self.width / 2.0;
        let mask = |at: &f64| {
            // In f64, so that each edge is rounded to f32 only once.
            let (min, max) = (at - half, at + half);
            if min < max { lowering.build.clamp(x, min, max) } else { lowering.build.step(x, *at) }
        };
        Value::Weights(Weights::ladder(self.thresholds.iter().map(mask).collect()))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let x = inputs.scalar(&self.field);
        let width = self.width;
        let mut left = 1.0;
        let mut weights = Vec::with_capacity(self.thresholds.len() + 1);
        for at in self.thresholds.iter().rev() {
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

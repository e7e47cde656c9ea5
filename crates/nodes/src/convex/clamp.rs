//! Clamp: the gate from Fields to weights.

use trochoid_graph::*;

/// Maps a field to a mask: 0 below `min`, 1 above `max`, straight between.
///
/// # Formula
/// 1 where max ≤ x; (x − min)/(max − min) where min ≤ x; else 0. Then t²(3 − 2t) if `smooth`, then tᵖ with p = `power`.
///
/// # Edge cases
/// min = max is a step that includes its threshold. +∞ (the sky's depth) gives 1, −∞ gives 0.
///
/// # Source
/// Thesis 3.2.4.2, Clamp(t, max, min); `power` is the C² of 3.2.3.2.
#[derive(Clone, Node)]
#[node(end = Back, revision = 1, role = Threshold, output(mask: Kind::MASK = "The mask."))]
#[also_called("MapRange", "Remap", "Fit", "SmoothStep", "Levels")]
pub(crate) struct Clamp {
    /// What is measured against the range.
    field: One<port::Scalar>,
    /// Where the mask begins to rise, in the field's unit.
    #[knob(default = 0.0, range = LOWEST..=HIGHEST)]
    min: f64,
    /// Where the mask reaches 1, in the field's unit.
    #[knob(default = 1.0, range = LOWEST..=HIGHEST)]
    max: f64,
    /// Ease in and out, t²(3 − 2t).
    #[knob(default = false)]
    smooth: bool,
    /// Contrast: the mask is raised to this power.
    #[knob(default = 1.0, range = 1.0..=1000.0)]
    power: f64,
}

/// Bounds beyond every f32 would reach kernels as infinities.
const LOWEST: f64 = -HIGHEST;
const HIGHEST: f64 = f32::MAX as f64;

impl Node for Clamp {
    fn check(&self, check: &mut Check<'_>) {
        let (min, max) = (self.min, self.max);
        if max < min {
            check.error(
                Self::MAX,
                format!("min {min} above max {max}"),
                "min ≤ max",
                "exchange them, and Invert the mask",
            );
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Clamp {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(&self.field);
        let (min, max) = (self.min as f32, self.max as f32);
        let mut t = lowering.build.clamp(x, min, max);
        if self.smooth {
            t = lowering.build.smooth(t);
        }
        Value::Weights(Weights::mask(lowering.build.power(t, self.power as f32)))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let x = inputs.scalar(&self.field);
        let (min, max) = (self.min, self.max);
        let mut t = if max <= x {
            1.0
        } else if min <= x {
            (x - min) / (max - min)
        } else {
            0.0
        };
        if self.smooth {
            t = t * t * (3.0 - 2.0 * t);
        }
        Reference::Mask(libm::pow(t, self.power))
    }
}

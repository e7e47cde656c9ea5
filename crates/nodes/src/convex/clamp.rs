//! Clamp: maps a field to a mask. Colors depend on fields only through weights, and this is the most direct way there.

use trochoid_graph::*;

/// Maps a field to a mask that rises linearly from 0 at `min` to 1 at `max`.
///
/// # Formula
/// t = 0 for x < min, (x − min)/(max − min) for min ≤ x < max, 1 for x ≥ max. Then t²(3 − 2t) if `smooth`, then tᵖ with
/// p = `power`.
///
/// # Edge cases
/// min = max gives a hard step; at the threshold itself the mask is 1. +∞ (the depth of the sky) gives 1, −∞ gives 0.
///
/// # Source
/// Thesis 3.2.4.2, Clamp(t, max, min); `power` is the C² of 3.2.3.2.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, role = Threshold, output(mask: Kind::MASK = "The mask."))]
#[also_called("MapRange", "Remap", "Fit", "SmoothStep", "Levels")]
pub(crate) struct Clamp {
    /// Field to map to a mask.
    field: One<port::Scalar>,
    /// Value at which the mask begins to rise, in the field's unit.
    #[knob(default = 0.0, range = LOWEST..=HIGHEST)]
    min: f64,
    /// Value at which the mask reaches 1, in the field's unit.
    #[knob(default = 1.0, range = LOWEST..=HIGHEST)]
    max: f64,
    /// Eases the ramp in and out: t²(3 − 2t).
    #[knob(default = false)]
    smooth: bool,
    /// Exponent applied to the mask; 1 leaves it unchanged, larger values darken its mid-tones.
    #[knob(default = 1.0, range = 1.0..=1000.0)]
    power: f64,
}

/// Range of the finite f32. Larger bounds would become infinities in the kernels, which compute in f32.
const LOWEST: f64 = -HIGHEST;
const HIGHEST: f64 = f32::MAX as f64;

impl Node for Clamp {
    fn check(&self, check: &mut Check<'_>) {
        let (min, max) = (self.min, self.max);
        if max < min {
            check.error(Self::MAX, format!("min {min} above max {max}"), "min ≤ max", "swap them, and Invert the mask");
        }
    }
}

impl Pointwise for Clamp {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(&self.field);
        let mut t = lowering.build.clamp(x, self.min, self.max);
        if self.smooth {
            t = lowering.build.smooth(t);
        }
        Value::Weights(Weights::mask(lowering.build.power(t, self.power)))
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

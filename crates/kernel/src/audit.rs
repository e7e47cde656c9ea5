//! Records the extremes of weights and planes while programs run.

/// Extremes of weights seen while running.
#[derive(Clone, Copy, Debug)]
pub struct WeightAudit {
    /// Least weight or distance of a mask from the ends of [0, 1].
    pub min: f32,
    /// Largest deviation of a sum of weights from 1.
    pub max_deviation: f64,
}

impl Default for WeightAudit {
    fn default() -> Self {
        Self { min: f32::INFINITY, max_deviation: 0.0 }
    }
}

impl WeightAudit {
    /// Joins the extremes of two runs.
    pub fn merge(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max_deviation: self.max_deviation.max(other.max_deviation) }
    }
}

/// Bits of 1.
pub(crate) const ONE: u32 = 0x3f80_0000;

/// Rule for the samples of a plane, as a bound on their bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueRule {
    /// In [0, 1].
    Mask,
    /// Finite and ≥ 0.
    Color,
    /// Not NaN.
    Field,
}

impl ValueRule {
    /// Returns whether samples with these largest bits (shifted for a field) are all legal, and none is −0.
    pub(crate) fn allows(self, largest: u32) -> bool {
        largest
            <= match self {
                Self::Mask => ONE,
                Self::Color => f32::MAX.to_bits(),
                // The sign is shifted out; an infinity is the largest.
                Self::Field => f32::INFINITY.to_bits() << 1,
            }
    }
}

/// Least and largest bits seen, by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BitRange {
    pub(crate) least: [u32; 16],
    pub(crate) largest: [u32; 16],
}

impl Default for BitRange {
    fn default() -> Self {
        Self { least: [u32::MAX; 16], largest: [0; 16] }
    }
}

impl BitRange {
    /// Returns both over all lanes; `None` if nothing was seen.
    pub(crate) fn range(&self) -> Option<(u32, u32)> {
        let least = self.least.iter().copied().min()?;
        let largest = self.largest.iter().copied().max()?;
        (least <= largest).then_some((least, largest))
    }

    /// Returns the largest over all lanes; 0 if nothing was seen.
    pub(crate) fn largest(&self) -> u32 {
        self.largest.iter().copied().fold(0, u32::max)
    }

    /// Returns the smaller of the least t and the least 1 − t; −∞ for NaN, unless a negative number hides it.
    ///
    /// Negative numbers have larger bits than all others, and larger ones the further they lie below 0.
    pub(crate) fn least_weight(&self) -> f32 {
        let Some((least, largest)) = self.range() else { return f32::INFINITY };
        let (low, high) = (f32::from_bits(least), f32::from_bits(largest));
        if high.is_nan() {
            f32::NEG_INFINITY
        } else if high.is_sign_negative() {
            // Adding 0 turns −0 into 0.
            high + 0.0
        } else {
            low.min(1.0 - high)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(values: &[f32]) -> BitRange {
        let mut bits = BitRange::default();
        for (i, v) in values.iter().enumerate() {
            bits.least[i % 16] = bits.least[i % 16].min(v.to_bits());
            bits.largest[i % 16] = bits.largest[i % 16].max(v.to_bits());
        }
        bits
    }

    #[test]
    fn the_least_weight_is_that_of_either_side() {
        for (values, least) in [
            (&[0.25, 0.5][..], 0.25),
            (&[0.25, 0.875], 0.125),
            (&[0.0, 1.0], 0.0),
            (&[-0.0], 0.0),
            (&[0.5, -0.25, -0.125], -0.25),
            (&[0.5, 1.5], -0.5),
            (&[0.5, f32::NAN], f32::NEG_INFINITY),
            (&[-1.0, f32::NAN], -1.0),
            (&[0.5, f32::NEG_INFINITY], f32::NEG_INFINITY),
            (&[], f32::INFINITY),
        ] {
            assert_eq!(seen(values).least_weight(), least, "{values:?}");
        }
        assert_eq!(seen(&[0.5, -f32::NAN]).least_weight(), f32::NEG_INFINITY);
    }

    #[test]
    fn every_illegal_value_is_above_the_bound() {
        type IsLegal = fn(f32) -> bool;
        let rules: [(ValueRule, IsLegal); 3] = [
            (ValueRule::Mask, |v| (0.0..=1.0).contains(&v) && v.is_sign_positive()),
            (ValueRule::Color, |v| v.is_finite() && v.is_sign_positive()),
            (ValueRule::Field, |v| !v.is_nan()),
        ];
        let edges = [0.0, 1.0, 1.000_000_1, f32::MIN_POSITIVE, 1e-45, f32::MAX, f32::INFINITY, f32::NAN];
        for v in edges.into_iter().flat_map(|v| [v, -v]) {
            for (rule, legal) in rules {
                let bits = if rule == ValueRule::Field { v.to_bits() << 1 } else { v.to_bits() };
                assert_eq!(rule.allows(bits), legal(v), "{rule:?} {v}");
            }
        }
    }
}

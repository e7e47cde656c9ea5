//! Weights as files store them: rounded so that their sum stays exactly 1.

/// How weights are stored: as multiples of a unit whose sums are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Storing {
    /// 16-bit floats: multiples of 2⁻¹¹.
    #[default]
    Half,
    /// 32-bit floats: multiples of 2⁻²⁴.
    Float,
}

impl Storing {
    /// Returns the number of units in 1.
    #[must_use]
    pub fn units(self) -> u32 {
        match self {
            Self::Half => 1 << 11,
            Self::Float => 1 << 24,
        }
    }

    /// Rounds weights that are ≥ 0 and sum to 1 up to rounding. The results are ≥ 0, and their sum is exactly 1 in any
    /// order, since all partial sums are multiples of the unit: the largest weight takes what rounding leaves. With up to
    /// 63 weights it can, for it is at least 1/K, and K roundings leave at most K/2 units.
    ///
    /// ```
    /// use trochoid_palette::Storing;
    /// let stored = Storing::Half.round(&[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]);
    /// assert_eq!(stored.iter().sum::<f32>(), 1.0);
    /// ```
    #[must_use]
    pub fn round(self, weights: &[f64]) -> Vec<f32> {
        let units = f64::from(self.units());
        let mut whole: Vec<i64> = weights.iter().map(|weight| (weight * units).round() as i64).collect();
        let rest = i64::from(self.units()) - whole.iter().sum::<i64>();
        // Of equal ones the first, so that the same weights are stored the same.
        let mut largest = 0;
        for (index, own) in whole.iter().enumerate() {
            if *own > whole[largest] {
                largest = index;
            }
        }
        if let Some(own) = whole.get_mut(largest) {
            *own += rest;
        }
        whole.iter().map(|own| (*own as f64 / units) as f32).collect()
    }

    /// Bounds how far rounding moves a channel of a pixel that some colors mix, given the range of their channel: each
    /// weight by half a unit, and the largest by as much as all others together.
    #[must_use]
    pub fn error(self, colors: usize, range: f64) -> f64 {
        let others = colors.saturating_sub(1) as f64;
        0.5 * others / f64::from(self.units()) * range
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_in_any_order_and_errors_within_their_bound() {
        let mut state = 3_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for storing in [Storing::Half, Storing::Float] {
            for count in [1_usize, 2, 3, 7, 24, 63] {
                for _ in 0..500 {
                    let parts: Vec<f64> = (0..count).map(|_| draw().powi(4)).collect();
                    let sum: f64 = parts.iter().sum();
                    let weights: Vec<f64> = parts.iter().map(|part| part / sum).collect();
                    let stored = storing.round(&weights);
                    assert!(stored.iter().all(|weight| *weight >= 0.0));
                    assert_eq!((stored.iter().sum::<f32>(), stored.iter().rev().sum::<f32>()), (1.0, 1.0));
                    // A channel of colors from 0 to 1.
                    let color: Vec<f64> = (0..count).map(|_| draw()).collect();
                    let mix = |weights: &mut dyn Iterator<Item = f64>| -> f64 {
                        weights.zip(&color).map(|(weight, channel)| weight * channel).sum()
                    };
                    let off = mix(&mut stored.iter().map(|w| f64::from(*w))) - mix(&mut weights.iter().copied());
                    assert!(off.abs() <= storing.error(count, 1.0) + 1e-12, "{off}");
                }
            }
        }
    }
}

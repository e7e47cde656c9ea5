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
    /// order, since all partial sums are multiples of the unit.
    ///
    /// ```
    /// use trochoid_weights::Storing;
    /// let stored = Storing::Half.round(&[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]);
    /// assert_eq!(stored.iter().sum::<f32>(), 1.0);
    /// ```
    #[must_use]
    pub fn round(self, weights: &[f64]) -> Vec<f32> {
        let mut weights = weights.to_vec();
        self.apportion(&mut weights);
        weights.into_iter().map(|weight| weight as f32).collect()
    }

    /// Does the same as [`round`](Self::round) in place, and returns how much weight moved from some colors to others.
    ///
    /// Each weight is rounded down to whole units; the units that are left go to the largest remainders, one each, of
    /// equal ones (to 31 bits) to the first, so that the same weights are stored the same. No other multiples of the unit
    /// with that sum move less weight, and a weight of 0 stays 0.
    ///
    /// [`Apportioner`](crate::Apportioner) does it for many pixels.
    pub fn apportion(self, weights: &mut [f64]) -> f64 {
        let units = f64::from(self.units());
        let scale = units / weights.iter().sum::<f64>();
        let mut order = Vec::new();
        let mut rest = units;
        for (index, weight) in weights.iter_mut().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let scaled = *weight * scale;
            let whole = whole(scaled);
            order.push((key(scaled - whole), index, scaled - whole));
            rest -= whole;
            *weight = whole / units;
        }
        order.sort_unstable_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut moved = 0.0;
        for (_, index, remainder) in order.iter().take(rest.max(0.0) as usize) {
            weights[*index] += 1.0 / units;
            moved += 1.0 - remainder;
        }
        moved / units
    }

    /// Bounds how far storing moves a channel of a pixel that `colors` colors mix, given the range of their channel.
    ///
    /// With s units left for m remainders that sum to s, the s largest sum to at least s²/m, so that at most s − s²/m
    /// units move, which is largest for s = m/2.
    #[must_use]
    pub fn error(self, colors: usize, range: f64) -> f64 {
        let most = (colors / 2) * colors.div_ceil(2);
        most as f64 / colors.max(1) as f64 / f64::from(self.units()) * range
    }
}

/// Added to a smaller number ≥ 0, 2⁵² rounds it to a whole one, which are its lowest bits.
const WHOLE: f64 = (1_u64 << 52) as f64;

/// Returns the whole part of a number from 0 to 2⁵¹, without the function of processors that lack the instruction.
#[inline(always)]
pub(crate) fn whole(value: f64) -> f64 {
    let near = (value + WHOLE) - WHOLE;
    near - if near > value { 1.0 } else { 0.0 }
}

/// Returns what orders remainders: their 31 highest bits. Those that differ by less count as equal, which moves no weight
/// that could be stored.
#[inline(always)]
pub(crate) fn key(remainder: f64) -> u32 {
    (remainder * f64::from(1_u32 << 31) + WHOLE).to_bits() as u32
}

use crate::{WeightsError, arithmetic};

/// A two-way partition of unity, written as one number in [0, 1].
///
/// The field is private and every constructor and operation stays in [0, 1], so having a `Mask` is the proof. As
/// weights it means (1 − t, t): [`mix`](Mask::mix) gives `a` at 0 and `b` at 1.
///
/// ```compile_fail
/// let forged = trochoid_weights::Mask(1.5);
/// ```
/// ```compile_fail
/// let forged: trochoid_weights::Mask = 1.5_f32.into();
/// ```
/// ```compile_fail
/// let mut mask = trochoid_weights::Mask::ONE;
/// mask.0 = 1.5;
/// ```
/// ```compile_fail
/// // Operators could leave [0, 1].
/// let forged = trochoid_weights::Mask::ONE + trochoid_weights::Mask::ONE;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Mask(f32);

impl Mask {
    /// Nowhere: all weight on the first side.
    pub const ZERO: Self = Self(0.0);
    /// Everywhere: all weight on the second side.
    pub const ONE: Self = Self(1.0);

    /// Takes a number that is a mask already.
    ///
    /// # Errors
    ///
    /// `t` is outside [0, 1] or NaN. −0 becomes 0.
    pub fn new(t: f32) -> Result<Self, WeightsError> {
        if (0.0..=1.0).contains(&t) { Ok(Self(t + 0.0)) } else { Err(WeightsError::Mask { value: t }) }
    }

    /// Maps a field value to a mask; see [`arithmetic::clamp`].
    #[must_use]
    pub fn clamp(x: f32, min: f32, max: f32) -> Self {
        Self(arithmetic::clamp(x, min, max))
    }

    /// The hard mask: 1 where x ≥ threshold; see [`arithmetic::step`].
    #[must_use]
    pub fn step(x: f32, threshold: f32) -> Self {
        Self(arithmetic::step(x, threshold))
    }

    /// The number in [0, 1].
    #[must_use]
    pub fn value(self) -> f32 {
        self.0
    }

    /// The other side; see [`arithmetic::complement`].
    #[must_use]
    pub fn complement(self) -> Self {
        Self(arithmetic::complement(self.0))
    }

    /// Both masks; see [`arithmetic::product`].
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(arithmetic::product(self.0, other.0))
    }

    /// Either mask; see [`arithmetic::screen`].
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(arithmetic::screen(self.0, other.0))
    }

    /// Slope 0 at both ends; see [`arithmetic::smooth`].
    #[must_use]
    pub fn smooth(self) -> Self {
        Self(arithmetic::smooth(self.0))
    }

    /// Contrast; see [`arithmetic::power`].
    ///
    /// # Errors
    ///
    /// `p` is below 1 or NaN: such a power has infinite slope at 0.
    pub fn power(self, p: f32) -> Result<Self, WeightsError> {
        if p >= 1.0 { Ok(Self(arithmetic::power(self.0, p))) } else { Err(WeightsError::Power { value: p }) }
    }

    /// Mixes two channel values by this mask; see [`arithmetic::mix`].
    #[must_use]
    pub fn mix(self, a: f32, b: f32) -> f32 {
        arithmetic::mix(a, b, self.0)
    }
}

use trochoid_image::Rgb;

use crate::{Mask, WeightsError, arithmetic};

/// An n-way partition of unity at one pixel: n ≥ 1 weights ≥ 0 that sum to exactly 1.
///
/// The field is private, there is no mutable access, and the constructors below are all there are: having a `Weights`
/// is the proof. Every weight is a multiple of 2⁻²⁴, so that sums of them are exact.
///
/// None of these compile:
///
/// ```compile_fail
/// let forged = trochoid_weights::Weights { values: vec![0.7, 0.7].into() };
/// ```
/// ```compile_fail
/// let forged = trochoid_weights::Weights(vec![0.7, 0.7].into());
/// ```
/// ```compile_fail
/// let forged = trochoid_weights::Weights::default();
/// ```
/// ```compile_fail
/// let mut weights = trochoid_weights::Weights::new(&[0.5, 0.5]).unwrap();
/// weights.as_slice()[0] = 0.7;
/// ```
/// ```compile_fail
/// let forged: trochoid_weights::Weights = vec![0.7, 0.7].into();
/// ```
/// ```compile_fail
/// let forged: trochoid_weights::Weights = [0.7, 0.7].into_iter().collect();
/// ```
/// ```compile_fail
/// // No `Deserialize`, nor any other way to parse one.
/// let forged: trochoid_weights::Weights = "[0.7, 0.7]".parse().unwrap();
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    values: Box<[f32]>,
}

impl Weights {
    /// The two weights of a mask, (1 − t, t), rounded to multiples of 2⁻²⁴.
    ///
    /// Blending by them gives the first color at t = 0 and the second at t = 1, as Mix does; but Mix keeps masks below
    /// 2⁻²⁵, which are 0 here.
    #[must_use]
    pub fn from_mask(mask: Mask) -> Self {
        let t = f64::from(mask.value());
        Self::rounded(&[1.0 - t, t])
    }

    /// Takes numbers that are a partition of unity already, within 10⁻⁶, and rounds them so that they sum to exactly 1.
    ///
    /// # Errors
    ///
    /// No weights or more than [`MAX_WEIGHTS`](arithmetic::MAX_WEIGHTS), a weight that is negative or not finite, or a
    /// sum that differs from 1 by more than 10⁻⁶.
    pub fn new(values: &[f64]) -> Result<Self, WeightsError> {
        Self::check_count(values.len())?;
        for (index, &value) in values.iter().enumerate() {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(WeightsError::Weight { index, value });
            }
        }
        let sum: f64 = values.iter().sum();
        if (sum - 1.0).abs() <= 1e-6 { Ok(Self::rounded(values)) } else { Err(WeightsError::Sum { sum }) }
    }

    /// n values to n + 1 weights: v/max(S, τ), and the remainder to the last; see [`arithmetic::normalize`].
    ///
    /// # Errors
    ///
    /// A value is NaN or +∞ (negative counts as 0), τ is not positive and finite, or there are too many values.
    pub fn normalize(values: &[f32], floor: f32) -> Result<Self, WeightsError> {
        Self::check_count(values.len() + 1)?;
        if !(floor > 0.0 && floor.is_finite()) {
            return Err(WeightsError::Floor { value: floor });
        }
        for (index, &value) in values.iter().enumerate() {
            if value.is_nan() || value == f32::INFINITY {
                return Err(WeightsError::Value { index, value });
            }
        }
        let mut out = vec![0.0; values.len() + 1];
        arithmetic::normalize(values, floor, &mut out);
        Ok(Self { values: out.into() })
    }

    /// n masks, the first on top, to n + 1 weights; the last takes what the masks leave. See [`arithmetic::stack`].
    ///
    /// # Errors
    ///
    /// More masks than a partition can hold.
    pub fn stack(masks: &[Mask]) -> Result<Self, WeightsError> {
        Self::check_count(masks.len() + 1)?;
        let masks: Vec<f32> = masks.iter().map(|mask| mask.value()).collect();
        let mut out = vec![0.0; masks.len() + 1];
        arithmetic::stack(&masks, &mut out);
        Ok(Self { values: out.into() })
    }

    /// n ascending thresholds to the weights of n + 1 bands, the lowest band first.
    ///
    /// Defined as a stack of [`threshold`](arithmetic::threshold) masks from the highest down: with
    /// cₖ = clamp(x, θₖ − w/2, θₖ + w/2), band k (from 1) has weight cₖ·Πⱼ₍ⱼ>ₖ₎(1 − cⱼ), and band 0 the rest. Width 0 is
    /// hard, the upper band at the threshold itself; NaN falls in band 0.
    ///
    /// Where the ramps do not overlap (neighboring thresholds at least w apart), cₖ₊₁ > 0 implies cₖ = 1, and the
    /// weight of band k is the difference cₖ − cₖ₊₁. Where they do overlap that difference is no longer the product, but
    /// the stack is still a partition of unity.
    ///
    /// # Errors
    ///
    /// Thresholds that are not finite or not ascending, a width that is negative or not finite, or too many bands.
    pub fn bands(x: f32, thresholds: &[f32], width: f32) -> Result<Self, WeightsError> {
        Self::check_count(thresholds.len() + 1)?;
        if !(width >= 0.0 && width.is_finite()) {
            return Err(WeightsError::Width { value: width });
        }
        if let Some(index) = thresholds.iter().position(|at| !at.is_finite()) {
            return Err(WeightsError::Value { index, value: thresholds[index] });
        }
        if let Some(index) = thresholds.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(WeightsError::Order { index: index + 1 });
        }
        let masks: Vec<f32> = thresholds.iter().rev().map(|&at| arithmetic::threshold(x, at, width)).collect();
        let mut out = vec![0.0; thresholds.len() + 1];
        arithmetic::stack(&masks, &mut out);
        out.reverse();
        Ok(Self { values: out.into() })
    }

    /// The blend Σ wᵢ·Cᵢ, channel by channel; see [`arithmetic::blend`] for why it cannot leave the box of its colors.
    ///
    /// One set of scalar weights serves all three channels, so before rounding the color lies in their convex hull.
    ///
    /// # Panics
    ///
    /// If the number of colors is not the number of weights.
    #[must_use]
    pub fn blend(&self, colors: &[Rgb]) -> Rgb {
        assert_eq!(colors.len(), self.values.len(), "one color for each weight");
        let mut sums = [0.0_f64; 3];
        for (&weight, color) in self.values.iter().zip(colors) {
            for (sum, &value) in sums.iter_mut().zip(color) {
                *sum = arithmetic::accumulate(*sum, weight, value);
            }
        }
        sums.map(|sum| sum as f32)
    }

    /// The weights, each a multiple of 2⁻²⁴.
    #[must_use]
    pub fn as_slice(&self) -> &[f32] {
        &self.values
    }

    fn check_count(count: usize) -> Result<(), WeightsError> {
        if (1..=arithmetic::MAX_WEIGHTS).contains(&count) { Ok(()) } else { Err(WeightsError::Count { count }) }
    }

    /// Rounds checked weights.
    fn rounded(values: &[f64]) -> Self {
        let mut out = vec![0.0; values.len()];
        arithmetic::round_from_f64(values.iter().copied(), &mut out);
        Self { values: out.into() }
    }
}

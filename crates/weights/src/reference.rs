//! References of the operations in f64, straight from their formulas.
//!
//! Independent of [`arithmetic`](crate::arithmetic): without shared code, and without measures against rounding
//! beyond the precision of f64. The errors of the fast kernels are measured against these functions.

/// Returns (1 − t)·a + t·b.
#[inline]
#[must_use]
pub fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// Returns 1 from `max` on, (x − min)/(max − min) from `min` on, else 0 (also for NaN).
#[inline]
#[must_use]
pub fn clamp(x: f64, min: f64, max: f64) -> f64 {
    if x >= max {
        1.0
    } else if x >= min {
        (x - min) / (max - min)
    } else {
        0.0
    }
}

/// Returns t²·(3 − 2t).
#[inline]
#[must_use]
pub fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Returns t to the power p.
#[inline]
#[must_use]
pub fn power(t: f64, p: f64) -> f64 {
    libm::pow(t, p)
}

/// Returns 1 where x ≥ threshold, else 0 (also for NaN).
#[must_use]
pub fn step(x: f64, threshold: f64) -> f64 {
    if x >= threshold { 1.0 } else { 0.0 }
}

/// Returns 1 − t.
#[must_use]
pub fn complement(t: f64) -> f64 {
    1.0 - t
}

/// Returns a·b.
#[must_use]
pub fn product(a: f64, b: f64) -> f64 {
    a * b
}

/// Returns 1 − (1 − a)(1 − b), multiplied out so that small masks keep their digits.
#[must_use]
pub fn screen(a: f64, b: f64) -> f64 {
    a + b - a * b
}

/// Returns the weights max(vᵢ, 0)/max(S, τ), with S = Σ max(vᵢ, 0) and τ = `floor`, and the remainder as the last
/// weight. +∞ counts as the largest f32.
#[must_use]
pub fn normalize(values: &[f64], floor: f64) -> Vec<f64> {
    let share = |v: &f64| v.max(0.0).min(f64::from(f32::MAX));
    let sum: f64 = values.iter().map(share).sum();
    let mut weights: Vec<f64> = values.iter().map(|v| share(v) / sum.max(floor)).collect();
    weights.push(1.0 - sum / sum.max(floor));
    weights
}

/// Returns the weights tᵢ·Π(1 − tⱼ), with the product over the masks j above i, and the remainder as the last weight.
#[must_use]
pub fn stack(masks: &[f64]) -> Vec<f64> {
    let above = |i: usize| masks[..i].iter().map(|t| 1.0 - t).product::<f64>();
    let mut weights: Vec<f64> = (0..masks.len()).map(|i| masks[i] * above(i)).collect();
    weights.push(above(masks.len()));
    weights
}

/// Returns the weights wᵢ/Σw.
#[must_use]
pub fn partition(weights: &[f64]) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Returns Σ wᵢ·cᵢ.
#[must_use]
pub fn blend(values: &[f64], weights: &[f64]) -> f64 {
    values.iter().zip(weights).map(|(c, w)| c * w).sum()
}

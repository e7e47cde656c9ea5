//! The same operations in f64, straight from their formulas.
//!
//! Independent of [`arithmetic`](crate::arithmetic): no shared code, no care for rounding beyond what f64 gives. These
//! are the truth that the fast kernels are measured against.

/// (1 − t)·a + t·b.
#[must_use]
pub fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// 1 from `max` on, (x − min)/(max − min) from `min` on, else 0 (also for NaN).
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

/// t²·(3 − 2t).
#[must_use]
pub fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// t to the power p.
#[must_use]
pub fn power(t: f64, p: f64) -> f64 {
    libm::pow(t, p)
}

/// 1 where x ≥ threshold, else 0 (also for NaN).
#[must_use]
pub fn step(x: f64, threshold: f64) -> f64 {
    if x >= threshold { 1.0 } else { 0.0 }
}

/// 1 − t.
#[must_use]
pub fn complement(t: f64) -> f64 {
    1.0 - t
}

/// a·b.
#[must_use]
pub fn product(a: f64, b: f64) -> f64 {
    a * b
}

/// 1 − (1 − a)(1 − b), multiplied out so that small masks keep their digits.
#[must_use]
pub fn screen(a: f64, b: f64) -> f64 {
    a + b - a * b
}

/// max(vᵢ, 0)/max(S, τ), and the remainder as the last weight.
#[must_use]
pub fn normalize(values: &[f64], floor: f64) -> Vec<f64> {
    let sum: f64 = values.iter().map(|v| v.max(0.0)).sum();
    let mut weights: Vec<f64> = values.iter().map(|v| v.max(0.0) / sum.max(floor)).collect();
    weights.push(1.0 - sum / sum.max(floor));
    weights
}

/// tᵢ·Π(1 − tⱼ) over the masks above it, and the rest as the last weight.
#[must_use]
pub fn stack(masks: &[f64]) -> Vec<f64> {
    let above = |i: usize| masks[..i].iter().map(|t| 1.0 - t).product::<f64>();
    let mut weights: Vec<f64> = (0..masks.len()).map(|i| masks[i] * above(i)).collect();
    weights.push(above(masks.len()));
    weights
}

/// Σ wᵢ·cᵢ.
#[must_use]
pub fn blend(values: &[f64], weights: &[f64]) -> f64 {
    values.iter().zip(weights).map(|(c, w)| c * w).sum()
}

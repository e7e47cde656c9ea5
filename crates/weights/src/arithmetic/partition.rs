//! Weighted sums whose weights sum to exactly 1.
//!
//! Weights are rounded to multiples of 2⁻²⁴, and the residual goes to the largest one. Every multiple
//! of 2⁻²⁴ in [0, 1] is an f32, and sums of them are exact in integers and in f64 alike.

/// Largest number of weights in one partition.
///
/// With N weights the largest is at least 1/N, that is 4096 units of 2⁻²⁴ or more, while rounding leaves a residual of
/// at most N/2 = 2048 units: the largest weight can always absorb it and stay positive.
pub const MAX_WEIGHTS: usize = 4096;

/// Number that, added and subtracted, rounds an f64 in [0, 1] to a multiple of 2⁻²⁴, ties to even: at 2²⁸ the spacing
/// of f64 is 2⁻²⁴.
const ROUND_F64: f64 = 268_435_456.0;

/// Rounds a weight in [0, 1] to the nearest multiple of 2⁻²⁴, ties to even.
///
/// From ½ up, an f32 is such a multiple already; below, adding ½ moves it into the range where the spacing is 2⁻²⁴.
#[inline(always)]
#[must_use]
pub fn round_weight(w: f32) -> f32 {
    if w < 0.5 { (w + 0.5) - 0.5 } else { w }
}

/// Rounds an f64 weight in [0, 1] to the nearest multiple of 2⁻²⁴, ties to even.
#[inline(always)]
pub(crate) fn round_f64(w: f64) -> f64 {
    (w + ROUND_F64) - ROUND_F64
}

/// Rounds weights ≥ 0 whose sum is nearly 1 to multiples of 2⁻²⁴ that sum to exactly 1.
///
/// Each weight is rounded to the nearest multiple; the residual goes to the largest weight, on ties to the first.
/// Weights that are 0 stay 0. At most [`MAX_WEIGHTS`] weights, summing to 1 within 10⁻⁴; then no weight moves by more
/// than 2⁻²⁵, except the largest. An empty slice stays empty.
///
/// The result does not depend on the order of the weights, except for ties of the largest.
#[inline]
pub fn round_partition(raw: &mut [f32]) {
    let mut largest = 0;
    let mut best = f32::NEG_INFINITY;
    let mut sum = 0.0_f64;
    for (index, weight) in raw.iter_mut().enumerate() {
        if *weight > best {
            best = *weight;
            largest = index;
        }
        *weight = round_weight(*weight);
        sum += f64::from(*weight);
    }
    debug_assert!(raw.len() <= MAX_WEIGHTS && (raw.is_empty() || (sum - 1.0).abs() < 1e-3));
    if let Some(weight) = raw.get_mut(largest) {
        *weight = (f64::from(*weight) + (1.0 - sum)) as f32;
    }
}

/// Rounds f64 weights like [`round_partition`], directly to multiples of 2⁻²⁴ instead of to f32 first.
#[inline]
fn round_from_f64(raw: impl Iterator<Item = f64>, out: &mut [f32]) {
    let mut largest = 0;
    let mut best = f64::NEG_INFINITY;
    let mut sum = 0.0_f64;
    for (index, (weight, out)) in raw.zip(out.iter_mut()).enumerate() {
        if weight > best {
            best = weight;
            largest = index;
        }
        let rounded = round_f64(weight);
        sum += rounded;
        *out = rounded as f32;
    }
    debug_assert!(out.len() <= MAX_WEIGHTS && (out.is_empty() || (sum - 1.0).abs() < 1e-3));
    if let Some(weight) = out.get_mut(largest) {
        *weight = (f64::from(*weight) + (1.0 - sum)) as f32;
    }
}

/// Converts a field value for Normalize: negative values count as 0; NaN and +∞, which are refused on reading, as 0
/// and as the largest finite value.
#[inline(always)]
pub(crate) fn share(v: f32) -> f64 {
    let positive = if v > 0.0 { v } else { 0.0 };
    f64::from(if positive < f32::MAX { positive } else { f32::MAX })
}

/// Returns the divisor of Normalize: max(S, τ). A τ that is not positive, which is refused on loading, counts as the
/// smallest positive normal number, so that there is no division by 0.
#[inline(always)]
pub(crate) fn divisor(sum: f64, floor: f32) -> f64 {
    let floor = f64::from(if floor > 0.0 { floor } else { f32::MIN_POSITIVE });
    if sum > floor { sum } else { floor }
}

/// Normalizes n values to n + 1 weights: w = max(v, 0)/max(S, τ), and the remainder as the last weight.
///
/// S is the sum of the non-negative values. `floor` = τ > 0 keeps the quotient Lipschitz continuous (2/τ) near zeros:
/// if all values are 0, the last weight is 1. The sum is taken in f64, where neither huge nor subnormal values
/// overflow or underflow; the weights are then rounded as by [`round_partition`].
///
/// # Panics
///
/// If `out` does not hold exactly one more value than `values`.
#[inline]
pub fn normalize(values: &[f32], floor: f32, out: &mut [f32]) {
    assert_eq!(out.len(), values.len() + 1, "normalize: one weight more than values");
    let sum: f64 = values.iter().map(|&v| share(v)).sum();
    let divisor = divisor(sum, floor);
    let remainder = (divisor - sum) / divisor;
    let weights = values.iter().map(|&v| share(v) / divisor);
    round_from_f64(weights.chain([remainder]), out);
}

/// Stacks n masks, the first on top, over a last layer that gets the remainder: n + 1 weights tᵢ·Πⱼ₍ⱼ<ᵢ₎(1 − tⱼ).
///
/// Computed in f64 (the sum is 1 within n·2⁻⁵²), then rounded as by [`round_partition`]. Under a mask of 1, all
/// weights are exactly 0.
///
/// # Panics
///
/// If `out` does not hold exactly one more value than `masks`.
#[inline]
pub fn stack(masks: &[f32], out: &mut [f32]) {
    assert_eq!(out.len(), masks.len() + 1, "stack: one weight more than masks");
    let mut rest = 1.0_f64;
    let layers = masks.iter().map(Some).chain([None]).map(|mask| match mask {
        Some(&t) => {
            let t = f64::from(t);
            let weight = rest * t;
            rest *= 1.0 - t;
            weight
        }
        None => rest,
    });
    round_from_f64(layers, out);
}

/// Adds one term of a weighted sum: `sum` + `weight`·`value`; `sum` does not change if the weight is 0.
///
/// The row form of [`blend`]: start at 0, add every term in order, convert to f32 at the end. The product of two f32
/// is exact in f64. Zero weights are skipped explicitly, so that controls that were never evaluated, and may have any
/// value, cannot influence the result.
#[inline(always)]
#[must_use]
pub fn accumulate(sum: f64, weight: f32, value: f32) -> f64 {
    let term = f64::from(weight) * f64::from(value);
    if weight == 0.0 { sum } else { sum + term }
}

/// Blends channel values: Σ wᵢ·cᵢ, accumulated in f64 and rounded once to f32.
///
/// `values` finite; `weights` ≥ 0, multiples of 2⁻²⁴ that sum to exactly 1 ([`round_partition`] makes them so). Extra
/// entries in the longer slice are not read. The result lies in [min cᵢ, max cᵢ] over the controls of non-zero weight,
/// is exact for equal operands, and a zero weight changes no bit, for any value of its operand.
///
/// *Proof.* Let m = max cᵢ and Wₖ = w₁ + … + wₖ. Wₖ·m is exact in f64: Wₖ is a multiple of 2⁻²⁴ in [0, 1], hence has
/// 24 bits, and so has m. Let sₖ be the partial sum as computed. If sₖ₋₁ ≤ Wₖ₋₁·m, then
/// sₖ₋₁ + wₖcₖ ≤ Wₖ₋₁·m + wₖ·m = Wₖ·m, and rounding is monotone, so sₖ ≤ Wₖ·m. By induction s ≤ 1·m, which is an f32,
/// so the last rounding keeps s ≤ m. The same holds from below for the minimum, and equal operands meet both. ∎
///
/// The order of the terms can change the last bit of the f64 sum, hence rarely the last bit of the result.
#[inline]
#[must_use]
pub fn blend(values: &[f32], weights: &[f32]) -> f32 {
    let terms = weights.iter().zip(values);
    terms.fold(0.0_f64, |sum, (&weight, &value)| accumulate(sum, weight, value)) as f32
}

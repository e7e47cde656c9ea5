//! Scalar f32 definitions of the convex operations, written so that rounding cannot break them.
//!
//! Masks are values in [0, 1]; color channels are finite and ≥ 0. Every function is pure, allocates nothing and gives
//! the same bits on every platform: it uses only IEEE operations with one correct result (+, −, ×, ÷, fused
//! multiply–add, conversions, comparisons), and `libm` (plain Rust) for fractional powers. All functions are
//! branch-free after inlining, so that a loop over a row vectorizes.
//!
//! Most proofs rest on one fact: **rounding is monotone**. If x ≤ y then fl(x) ≤ fl(y), so whenever y is itself a
//! floating-point number, x ≤ y implies fl(x) ≤ y. u = 2⁻²⁴ is the unit roundoff of f32.

mod partition;
pub(crate) mod powers;
mod rows;

pub use partition::{MAX_WEIGHTS, accumulate, blend, normalize, round_partition, round_weight, stack};
pub use rows::{normalize_rows, power_row, round_partition_rows, stack_rows};

/// Mixes two channel values: `a` at `t` = 0, `b` at `t` = 1.
///
/// `a`, `b` finite with finite difference (always so for colors, which are ≥ 0), `t` in [0, 1]. The result lies in
/// [min(a, b), max(a, b)], is exact at t = 0, at t = 1 and at a = b, and has an error of at most 1.5 ulp.
///
/// The usual forms are not sufficient: (1−t)·a + t·b is inexact at a = b, and a + t·(b−a) is inexact at t = 1.
/// Starting from the nearer end corrects both.
///
/// *Proof*, for a ≤ b (else mirror). Let d = fl(b − a) ≤ (b − a)(1 + u); d ≥ 0 because rounding is monotone.
/// For t < ½, t ≤ ½ − u/2 and a ≤ a + t·d ≤ a + (½ − u/2)(1 + u)(b − a) ≤ b; the fused multiply–add rounds that sum
/// once, and a and b are floating-point numbers, so the rounded value stays between them. For t ≥ ½, t − 1 is exact
/// (Sterbenz) and lies in [−½, 0], so b − ½(1 + u)(b − a) ≤ b + (t−1)·d ≤ b, and the left side is ≥ a. ∎
///
/// A mix of equal zeros of different sign is a zero of either sign.
#[inline(always)]
#[must_use]
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    let near_a = t < 0.5;
    let from = if near_a { a } else { b };
    let by = if near_a { t } else { t - 1.0 };
    by.mul_add(b - a, from)
}

/// Absolute value from which on the bounds of [`clamp`] are halved: 2¹²⁶.
pub const LARGE: f32 = 8.507_059e37;

/// Maps a field value to a mask: 0 below `min`, 1 from `max` on, linear between.
///
/// The cases are tried in this order: `x ≥ max` → 1; `x ≥ min` → (x − min)/(max − min); else 0. So `max = min` is a
/// step at `max`, +∞ gives 1, −∞ gives 0, and NaN gives 0. Bounds should be finite with min ≤ max; the result is in
/// [0, 1] for any bounds.
///
/// *Proof.* Between the bounds min ≤ x < max, hence 0 ≤ fl(x − min) ≤ fl(max − min) by monotone rounding, and the
/// denominator is not 0, for a difference of unequal floating-point numbers never rounds to 0. A quotient of
/// 0 ≤ n ≤ d is ≤ 1, and 1 is representable. Multiplying by a rounded reciprocal would exceed 1 for some x. For the
/// same reason the result is monotone in x. ∎
///
/// If a bound reaches 2¹²⁶, the difference could overflow, so all three values are halved first. Halving is exact
/// except for subnormals, which are then less than 2⁻²⁵⁰ of the width: the quotient rounds to 0 with or without them.
#[inline(always)]
#[must_use]
pub fn clamp(x: f32, min: f32, max: f32) -> f32 {
    let large = (min.abs() >= LARGE) | (max.abs() >= LARGE);
    let scale = if large { 0.5 } else { 1.0 };
    let origin = min * scale;
    let quotient = (x * scale - origin) / (max * scale - origin);
    // Also replaces the NaN of an infinite `min`, and −0, with 0.
    let ramp = if quotient > 0.0 { quotient } else { 0.0 };
    let below_max = if x >= min { ramp } else { 0.0 };
    if x >= max { 1.0 } else { below_max }
}

/// Smooths a mask: t²·(3 − 2t), with slope 0 at both ends.
///
/// `t` in [0, 1]. The result lies in [0, 1], is monotone in `t`, and exact at 0, ½ and 1.
///
/// *Proof.* In f64, t² is exact (48 bits), and 3 − 2t is exact for t ≥ 2⁻²⁸, so the product is rounded only once there,
/// and rounding of a monotone function is monotone. Below 2⁻²⁸ the next t is at least 2⁻²⁴ larger in proportion, which
/// the two errors of 2⁻⁵³ cannot undo. Rounding to f32 is monotone again. The values at 0, ½ and 1 need few bits, and
/// monotone with f(0) = 0 and f(1) = 1 means within [0, 1]. In f32 alone, monotonicity is lost near 1, where the slope
/// falls below the rounding error. ∎
#[inline(always)]
#[must_use]
pub fn smooth(t: f32) -> f32 {
    let t = f64::from(t);
    (t * t * (3.0 - 2.0 * t)) as f32
}

/// Raises a mask to the power `p` ≥ 1, a change of contrast that keeps 0 and 1.
///
/// `t` in [0, 1]. The result lies in [0, t], is exact at 0 and 1, and `p` = 1 is the identity. Integer powers up to 16
/// are products; others go through `libm`. Both are computed in f64 and rounded to f32, error below 1 ulp.
///
/// *Proof.* Products of factors in [0, 1] stay in [0, 1] since 0 and 1 are representable; the final `min` holds the
/// bound t^p ≤ t for every p ≥ 1, independently of the quality of `libm`. ∎
///
/// For a row with one `p`, [`power_row`] is faster, since it chooses the method once.
#[inline(always)]
#[must_use]
pub fn power(t: f32, p: f32) -> f32 {
    if p == 1.0 {
        t
    } else if p <= 16.0 && p == p.trunc() {
        integer_power(t, p as u32)
    } else {
        fractional_power(t, p)
    }
}

/// Raises `t` to an integer power n ≥ 1, by square and multiply in f64.
#[inline(always)]
fn integer_power(t: f32, n: u32) -> f32 {
    let mut square = f64::from(t);
    let mut result = 1.0;
    let mut n = n;
    while n > 0 {
        if n & 1 == 1 {
            result *= square;
        }
        square *= square;
        n >>= 1;
    }
    at_most(result as f32, t)
}

#[inline(always)]
fn fractional_power(t: f32, p: f32) -> f32 {
    at_most(libm::pow(f64::from(t), f64::from(p)) as f32, t)
}

/// Returns the smaller of `value` and `bound`; `bound` if `value` is NaN.
#[inline(always)]
fn at_most(value: f32, bound: f32) -> f32 {
    if value < bound { value } else { bound }
}

/// Makes a hard mask: 1 where `x ≥ threshold`, else 0. NaN gives 0, +∞ gives 1.
#[inline(always)]
#[must_use]
pub fn step(x: f32, threshold: f32) -> f32 {
    if x >= threshold { 1.0 } else { 0.0 }
}

/// Inverts a mask: 1 − t.
///
/// `t` in [0, 1]; the result is in [0, 1] and decreases monotonically. Exact for t ≥ ½ and for all multiples of 2⁻²⁴;
/// other t
/// are rounded by at most 2⁻²⁵. If a graph only needs the reversed mix, swapping its operands is exact.
#[inline(always)]
#[must_use]
pub fn complement(t: f32) -> f32 {
    1.0 - t
}

/// Multiplies two masks: a·b.
///
/// Operands in [0, 1]. The result lies in [0, min(a, b)], because a·b ≤ min(a, b) and rounding is monotone; exact if
/// one operand is 0 or 1.
#[inline(always)]
#[must_use]
pub fn product(a: f32, b: f32) -> f32 {
    a * b
}

/// Screens two masks: 1 − (1 − a)(1 − b), computed as a mix from the larger mask to 1 by the smaller one.
///
/// Operands in [0, 1]. The result lies in [max(a, b), 1] by the proof of [`mix`], is exact where one operand is 0 or
/// 1, and does not change when the operands are swapped. Several masks are folded from the left; their order
/// changes only the last bits.
#[inline(always)]
#[must_use]
pub fn screen(a: f32, b: f32) -> f32 {
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    mix(large, 1.0, small)
}

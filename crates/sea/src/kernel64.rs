//! Vector functions in f64 with the same bits on every processor: plain products, sums and exact roundings.

use fearless_simd::{Simd, f64x8, prelude::*, u64x8};
use std::f64::consts::LOG2_E;

/// Number of values that are computed side by side.
pub const LANES: usize = 8;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest integer, ties to even, exactly. After adding, the
/// lowest bits are those of the integer.
pub(crate) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Largest number of halvings.
const MOST: f64 = 1000.0;
/// Exponent of e from which a power counts as infinite: a little less than 1000·ln 2.
const LARGEST: f64 = 693.0;

/// Coefficients of sin(πy)/y and of cos(πy) in y², the highest first, and of 2⁻ᵈ in d: the polynomials through the function
/// in Chebyshev points of |y| ≤ ½ and |d| ≤ ½. The sine is off by 3e-16, the cosine by 1e-16, and the power by 3e-16.
#[allow(clippy::approx_constant, reason = "the best polynomial's own coefficient")]
pub(crate) const SINE: [f64; 8] = [
    -2.113_362_735_205_297e-5,
    0.000_465_987_015_804_337_8,
    -0.007_370_364_326_530_415_5,
    0.082_145_878_816_310_43,
    -0.599_264_528_825_224,
    2.550_164_039_861_867_7,
    -5.167_712_780_049_785_5,
    3.141_592_653_589_792_7,
];
pub(crate) const COSINE: [f64; 9] = [
    4.149_564_353_942_586e-6,
    -0.000_104_566_553_387_487_38,
    0.001_929_556_272_481_713_2,
    -0.025_806_888_737_002_202,
    0.235_330_630_129_532_84,
    -1.335_262_768_843_447,
    4.058_712_126_416_497,
    -4.934_802_200_544_676,
    1.0,
];
#[allow(clippy::approx_constant, reason = "the best polynomial's own coefficient")]
const POWER: [f64; 11] = [
    7.072_585_949_269_223e-9,
    -1.020_869_029_995_830_6e-7,
    1.321_544_258_792_169e-6,
    -1.525_265_726_020_083_7e-5,
    0.000_154_035_304_417_360_5,
    -0.001_333_355_823_016_497_4,
    0.009_618_129_107_606_888,
    -0.055_504_108_664_447_72,
    0.240_226_506_959_100_97,
    -0.693_147_180_559_95,
    1.0,
];

/// Returns sin and cos of an angle in half turns, |angle| < 2⁵¹, each to 1e-15.
#[inline(always)]
pub(crate) fn sincos<S: Simd>(simd: S, half_turns: f64x8<S>) -> [f64x8<S>; 2] {
    let shifted = half_turns + ROUNDER;
    let y = half_turns - (shifted - ROUNDER);
    let y2 = y * y;
    // An odd number of half turns changes both signs.
    let flip = shifted.bitcast::<u64x8<S>>() << 63;
    [flipped(polynomial(simd, &SINE, y2) * y, flip), flipped(polynomial(simd, &COSINE, y2), flip)]
}

#[inline(always)]
fn flipped<S: Simd>(value: f64x8<S>, flip: u64x8<S>) -> f64x8<S> {
    (value.bitcast::<u64x8<S>>() ^ flip).bitcast()
}

/// Returns eˣ with a relative error of 1e-15 + |x|·3e-16, for any x that is not NaN; never less than 2⁻¹⁰⁰⁰, and infinite
/// from e⁶⁹³ on.
#[inline(always)]
pub fn exp<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let power = halved(simd, (x * -LOG2_E).max(f64x8::splat(simd, -MOST)));
    let infinite = f64x8::splat(simd, f64::INFINITY);
    simd.select_f64x8(simd.simd_lt_f64x8(x, f64x8::splat(simd, LARGEST)), power, infinite)
}

/// Returns 2⁻ⁿ for a number of halvings n ≥ −1000, not necessarily whole, with a relative error of 1e-15; never less than
/// 2⁻¹⁰⁰⁰.
#[inline(always)]
pub(crate) fn halved<S: Simd>(simd: S, halvings: f64x8<S>) -> f64x8<S> {
    const SHIFT: f64 = ROUNDER + 1023.0;
    let halvings = halvings.min(f64x8::splat(simd, MOST));
    let shifted = f64x8::splat(simd, SHIFT) - halvings;
    let rest = (shifted - SHIFT) + halvings;
    // The whole power of 2: its exponent is in the lowest bits.
    let whole: f64x8<S> = (shifted.bitcast::<u64x8<S>>() << 52).bitcast();
    polynomial(simd, &POWER, rest) * whole
}

#[inline(always)]
fn polynomial<S: Simd, const N: usize>(simd: S, coefficients: &[f64; N], x: f64x8<S>) -> f64x8<S> {
    let mut value = f64x8::splat(simd, coefficients[0]);
    for coefficient in &coefficients[1..] {
        value = value * x + *coefficient;
    }
    value
}

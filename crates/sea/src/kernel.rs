//! Vector arithmetic with the same bits on every processor: plain products, sums and exact roundings.

use fearless_simd::{Simd, f32x16, i32x16, prelude::*};

/// Number of points that a kernel processes at once.
pub(crate) const LANES: usize = 16;

/// 1.5·2²³: adding and subtracting it rounds |v| < 2²² to the nearest integer, ties to even, exactly.
const ROUNDER: f32 = 12_582_912.0;

/// Coefficients of sin(2πy)/y in y², then of cos(2πy): (2π)ⁿ/n! with alternating signs. On |y| ≤ ¼ the truncation
/// errors are below 6e-8 and 7e-9.
const SIN: [f32; 6] = [6.283_185_5, -41.341_7, 81.605_25, -76.705_86, 42.058_693, -15.094_643];
const COS: [f32; 7] = [1.0, -19.739_209, 64.939_39, -85.456_82, 60.244_64, -26.426_256, 7.903_536];

/// Returns sin and cos of an angle in turns, |t| < 2²².
#[inline(always)]
pub(crate) fn sincos_turns<S: Simd>(t: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let r = t - ((t + ROUNDER) - ROUNDER);
    // r = y + q/2 with q ∈ {−1, 0, 1} and |y| ≤ ¼; half a turn changes both signs: 1 − 2q².
    let q = ((r + r) + ROUNDER) - ROUNDER;
    let y = r - q * 0.5;
    let sign = (q * q) * -2.0 + 1.0;
    let y2 = y * y;
    let mut s = y2 * SIN[5] + SIN[4];
    let mut c = y2 * COS[6] + COS[5];
    s = s * y2 + SIN[3];
    c = c * y2 + COS[4];
    s = s * y2 + SIN[2];
    c = c * y2 + COS[3];
    s = s * y2 + SIN[1];
    c = c * y2 + COS[2];
    s = s * y2 + SIN[0];
    c = c * y2 + COS[1];
    c = c * y2 + COS[0];
    (s * (y * sign), c * sign)
}

/// Coefficients of 2^f: (ln 2)ⁿ/n!. On |f| ≤ ½ the truncation error is below 6e-9.
const EXP2: [f32; 8] = [
    1.0,
    std::f32::consts::LN_2,
    0.240_226_5,
    0.055_504_11,
    0.009_618_129,
    0.001_333_355_8,
    0.000_154_035_3,
    0.000_015_252_734,
];

/// Returns exp(−e) for e ≥ 0, but not less than 2⁻¹²⁰.
#[inline(always)]
pub(crate) fn exp_neg<S: Simd>(simd: S, e: f32x16<S>) -> f32x16<S> {
    let power = (e * -std::f32::consts::LOG2_E).max(f32x16::splat(simd, -120.0));
    let whole = (power + ROUNDER) - ROUNDER;
    let f = power - whole;
    let mut value = f * EXP2[7] + EXP2[6];
    for n in (0..6).rev() {
        value = value * f + EXP2[n];
    }
    // 2^whole, written into the exponent bits.
    let bits: i32x16<S> = (whole + 127.0).to_int::<i32x16<S>>() << 23;
    value * bits.bitcast::<f32x16<S>>()
}

//! exp(s · log1p(x)) for lobes, vectorized.
//!
//! These are the steps of `libm`'s `log1pf` and `expf` (FreeBSD's s_log1pf.c and e_expf.c) for the arguments that
//! lobes have, with every branch computed and the right one selected: loops over them are vectorized and give the
//! same bits.

const LN2_HI: f32 = f32::from_bits(0x3f31_7180);
const LN2_LO: f32 = f32::from_bits(0x3717_f7d1);
const LG: [f32; 4] = [0.666_666_6, 0.400_009_72, 0.284_987_87, 0.242_790_79];

/// Returns log(1 + x) for x in [−1, 0].
#[inline(always)]
pub(crate) fn log1p(x: f32) -> f32 {
    let u = 1.0 + x;
    // 1 + x is at least about √½, so no power of two is factored out.
    let near = x.to_bits() <= 0xbe95_f619;
    let raised = u.to_bits().wrapping_add(0x3f80_0000 - 0x3f35_04f3);
    let k = if near { 0.0 } else { ((raised >> 23) as i32 - 0x7f) as f32 };
    let rounding = if near { 0.0 } else { (x - (u - 1.0)) / u };
    let f = if near { x } else { f32::from_bits((raised & 0x007f_ffff) + 0x3f35_04f3) - 1.0 };
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (LG[1] + w * LG[3]);
    let odd = z * (LG[0] + w * LG[2]);
    let half = 0.5 * f * f;
    let log = s * (half + (odd + even)) + (k * LN2_LO + rounding) - half + f + k * LN2_HI;
    let tiny = x.abs() < 5.960_464_5e-8;
    let log = if tiny { x } else { log };
    if x == -1.0 { f32::NEG_INFINITY } else { log }
}

const EXP_LN2_HI: f32 = 6.931_457_5e-1;
const EXP_LN2_LO: f32 = 1.428_606_8e-6;
const INV_LN2: f32 = std::f32::consts::LOG2_E;
const P: [f32; 2] = [1.666_662_5e-1, -2.766_733_3e-3];

/// Returns e to the power y ≤ 0, or NaN.
#[inline(always)]
pub(crate) fn exp(y: f32) -> f32 {
    let size = y.to_bits() & 0x7fff_ffff;
    let whole = if size > 0x3f85_1592 { INV_LN2 * y - 0.5 } else { -1.0 };
    let k = if size > 0x3eb1_7218 { (whole as i32).max(-150) } else { 0 };
    let hi = y - k as f32 * EXP_LN2_HI;
    let lo = k as f32 * EXP_LN2_LO;
    let x = hi - lo;
    let xx = x * x;
    let c = x - xx * (P[0] + xx * P[1]);
    let value = 1.0 + (x * c / (2.0 - c) - lo + hi);
    // In two steps, the first of them exact, so that a subnormal result is rounded once.
    let first = k.max(-102);
    let power = |k: i32| f32::from_bits(((k + 127) as u32) << 23);
    let value = value * power(first) * power(k - first);
    let value = if size <= 0x3900_0000 { 1.0 + y } else { value };
    let value = if size >= 0x42cf_f1b5 { 0.0 } else { value };
    if size > 0x7f80_0000 { y } else { value }
}

//! Powers of several numbers side by side, with the bits of `libm::pow`.
//!
//! Each lane takes the steps of `libm::pow` for an ordinary base and exponent: the logarithm to base 2 in two parts, their
//! product with the exponent in two parts, and 2 to that power. Choices are made by masks of bits, so that loops become
//! vectors.
//!
//! Source: `e_pow.c` of FreeBSD, by Sun Microsystems, which `libm` follows.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]
#![expect(clippy::excessive_precision, reason = "digits as in the source")]

/// Numbers that are computed side by side.
pub(crate) const LANES: usize = 8;

/// Polynomial of the logarithm, after 2s + 2/3·s³ of s = (x − b)/(x + b).
const L: [f64; 6] = [
    5.99999999999994648725e-01,
    4.28571428578550184252e-01,
    3.33333329818377432918e-01,
    2.72728123808534006489e-01,
    2.30660745775561754067e-01,
    2.06975017800338417784e-01,
];
/// Polynomial of the exponential.
const P: [f64; 5] = [
    1.66666666666666019037e-01,
    -2.77777777770155933842e-03,
    6.61375632143793436117e-05,
    -1.65339022054652515390e-06,
    4.13813679705723846039e-08,
];
/// 2/(3·ln 2): whole, and in two parts.
const CP: f64 = 9.61796693925975554329e-01;
const CP_H: f64 = 9.61796700954437255859e-01;
const CP_L: f64 = -7.02846165095275826516e-09;
/// ln 2: whole, and in two parts.
const LN2: f64 = std::f64::consts::LN_2;
const LN2_H: f64 = 6.93147182464599609375e-01;
const LN2_L: f64 = -1.90465429995776804525e-09;
/// log₂ 1.5 in two parts.
const LOG_H: f64 = 5.84962487220764160156e-01;
const LOG_L: f64 = 1.35003920212974897128e-08;

/// Returns whether an exponent is ordinary: `libm::pow` takes no other way because of it.
pub(crate) fn is_ordinary(p: f64) -> bool {
    p > 0.0 && p < 2_147_483_648.0 && p != 0.5 && p != 1.0 && p != 2.0
}

/// Returns `number` if `mask` has all bits, or 0 if it has none.
#[inline(always)]
fn chosen(mask: u64, number: f64) -> f64 {
    f64::from_bits(number.to_bits() & mask)
}

/// Returns a number without the lower half of its bits.
#[inline(always)]
fn upper(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & 0xffff_ffff_0000_0000)
}

/// Raises numbers to an [ordinary](is_ordinary) power; `None` if one of them is negative, infinite or NaN, or a power so
/// large or small that it is not normal.
#[inline(always)]
pub(crate) fn powers(numbers: [f32; LANES], p: f64) -> Option<[f64; LANES]> {
    let p_h = upper(p);
    let (mut powers, mut strange) = ([0.0; LANES], [0_u64; LANES]);
    for lane in 0..LANES {
        let x = f64::from(numbers[lane]);
        // x = 2ⁿ·a with a/b near 1, for b = 1 or 1.5.
        let bits = x.to_bits();
        let fraction = bits >> 32 & 0xf_ffff;
        let is_high = u64::from(fraction >= 0xb_b67a);
        let is_middle = u64::from(fraction > 0x3_988e) & (1 ^ is_high);
        let n = ((bits >> 52) as i32 - 1023 + is_high as i32) as f64;
        let a = (bits & 0xf_ffff_ffff_ffff | 0x3ff << 52) - (is_high << 52);
        let middle = 0_u64.wrapping_sub(is_middle);
        let b = 1.0 + chosen(middle, 0.5);
        let sum_h = f64::from_bits(((a >> 33 | 0x2000_0000) + 0x8_0000 + (is_middle << 18)) << 32);
        let a = f64::from_bits(a);
        // s = (a − b)/(a + b).
        let u = a - b;
        let v = 1.0 / (a + b);
        let s = u * v;
        let s_h = upper(s);
        let sum_l = a - (sum_h - b);
        let s_l = v * ((u - s_h * sum_h) - s_h * sum_l);
        // The logarithm.
        let s2 = s * s;
        let mut r = s2 * s2 * (L[0] + s2 * (L[1] + s2 * (L[2] + s2 * (L[3] + s2 * (L[4] + s2 * L[5])))));
        r += s_l * (s_h + s);
        let s2 = s_h * s_h;
        let t_h = upper(3.0 + s2 + r);
        let t_l = r - ((t_h - 3.0) - s2);
        let u = s_h * t_h;
        let v = s_l * t_h + t_l * s;
        let q_h = upper(u + v);
        let q_l = v - (q_h - u);
        let z_h = CP_H * q_h;
        let z_l = CP_L * q_h + q_l * CP + chosen(middle, LOG_L);
        let log_h = chosen(middle, LOG_H);
        let t1 = upper(((z_h + z_l) + log_h) + n);
        let t2 = z_l - (((t1 - n) - log_h) - z_h);
        // Its product with the exponent.
        let y_l = (p - p_h) * t1 + p * t2;
        let mut y_h = p_h * t1;
        let y = y_l + y_h;
        // 2 to that power: of the nearest whole number, unless it is 0, and of the rest.
        let is_far = u64::from(y.to_bits() >> 32 & 0x7fff_ffff > 0x3fe0_0000);
        let whole = (y.abs() + 0.5).min(2048.0) as i32 & 0_i32.wrapping_sub(is_far as i32);
        let sign = (y.to_bits() as i64 >> 63) as i32;
        let whole = (whole ^ sign) - sign;
        y_h -= f64::from(whole);
        let t = upper(y_l + y_h);
        let u = t * LN2_H;
        let v = (y_l - (t - y_h)) * LN2 + t * LN2_L;
        let z = u + v;
        let w = v - (z - u);
        let t = z * z;
        let t1 = z - t * (P[0] + t * (P[1] + t * (P[2] + t * (P[3] + t * P[4]))));
        let r = (z * t1) / (t1 - 2.0) - (w + z * w);
        let z = 1.0 - (r - z);
        let power = f64::from_bits(z.to_bits().wrapping_add((whole as i64 as u64) << 52));
        // 0 stays 0, and 1 stays 1.
        let is_fixed = u64::from(x == 0.0) | u64::from(x == 1.0);
        let fixed = 0_u64.wrapping_sub(is_fixed);
        powers[lane] = f64::from_bits(power.to_bits() & !fixed | x.to_bits() & fixed);
        let is_plain = u64::from(x >= 0.0) & u64::from(x < f64::INFINITY) & u64::from(y.abs() < 1000.0);
        strange[lane] = 1 ^ (is_plain | is_fixed);
    }
    let strange = strange.iter().fold(0, |all, strange| all | strange);
    (strange == 0).then_some(powers)
}

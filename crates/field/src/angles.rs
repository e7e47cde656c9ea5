//! Sines and cosines of several numbers side by side, with the bits of `libm::sincos`.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]
#![expect(clippy::excessive_precision, reason = "digits as in the source")]

/// Polynomial of (sin x − x)/x³ in x².
const S: [f64; 6] = [
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
];
/// Polynomial of (cos x − 1 + x²/2)/x⁴ in x².
const C: [f64; 6] = [
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
];
/// Upper halves of the bits of the largest magnitudes that need no reduction, about π/4, and of those whose sine is the
/// number itself, about 2⁻²⁷·√2.
const NEAR: u64 = 0x3fe9_21fb;
const TINY: u64 = 0x3e46_a09e;

/// Returns the sine and the cosine of each number, in radians: the steps of `libm::sincos` for all numbers, with choices by
/// masks, so that loops become vectors where the caller compiles them for these. Numbers beyond ±π/4 and NaN take longer.
///
/// Source: `k_sin.c` and `k_cos.c` of FreeBSD, by Sun Microsystems, which `libm` follows.
///
/// ```
/// let [sines, cosines] = trochoid_field::sines_and_cosines([0.0, 0.5]);
/// assert_eq!((sines[1], cosines[1]), libm::sincos(0.5));
/// ```
#[inline(always)]
pub fn sines_and_cosines<const N: usize>(numbers: [f64; N]) -> [[f64; N]; 2] {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    let mut far = 0;
    for lane in 0..N {
        let x = numbers[lane];
        let upper = x.to_bits() >> 32 & 0x7fff_ffff;
        far |= u64::from(upper > NEAR);
        let z = x * x;
        let w = z * z;
        let r = S[1] + z * (S[2] + z * S[3]) + z * w * (S[4] + z * S[5]);
        let sine = x + z * x * (S[0] + z * r);
        sines[lane] = if upper < TINY { x } else { sine };
        let r = z * (C[0] + z * (C[1] + z * C[2])) + w * w * (C[3] + z * (C[4] + z * C[5]));
        let half = 0.5 * z;
        let w = 1.0 - half;
        let cosine = w + ((1.0 - w - half) + z * r);
        cosines[lane] = if upper < TINY { 1.0 } else { cosine };
    }
    if far != 0 {
        for lane in 0..N {
            (sines[lane], cosines[lane]) = libm::sincos(numbers[lane]);
        }
    }
    [sines, cosines]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bits_are_those_of_single_sines_and_cosines() {
        let near = |x: f64| [-2, -1, 0, 1, 2].map(|by: i64| f64::from_bits((x.to_bits() as i64 + by) as u64));
        let halves = [NEAR, NEAR + 1, TINY, TINY + 1].map(|upper| f64::from_bits(upper << 32));
        let places = [std::f64::consts::FRAC_PI_4, 1e-3, 2.0_f64.powi(-28), f64::MIN_POSITIVE, 1e300];
        let mut numbers: Vec<f64> = places.into_iter().chain(halves).flat_map(near).collect();
        numbers.extend([0.0, f64::INFINITY, f64::NAN, 5e-324]);
        let mut random = 1_u64;
        for _ in 0..200_000 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let part = (random >> 11) as f64 / (1_u64 << 53) as f64;
            numbers.extend([part * 0.785, 2.0_f64.powf(part * 40.0 - 40.0)]);
        }
        numbers.extend(numbers.clone().into_iter().map(|number| -number));
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
        for numbers in numbers.as_chunks::<4>().0 {
            let [sines, cosines] = sines_and_cosines(*numbers);
            for ((number, sine), cosine) in numbers.iter().zip(sines).zip(cosines) {
                let alone = libm::sincos(*number);
                assert!(same(alone.0, sine) && same(alone.1, cosine), "{number:e}");
            }
        }
    }
}

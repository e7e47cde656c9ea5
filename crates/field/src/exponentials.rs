//! Exponentials of several numbers side by side, with the bits of `libm::exp`.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]
#![expect(clippy::excessive_precision, reason = "digits as in the source")]

/// ln 2 in two parts, of which the first has so few digits that its products with small whole numbers are exact.
const LN2_H: f64 = 6.93147180369123816490e-01;
const LN2_L: f64 = 1.90821492927058770002e-10;
/// Polynomial of x·(eˣ + 1)/(eˣ − 1) in x², without its first term 2.
const P: [f64; 5] = [
    1.66666666666666019037e-01,
    -2.77777777770155933842e-03,
    6.61375632143793436117e-05,
    -1.65339022054652515390e-06,
    4.13813679705723846039e-08,
];
/// Largest magnitude of numbers whose exponentials are far from the ends of the range of f64.
const FAR: f64 = 700.0;

/// Returns eˣ of each number: the steps of `libm::exp` for all numbers, with choices by masks, so that loops become vectors
/// where the caller compiles them for these. Numbers beyond ±700 and NaN take longer.
///
/// Source: `e_exp.c` of FreeBSD, by Sun Microsystems, which `libm` follows.
///
/// ```
/// let [one, e] = trochoid_field::exponentials([0.0, 1.0]);
/// assert_eq!([one, e], [1.0, libm::exp(1.0)]);
/// ```
#[inline(always)]
pub fn exponentials<const N: usize>(numbers: [f64; N]) -> [f64; N] {
    let mut exponentials = [0.0; N];
    let mut strange = false;
    for lane in 0..N {
        let given = numbers[lane];
        let is_near = given.abs() <= FAR;
        strange |= !is_near;
        let number = if is_near { given } else { 0.0 };
        // x = k·ln 2 + rest, by the upper half of the bits: k is 0 up to half of ln 2, and ±1 up to 1.5 times.
        let upper = number.to_bits() >> 32 & 0x7fff_ffff;
        let half = if number.to_bits() >> 63 == 1 { -0.5 } else { 0.5 };
        let nearest = f64::from((std::f64::consts::LOG2_E * number + half) as i32);
        let k = if upper >= 0x3ff0_a2b2 { nearest } else { 2.0 * half };
        let k = if upper > 0x3fd6_2e42 { k } else { 0.0 };
        let (high, low) = (number - k * LN2_H, k * LN2_L);
        let x = high - low;
        let xx = x * x;
        let c = x - xx * (P[0] + xx * (P[1] + xx * (P[2] + xx * (P[3] + xx * P[4]))));
        let y = 1.0 + (x * c / (2.0 - c) - low + high);
        let y = if upper > 0x3e30_0000 { y } else { 1.0 + number };
        exponentials[lane] = f64::from_bits(y.to_bits().wrapping_add((k as i32 as i64 as u64) << 52));
    }
    if strange {
        for (exponential, number) in exponentials.iter_mut().zip(numbers) {
            if number.is_nan() || number.abs() > FAR {
                *exponential = libm::exp(number);
            }
        }
    }
    exponentials
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bits_are_those_of_single_exponentials() {
        let ln2 = std::f64::consts::LN_2;
        let near = |x: f64| [-2, -1, 0, 1, 2].map(|by: i64| f64::from_bits((x.to_bits() as i64 + by) as u64));
        let places =
            [0.5 * ln2, 1.5 * ln2, 2.0_f64.powi(-28), 40.0, FAR, 708.4, 709.79, 745.2, f64::MIN_POSITIVE, 1e300];
        let upper_halves = [0x3fd6_2e42_u64, 0x3ff0_a2b2, 0x3e30_0000].map(|upper| f64::from_bits(upper << 32));
        let mut numbers: Vec<f64> = places.into_iter().chain(upper_halves).flat_map(near).collect();
        numbers.extend([0.0, f64::INFINITY, f64::NAN, 5e-324]);
        // Spread over all sizes, and evenly over those that do not overflow.
        let mut random = 1_u64;
        for _ in 0..200_000 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let part = (random >> 11) as f64 / (1_u64 << 53) as f64;
            numbers.extend([part * 750.0, 2.0_f64.powf(part * 40.0 - 30.0), f64::from_bits(random)]);
        }
        numbers.extend(numbers.clone().into_iter().map(|number| -number));
        for numbers in numbers.as_chunks::<8>().0 {
            let together = exponentials(*numbers);
            for (number, exponential) in numbers.iter().zip(together) {
                let alone = libm::exp(*number);
                assert!(
                    alone.to_bits() == exponential.to_bits() || alone.is_nan() && exponential.is_nan(),
                    "{number:e}"
                );
            }
        }
    }
}

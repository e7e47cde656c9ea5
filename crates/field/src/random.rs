//! Random numbers as hashes of keys, computed with integers only and therefore the same on every machine.

/// Mixes all bits of a number (the finalizer of SplitMix64).
#[inline(always)]
fn scrambled(number: u64) -> u64 {
    let z = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 2⁶⁴ divided by the golden ratio; its multiples are spread evenly.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Derives a key from a key and a number.
#[inline(always)]
pub fn key(key: u64, number: i64) -> u64 {
    scrambled(key.wrapping_add(GOLDEN).wrapping_add((number as u64).wrapping_mul(0xd6e8_feb8_6659_fd93)))
}

/// Returns random number `which` of a key, in [0, 1).
#[inline(always)]
pub fn draw(key: u64, which: u64) -> f64 {
    let bits = scrambled(key.wrapping_add(which.wrapping_mul(GOLDEN)));
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even_and_unlike() {
        let mut sums = [0.0; 4];
        let count = 20_000;
        for cell in 0..count {
            let cell = key(key(7, cell % 150 - 75), cell / 150);
            let (a, b) = (draw(cell, 1), draw(cell, 2));
            assert!((0.0..1.0).contains(&a) && (0.0..1.0).contains(&b));
            for (sum, term) in sums.iter_mut().zip([a, a * a, a * b, b]) {
                *sum += term / count as f64;
            }
        }
        for (mean, expected) in sums.into_iter().zip([0.5, 1.0 / 3.0, 0.25, 0.5]) {
            assert!((mean - expected).abs() < 0.01, "{mean}, expected {expected}");
        }
        assert_ne!(key(1, -1), key(1, 1));
    }
}

//! Tests of transforms against the plain sum.

use crate::random::Random;
use std::f64::consts::TAU;
use trochoid_sea::inside::inverse_transform;

/// Returns the plain sum: Σ value·e^{2πi·index·k/length}, for each k.
fn truth(values: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let length = values.len();
    let roots: Vec<(f64, f64)> = (0..length).map(|k| libm::sincos(TAU * k as f64 / length as f64)).collect();
    let sum = |k: usize| {
        let (mut re, mut im, mut at) = (0.0, 0.0, 0);
        for [a, b] in values {
            let (sin, cos) = roots[at];
            re += a * cos - b * sin;
            im += a * sin + b * cos;
            at = (at + k) % length;
        }
        [re, im]
    };
    (0..length).map(sum).collect()
}

#[test]
fn transforms_are_the_plain_sum() {
    let is_smooth = |length: usize| {
        [2, 3, 5].iter().fold(length, |mut rest, prime| {
            while rest.is_multiple_of(*prime) {
                rest /= prime;
            }
            rest
        }) == 1
    };
    let mut random = Random(9);
    // All lengths that are used, up to some hundreds, and larger ones with each base and each radix above it; then
    // others, for which transforms are slow but right.
    let large = [625, 648, 1000, 1080, 1215, 1350, 1536, 1875, 2048, 2160, 2430, 2500, 2592, 3000, 3125, 3600];
    let lengths = (0..=600).filter(|&length| length == 0 || is_smooth(length)).chain(large).chain([7, 22, 35, 97]);
    for length in lengths {
        let values: Vec<[f64; 2]> = (0..length).map(|_| [0, 1].map(|_| random.between(-1.0, 1.0))).collect();
        let (found, truth) = (inverse_transform(&values), truth(&values));
        assert_eq!(found.len(), length);
        let worst = found.iter().zip(&truth).flat_map(|(found, truth)| [found[0] - truth[0], found[1] - truth[1]]);
        let worst = worst.fold(0.0, |worst: f64, off| worst.max(off.abs()));
        assert!(worst <= 1e-12 * (length as f64).sqrt(), "{length}: {worst}");
    }
}

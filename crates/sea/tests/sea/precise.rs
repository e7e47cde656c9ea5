//! Tests of the functions of precise sums.

use std::f64::consts::PI;
use trochoid_sea::inside::{exp, halved, sincos_half_turns};

#[test]
fn sines_and_cosines_are_exact_to_rounding() {
    for step in -20_000_i64..=20_000 {
        let angles: [f64; 8] = std::array::from_fn(|lane| (step as f64 + lane as f64 / 8.0) / 1e4);
        let [sin, cos] = sincos_half_turns(angles);
        for lane in 0..8 {
            let (expected_sin, expected_cos) = libm::sincos(PI * angles[lane]);
            let off = (sin[lane] - expected_sin).abs().max((cos[lane] - expected_cos).abs());
            assert!(off < 1e-15, "{} half turns are off by {off}", angles[lane]);
        }
    }
    // Whole numbers of half turns are taken off exactly, and halves of them, too.
    for whole in [0.0, 1.0, -1.0, 2.0, 1e6 + 1.0, -1e12, 2_251_799_813_685_245.0, -2_251_799_813_685_245.0] {
        let sign = if whole % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let [sin, cos] = sincos_half_turns([whole, whole + 0.25, whole - 0.25, whole, whole, whole, whole, whole]);
        assert_eq!((sin[0], cos[0]), (0.0, sign), "{whole}");
        for (lane, expected) in [(1, sign), (2, -sign)] {
            let off = (sin[lane] - expected * libm::sqrt(0.5)).abs();
            assert!(off < 1e-15, "{whole} half turns and {lane} are off by {off}");
        }
    }
}

#[test]
fn exponentials_are_exact_to_rounding_and_infinite_beyond() {
    for step in 0..100_000 {
        let x: [f64; 8] = std::array::from_fn(|lane| (f64::from(step) + lane as f64 / 8.0) / 73.0 - 680.0);
        for (x, found) in x.into_iter().zip(exp(x)) {
            if x < 693.0 {
                let off = (found / libm::exp(x) - 1.0).abs();
                assert!(off < 1e-15 + x.abs() * 3e-16, "e^{x} is off by {off}");
            } else {
                assert_eq!(found, f64::INFINITY, "e^{x}");
            }
        }
    }
    let (least, infinite) = (libm::exp2(-1000.0), f64::INFINITY);
    assert_eq!(
        exp([0.0, -0.0, -694.0, -1e300, -infinite, 693.0, 1e300, infinite]),
        [1.0, 1.0, least, least, least, infinite, infinite, infinite]
    );
}

#[test]
fn powers_are_exact_to_rounding() {
    for step in 0..100_000 {
        let halvings: [f64; 8] = std::array::from_fn(|lane| (f64::from(step) + lane as f64 / 8.0) / 100.0);
        for (halvings, power) in halvings.into_iter().zip(halved(halvings)) {
            let off = (power / libm::exp2(-halvings) - 1.0).abs();
            assert!(off < 1e-15, "{halvings} halvings are off by {off}");
        }
    }
    let least = libm::exp2(-1000.0);
    assert_eq!(
        halved([0.0, 1.0, 52.0, 1000.0, 1000.5, 1e4, 1e300, f64::INFINITY]),
        [1.0, 0.5, libm::exp2(-52.0), least, least, least, least, least]
    );
}

//! Tests of the functions of precise sums.

use std::f64::consts::TAU;
use trochoid_sea::inside::{exp_neg, sincos};

#[test]
fn functions_are_exact_to_rounding() {
    for step in -5000..=5000 {
        let turns = f64::from(step) / 1e4;
        let (sin, cos) = sincos(turns);
        assert!((sin - libm::sin(TAU * turns)).abs() < 4e-16 && (cos - libm::cos(TAU * turns)).abs() < 4e-16);
    }
    for step in 0..7000 {
        let x = f64::from(step) / 10.0 + 0.013;
        assert!((exp_neg(x) / libm::exp(-x) - 1.0).abs() < 2e-15, "{x}");
    }
    assert_eq!(exp_neg(0.0), 1.0);
}

//! Tests of powers of lobes.

use trochoid_scene::inside::{exp, log1p};

#[test]
fn logarithms_have_the_bits_of_libm() {
    let ends = [0.0_f32, -0.0, -1.0, -0.292_893_2, -0.292_893_25, -5.960_464_5e-8, -5.96e-8, -1e-42, -0.999_999_94];
    for x in ends.into_iter().chain((0x8000_0000_u32..=0xbf80_0000).step_by(1009).map(f32::from_bits)) {
        let (found, truth) = (log1p(x), libm::log1pf(x));
        assert!(found.to_bits() == truth.to_bits(), "log1p({x}): {found} and {truth}");
    }
}

#[test]
fn exponentials_have_the_bits_of_libm() {
    let ends = [0.0_f32, -87.336_54, -87.336_56, -103.972_07, -103.972_08, f32::NEG_INFINITY, -0.346_573_6, -1.039_72];
    for y in ends.into_iter().chain((0x8000_0000_u32..=0xff80_0000).step_by(1009).map(f32::from_bits)) {
        let (found, truth) = (exp(y), libm::expf(y));
        assert!(found.to_bits() == truth.to_bits(), "exp({y}): {found} and {truth}");
    }
    // Where results are subnormal.
    for y in (0_u32..200_000).map(|step| -87.0 - step as f32 * 1e-4) {
        assert_eq!(exp(y).to_bits(), libm::expf(y).to_bits(), "exp({y})");
    }
    assert!(exp(f32::NAN).is_nan());
}

//! `sincos` of libm, eight numbers at a time, with the same bits.
//!
//! These are the operations of libm in their order, where it takes its common paths. The few numbers for which it may
//! take another one are given to libm itself. The formula is that of FreeBSD's msun:
//!
//! > Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at SunPro, a Sun Microsystems, Inc.
//! > business. Permission to use, copy, modify, and distribute this software is freely granted, provided that this
//! > notice is preserved.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use crate::kernel64::ROUNDER;

/// π/2 in two parts; the first has so few bits that its products with small whole numbers are exact.
const HALF_PI_HIGH: f64 = f64::from_bits(0x3ff9_21fb_5440_0000);
const HALF_PI_LOW: f64 = f64::from_bits(0x3dd0_b461_1a62_6331);
/// Below π/4 by more than the thresholds of libm are off, for angles up to [`LARGE`].
const NEARLY_AN_EIGHTH: f64 = FRAC_PI_4 - 1e-5;
/// Share of an angle below which its rest may need a third part of π/2.
const CANCELED: f64 = 1.0 / 32_768.0;
/// Size from which angles are left to libm.
const LARGE: f64 = 1e5;

/// Coefficients of sine and cosine on −π/4…π/4.
const SINE: [f64; 6] = [
    f64::from_bits(0xbfc5_5555_5555_5549),
    f64::from_bits(0x3f81_1111_1110_f8a6),
    f64::from_bits(0xbf2a_01a0_19c1_61d5),
    f64::from_bits(0x3ec7_1de3_57b1_fe7d),
    f64::from_bits(0xbe5a_e5e6_8a2b_9ceb),
    f64::from_bits(0x3de5_d93a_5acf_d57c),
];
const COSINE: [f64; 6] = [
    f64::from_bits(0x3fa5_5555_5555_554c),
    f64::from_bits(0xbf56_c16c_16c1_5177),
    f64::from_bits(0x3efa_01a0_19cb_1590),
    f64::from_bits(0xbe92_7e4f_809c_52ad),
    f64::from_bits(0x3e21_ee9e_bdb4_b1c4),
    f64::from_bits(0xbda8_fae9_be88_38d4),
];

/// Replaces some lanes by what a function of their index returns.
#[inline(always)]
fn mend<S: Simd>(found: &mut f64x8<S>, rare: mask64x8<S>, of: impl Fn(usize) -> f64) {
    let mut left = rare.to_bitmask();
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        found[lane] = of(lane);
        left &= left - 1;
    }
}

/// Returns sine and cosine of angles in radians, with the bits of `libm::sincos` up to the sign of a zero.
#[inline(always)]
pub(crate) fn sincos<S: Simd>(simd: S, angle: f64x8<S>) -> [f64x8<S>; 2] {
    let zero = f64x8::splat(simd, 0.0);
    let quarters = (angle * FRAC_2_PI + ROUNDER) - ROUNDER;
    let high = angle - quarters * HALF_PI_HIGH;
    let low = quarters * HALF_PI_LOW;
    let x = high - low;
    let rest = (high - x) - low;

    let z = x * x;
    let w = z * z;
    let [s1, s2, s3, s4, s5, s6] = SINE;
    let tail = z * (z * s4 + s3) + s2 + z * w * (z * s6 + s5);
    let cube = z * x;
    let is_small = quarters.simd_eq(zero);
    let alone = x + cube * (z * tail + s1);
    let reduced = x - ((z * (rest * 0.5 - cube * tail) - rest) - cube * s1);
    let sin = is_small.select(alone, reduced);

    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let tail = z * (z * (z * c3 + c2) + c1) + w * w * (z * (z * c6 + c5) + c4);
    let half = z * 0.5;
    let near = half * -1.0 + 1.0;
    let cos = near + (((near * -1.0 + 1.0) - half) + (z * tail - x * rest));

    // Quarters modulo 4, from −2 to 2.
    let turn = quarters - ((quarters * 0.25 + ROUNDER) - ROUNDER) * 4.0;
    let is_odd = (turn * turn).simd_eq(f64x8::splat(simd, 1.0));
    let sign = turn.abs() * -1.0 + 1.0;
    let mut found = [is_odd.select(turn * cos, sign * sin), is_odd.select(turn * -1.0 * sin, sign * cos)];

    let size = angle.abs();
    let canceled = x.abs().simd_lt(size * CANCELED) & quarters.simd_ne(zero);
    let rare =
        canceled | x.abs().simd_gt(f64x8::splat(simd, NEARLY_AN_EIGHTH)) | size.simd_gt(f64x8::splat(simd, LARGE));
    mend(&mut found[0], rare, |lane| libm::sincos(angle[lane]).0);
    mend(&mut found[1], rare, |lane| libm::sincos(angle[lane]).1);
    found
}

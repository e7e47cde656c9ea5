//! Tests of the scalar operations: results stay in range, and close to the f64 reference.

use proptest::prelude::*;
use trochoid_weights::{arithmetic as fast, reference};

const ULP: f64 = f32::EPSILON as f64;

/// Finite values ≥ 0 of every magnitude, with frequent difficult ones.
fn color() -> impl Strategy<Value = f32> {
    prop_oneof![
        0.0_f32..=1.0,
        1.0_f32..=2.0,
        (0_u32..0x7f80_0000).prop_map(f32::from_bits),
        (0_u32..0x0080_0000).prop_map(f32::from_bits),
        prop::sample::select(vec![
            0.0,
            -0.0,
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            0.5,
            1.0,
            1.0_f32.next_down(),
            1.0_f32.next_up(),
            65504.0,
            f32::MAX,
            f32::MAX.next_down(),
        ]),
    ]
}

/// Pairs that are often equal or neighbors.
fn pair() -> impl Strategy<Value = (f32, f32)> {
    let near =
        || (color(), 0_u32..4).prop_map(|(a, k)| (a, f32::from_bits((a.abs().to_bits() + k).min(f32::MAX.to_bits()))));
    prop_oneof![(color(), color()), near(), near().prop_map(|(a, b)| (b, a))]
}

fn mask() -> impl Strategy<Value = f32> {
    prop_oneof![
        0.0_f32..=1.0,
        (0_u32..=0x3f80_0000).prop_map(f32::from_bits),
        prop::sample::select(vec![
            0.0,
            f32::from_bits(1),
            0.5_f32.next_down(),
            0.5,
            0.5_f32.next_up(),
            1.0 / 3.0,
            1.0_f32.next_down(),
            1.0,
        ]),
    ]
}

/// Any value of a field, including NaN and infinities.
fn field() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>(), -10.0_f32..10.0, color(), Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)]
}

fn finite_field() -> impl Strategy<Value = f32> {
    prop_oneof![-10.0_f32..10.0, color(), color().prop_map(|v| -v)]
}

/// Two bounds in order, often close or equal.
fn bounds() -> impl Strategy<Value = (f32, f32)> {
    prop_oneof![(finite_field(), finite_field()), pair()].prop_map(|(a, b)| (a.min(b), a.max(b)))
}

fn ulp_of(v: f32) -> f64 {
    (f64::from(v) - f64::from(v.abs().next_down().max(0.0))).abs().max(1.5e-45)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn mix_stays_between_its_operands((a, b) in pair(), t in mask()) {
        let mixed = fast::mix(a, b, t);
        prop_assert!(mixed >= a.min(b) && mixed <= a.max(b), "mix({a:e}, {b:e}, {t:e}) = {mixed:e}");
        prop_assert_eq!(fast::mix(a, b, 0.0), a);
        prop_assert_eq!(fast::mix(a, b, 1.0), b);
        prop_assert_eq!(fast::mix(a, a, t), a);
        let exact = reference::mix(a.into(), b.into(), t.into());
        prop_assert!((f64::from(mixed) - exact).abs() <= 1.5 * ulp_of(a.max(b)));
    }

    #[test]
    fn clamp_is_a_mask_for_any_numbers(x in field(), min in field(), max in field()) {
        let t = fast::clamp(x, min, max);
        prop_assert!((0.0..=1.0).contains(&t), "clamp({x:e}, {min:e}, {max:e}) = {t:e}");
        prop_assert!(!t.is_sign_negative());
    }

    #[test]
    fn clamp_follows_the_reference(x in field(), (min, max) in bounds()) {
        let t = f64::from(fast::clamp(x, min, max));
        let exact = reference::clamp(x.into(), min.into(), max.into());
        prop_assert!((t - exact).abs() <= 2.0 * ULP * exact + 1e-37, "clamp({x:e}, {min:e}, {max:e}): {t:e}, {exact:e}");
        if x >= max { prop_assert_eq!(t, 1.0); }
        if x < min || x.is_nan() { prop_assert_eq!(t, 0.0); }
    }

    #[test]
    fn clamp_is_monotone((x, y) in pair(), (min, max) in bounds()) {
        prop_assert!(fast::clamp(x.min(y), min, max) <= fast::clamp(x.max(y), min, max));
    }

    #[test]
    fn mask_operations_stay_masks(a in mask(), b in mask(), p in 1.0_f32..40.0) {
        for t in [fast::smooth(a), fast::power(a, p), fast::complement(a), fast::product(a, b), fast::screen(a, b)] {
            prop_assert!((0.0..=1.0).contains(&t));
        }
        prop_assert!(fast::power(a, p) <= a);
        prop_assert!(fast::product(a, b) <= a.min(b));
        prop_assert!(fast::screen(a, b) >= a.max(b));
        prop_assert_eq!(fast::screen(a, b).to_bits(), fast::screen(b, a).to_bits());
        prop_assert_eq!(fast::screen(a, 0.0), a);
        prop_assert_eq!(fast::screen(a, 1.0), 1.0);
        prop_assert_eq!(fast::product(a, 1.0), a);
        prop_assert_eq!(fast::power(a, 1.0), a);
    }

    #[test]
    fn mask_operations_follow_the_reference(a in mask(), b in mask(), p in 1.0_f32..40.0, n in 1_u32..24) {
        let (x, y, n) = (f64::from(a), f64::from(b), n as f32);
        let close = |fast: f32, exact: f64| (f64::from(fast) - exact).abs() <= ULP * exact + 1.5e-45;
        prop_assert!(close(fast::smooth(a), reference::smooth(x)));
        prop_assert!(close(fast::power(a, p), reference::power(x, p.into())));
        prop_assert!(close(fast::power(a, n), reference::power(x, n.into())));
        prop_assert!(close(fast::product(a, b), reference::product(x, y)));
        prop_assert!((f64::from(fast::complement(a)) - reference::complement(x)).abs() <= ULP / 4.0);
        prop_assert!((f64::from(fast::screen(a, b)) - reference::screen(x, y)).abs() <= 1.5 * ULP);
    }

    #[test]
    fn smooth_is_monotone(t in mask()) {
        if t > 0.0 { prop_assert!(fast::smooth(t.next_down()) <= fast::smooth(t)); }
    }

    #[test]
    fn rows_of_powers_are_powers(row in prop::collection::vec(mask(), 1..80), p in 1.0_f32..40.0, n in 1_u32..24) {
        for p in [p, n as f32] {
            let mut powered = row.clone();
            fast::power_row(&mut powered, p);
            for (t, power) in row.iter().zip(&powered) {
                prop_assert_eq!(fast::power(*t, p).to_bits(), power.to_bits());
            }
        }
    }

    #[test]
    fn rows_of_any_numbers_have_the_bits_of_single_powers(
        row in prop::collection::vec(any::<u32>().prop_map(f32::from_bits), 1..40),
        some in prop::collection::vec(mask(), 1..40),
        p in prop_oneof![any::<u32>().prop_map(f32::from_bits), 0.0_f32..4.0, 15.0_f32..300.0],
    ) {
        let row = [row, some].concat();
        let mut powered = row.clone();
        fast::power_row(&mut powered, p);
        for (t, power) in row.iter().zip(&powered) {
            prop_assert_eq!(fast::power(*t, p).to_bits(), power.to_bits(), "{:e} to the power {:e}", t, p);
        }
    }
}

#[test]
fn smooth_is_exact_where_it_must_be_and_monotone_at_every_step_near_the_ends() {
    assert_eq!([0.0, 0.5, 1.0].map(fast::smooth), [0.0, 0.5, 1.0]);
    let mut last = 0.0;
    for bits in 0x3f00_0000..=0x3f80_0000 {
        let value = fast::smooth(f32::from_bits(bits));
        assert!(value >= last);
        last = value;
    }
}

#[test]
fn clamp_in_printed_order() {
    assert_eq!(fast::clamp(2.0, 2.0, 2.0), 1.0, "a step at max");
    assert_eq!(fast::clamp(2.0_f32.next_down(), 2.0, 2.0), 0.0);
    assert_eq!(fast::clamp(f32::INFINITY, 0.0, 400.0), 1.0, "the sky");
    assert_eq!(fast::clamp(f32::NEG_INFINITY, 0.0, 400.0), 0.0);
    assert_eq!(fast::clamp(f32::NAN, 0.0, 400.0), 0.0);
    assert_eq!(fast::clamp(0.0, -f32::MAX, f32::MAX), 0.5, "the width does not overflow");
    assert_eq!(fast::clamp(f32::from_bits(1), 0.0, f32::from_bits(2)), 0.5, "nor underflow");
    assert_eq!(fast::clamp(f32::MAX / 4.0, 0.0, f32::MAX), 0.25);
    assert_eq!([fast::step(1.0, 1.0), fast::step(f32::NAN, 1.0), fast::step(0.9, 1.0)], [1.0, 0.0, 0.0]);
}

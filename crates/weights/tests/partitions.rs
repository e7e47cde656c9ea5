//! Weights sum to exactly 1, blends stay in the box, and rows agree with pixels.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use trochoid_weights::{Mask, Weights, arithmetic as fast, reference};

const UNIT: f64 = 1.0 / 16_777_216.0;

fn hostile() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => 0.0_f32..=1.0,
        1 => 0.99_f32..=1.0,
        2 => (0_u32..0x7f80_0000).prop_map(f32::from_bits),
        1 => (0_u32..0x0080_0000).prop_map(f32::from_bits),
        2 => prop::sample::select(vec![0.0, -0.0, 1.0, f32::from_bits(1), f32::MIN_POSITIVE, 65504.0, f32::MAX]),
    ]
}

fn mask() -> impl Strategy<Value = f32> {
    prop_oneof![0.0_f32..=1.0, Just(0.0), Just(1.0), Just(0.5), (0_u32..=0x3f80_0000).prop_map(f32::from_bits)]
}

/// Weights in f64 that sum to 1, some of them 0.
fn raw_weights(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
    let share = prop_oneof![3 => 0.0_f64..1.0, 1 => Just(0.0), 1 => 0.0_f64..1e-7, 1 => Just(1.0)];
    prop::collection::vec(share, count).prop_map(|mut shares| {
        shares[0] += 1e-3;
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share / sum).collect()
    })
}

/// The sum in units of 2⁻²⁴, after a check that each weight is a whole number of them.
fn units(weights: &[f32]) -> u64 {
    weights
        .iter()
        .map(|&w| {
            let units = f64::from(w) / UNIT;
            assert!(units >= 0.0 && units.fract() == 0.0, "{w:e} is no multiple of the unit");
            units as u64
        })
        .sum()
}

fn assert_partition(weights: &[f32]) {
    assert_eq!(units(weights), 1 << 24);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn rounded_weights_sum_to_exactly_one(raw in raw_weights(1..40)) {
        let weights = Weights::new(&raw).unwrap();
        assert_partition(weights.as_slice());
        let largest = raw.iter().copied().fold(0.0, f64::max);
        for (&w, &raw) in weights.as_slice().iter().zip(&raw) {
            let moved = (f64::from(w) - raw).abs();
            prop_assert!(moved <= 0.5 * UNIT || raw == largest && moved <= raw_bound(weights.as_slice().len()));
            prop_assert!(raw != 0.0 || w == 0.0);
        }
        let mut narrow: Vec<f32> = raw.iter().map(|&w| w as f32).collect();
        fast::round_partition(&mut narrow);
        assert_partition(&narrow);
    }

    #[test]
    fn blends_stay_in_the_box((raw, colors) in raw_weights(1..40).prop_flat_map(|raw| {
        let count = raw.len();
        (Just(raw), prop::collection::vec([hostile(), hostile(), hostile()], count))
    })) {
        let weights = Weights::new(&raw).unwrap();
        let blend = weights.blend(&colors);
        let used = || colors.iter().zip(weights.as_slice()).filter(|&(_, &w)| w > 0.0).map(|(c, _)| c);
        for channel in 0..3 {
            let min = used().map(|c| c[channel]).fold(f32::INFINITY, f32::min);
            let max = used().map(|c| c[channel]).fold(0.0, f32::max);
            prop_assert!(blend[channel] >= min && blend[channel] <= max);
            let exact = reference::blend(
                &colors.iter().map(|c| f64::from(c[channel])).collect::<Vec<_>>(), &raw);
            let diameter = colors.iter().map(|c| f64::from(c[channel])).fold(0.0, f64::max);
            let bound = 0.5 * diameter * raw.len() as f64 * UNIT + f64::from(max) * UNIT;
            prop_assert!((f64::from(blend[channel]) - exact).abs() <= bound + 1.5e-45);
        }
        let same = vec![colors[0]; colors.len()];
        prop_assert_eq!(weights.blend(&same), colors[0]);
        // A control of weight 0 may hold anything.
        let poisoned: Vec<_> = colors.iter().zip(weights.as_slice())
            .map(|(&c, &w)| if w == 0.0 { [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] } else { c }).collect();
        prop_assert_eq!(weights.blend(&poisoned), blend);
    }

    #[test]
    fn near_constant_blends_stay_in_the_box(raw in raw_weights(2..24), base in hostile(), steps in prop::collection::vec(0_u32..3, 24)) {
        let colors: Vec<f32> = steps.iter()
            .map(|k| f32::from_bits((base.abs().to_bits() + k).min(f32::MAX.to_bits()))).collect();
        let weights = Weights::new(&raw).unwrap();
        let blend = fast::blend(&colors, weights.as_slice());
        let used = || colors.iter().zip(weights.as_slice()).filter(|&(_, &w)| w > 0.0).map(|(c, _)| *c);
        prop_assert!(blend >= used().fold(f32::INFINITY, f32::min) && blend <= used().fold(0.0, f32::max));
    }

    #[test]
    fn normalize_is_a_partition_near_the_reference(
        values in prop::collection::vec(prop_oneof![hostile(), hostile().prop_map(|v| -v)], 1..40),
        floor in prop_oneof![Just(1e-3_f32), Just(f32::from_bits(1)), Just(f32::MAX), 0.01_f32..10.0],
    ) {
        let weights = Weights::normalize(&values, floor).unwrap();
        assert_partition(weights.as_slice());
        let wide: Vec<f64> = values.iter().map(|&v| v.into()).collect();
        let bound = UNIT * (values.len() + 1) as f64;
        for (&w, exact) in weights.as_slice().iter().zip(reference::normalize(&wide, floor.into())) {
            prop_assert!((f64::from(w) - exact).abs() <= bound);
        }
        for (&w, &v) in weights.as_slice().iter().zip(&values) {
            prop_assert!(v > 0.0 || w == 0.0);
        }
    }

    #[test]
    fn stacks_and_bands_are_partitions_near_the_reference(
        masks in prop::collection::vec(mask(), 0..20),
        x in -2.0_f32..3.0,
        mut thresholds in prop::collection::vec(-1.0_f32..2.0, 0..12),
        width in prop_oneof![Just(0.0_f32), 0.01_f32..1.0],
    ) {
        let stack = Weights::stack(&masks.iter().map(|&t| Mask::new(t).unwrap()).collect::<Vec<_>>()).unwrap();
        assert_partition(stack.as_slice());
        let wide: Vec<f64> = masks.iter().map(|&t| t.into()).collect();
        for (&w, exact) in stack.as_slice().iter().zip(reference::stack(&wide)) {
            prop_assert!((f64::from(w) - exact).abs() <= UNIT * (masks.len() + 1) as f64);
        }
        thresholds.sort_by(f32::total_cmp);
        let bands = Weights::bands(x, &thresholds, width).unwrap();
        assert_partition(bands.as_slice());
        let wide: Vec<f64> = thresholds.iter().map(|&t| t.into()).collect();
        let slope = if width > 0.0 { 1.0 / f64::from(width) } else { 0.0 };
        for (&w, exact) in bands.as_slice().iter().zip(reference::bands(x.into(), &wide, width.into())) {
            prop_assert!((f64::from(w) - exact).abs() <= 16.0 * UNIT * (slope + 1.0) * bands.as_slice().len() as f64);
        }
    }

    #[test]
    fn permuting_values_permutes_weights(values in prop::collection::vec(0_u32..1000, 2..20), turn in 1_usize..19) {
        // Whole numbers without a tie of the largest: sums are exact, and the residual has one possible owner.
        let mut values: Vec<f32> = values.iter().map(|&v| v as f32).collect();
        values[0] = 5000.0;
        let weights = Weights::normalize(&values, 0.5).unwrap().as_slice().to_vec();
        let turn = turn % values.len();
        values.rotate_left(turn);
        let rotated = Weights::normalize(&values, 0.5).unwrap();
        let count = values.len();
        let mut expected = weights[..count].to_vec();
        expected.rotate_left(turn);
        prop_assert_eq!(&rotated.as_slice()[..count], &expected[..]);
        prop_assert_eq!(rotated.as_slice()[count], weights[count]);
    }

    #[test]
    fn rows_agree_with_pixels(rows in prop::collection::vec(prop::collection::vec(mask(), 150), 1..6), floor in 0.01_f32..2.0) {
        let rows: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
        let check = |run: &dyn Fn(&mut [&mut [f32]]), pixel: &dyn Fn(&[f32], &mut [f32])| {
            let mut planes = vec![vec![0.0_f32; 150]; rows.len() + 1];
            run(&mut planes.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
            for x in 0..150 {
                let column: Vec<f32> = rows.iter().map(|row| row[x]).collect();
                let mut expected = vec![0.0; rows.len() + 1];
                pixel(&column, &mut expected);
                let found: Vec<f32> = planes.iter().map(|plane| plane[x]).collect();
                assert_eq!(found, expected);
                assert_partition(&found);
            }
        };
        check(&|out| fast::normalize_rows(&rows, floor, out), &|values, out| fast::normalize(values, floor, out));
        check(&|out| fast::stack_rows(&rows, out), &|masks, out| fast::stack(masks, out));
        // Raw f32 weights: each row's share of a whole, the rest in the last plane.
        let share = |t: f32| t / rows.len() as f32;
        check(
            &|out| {
                for x in 0..150 {
                    let mut rest = 1.0;
                    for (plane, row) in out.iter_mut().zip(&rows) {
                        plane[x] = share(row[x]);
                        rest -= plane[x];
                    }
                    out[rows.len()][x] = rest.max(0.0);
                }
                fast::round_partition_rows(out);
            },
            &|column, out| {
                let mut rest = 1.0;
                for (weight, &t) in out.iter_mut().zip(column) {
                    *weight = share(t);
                    rest -= *weight;
                }
                *out.last_mut().unwrap() = rest.max(0.0);
                fast::round_partition(out);
            },
        );
    }
}

/// Half a unit from each other weight, and the largest's own.
fn raw_bound(count: usize) -> f64 {
    0.5 * UNIT * (count + 1) as f64
}

#[test]
fn the_largest_partition_still_sums_to_one() {
    let equal = vec![1.0 / 4096.0; 4096];
    assert_partition(Weights::new(&equal).unwrap().as_slice());
    // Every weight but the first is rounded the same way, by almost half a unit.
    for offset in [0.499, -0.499] {
        let mut skewed = vec![(4095.0 + offset) * UNIT; 4096];
        skewed[0] = 1.0 - 4095.0 * skewed[1];
        assert_partition(Weights::new(&skewed).unwrap().as_slice());
    }
}

#[test]
fn the_residual_goes_to_the_first_of_the_largest() {
    let weights = Weights::new(&[1.0 / 3.0; 3]).unwrap();
    let third = 5_592_405.0 * UNIT as f32;
    assert_eq!(weights.as_slice(), [third + UNIT as f32, third, third]);
}

#[test]
fn what_is_no_partition_is_refused() {
    assert!(Weights::new(&[]).is_err());
    assert!(Weights::new(&[0.5, 0.6]).is_err());
    assert!(Weights::new(&[1.5, -0.5]).is_err());
    assert!(Weights::new(&[f64::NAN, 1.0]).is_err());
    assert!(Weights::new(&vec![1.0 / 4097.0; 4097]).is_err());
    assert!(Weights::new(&[0.5, 0.5000009]).is_ok());
    assert!(Weights::normalize(&[f32::INFINITY], 1.0).is_err());
    assert!(Weights::normalize(&[f32::NAN], 1.0).is_err());
    assert!(Weights::normalize(&[1.0], 0.0).is_err());
    assert!(Weights::bands(0.0, &[1.0, 0.0], 0.1).is_err());
    assert!(Weights::bands(0.0, &[0.0], -0.1).is_err());
    for t in [-0.1, 1.0_f32.next_up(), f32::NAN, f32::INFINITY] {
        assert!(Mask::new(t).is_err());
    }
    assert!(Mask::ONE.power(0.5).is_err());
}

#[test]
fn edge_cases_of_normalize_and_bands() {
    assert_eq!(Weights::normalize(&[0.0, -1.0], 0.1).unwrap().as_slice(), [0.0, 0.0, 1.0]);
    assert_eq!(Weights::normalize(&[f32::MAX, f32::MAX], 0.1).unwrap().as_slice(), [0.5, 0.5, 0.0]);
    let tiny = f32::from_bits(1);
    assert_eq!(Weights::normalize(&[tiny, tiny], tiny).unwrap().as_slice(), [0.5, 0.5, 0.0]);
    assert_eq!(Weights::bands(1.0, &[0.0, 1.0, 2.0], 0.0).unwrap().as_slice(), [0.0, 0.0, 1.0, 0.0]);
    assert_eq!(Weights::bands(f32::NAN, &[0.0, 1.0], 0.5).unwrap().as_slice(), [1.0, 0.0, 0.0]);
    assert_eq!(Weights::bands(1.0, &[0.0, 1.0], 1.0).unwrap().as_slice(), [0.0, 0.5, 0.5]);
    let mask = Mask::new(0.25).unwrap();
    assert_eq!(Weights::from_mask(mask).as_slice(), [0.75, 0.25]);
    assert_eq!(mask.complement().value(), 0.75);
    assert_eq!(mask.and(mask).value(), 0.0625);
    assert_eq!(mask.or(mask).value(), 0.4375);
}

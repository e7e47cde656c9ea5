//! Tests of partitions: weights sum to exactly 1, blends stay in the bounding box, and rows agree with pixels.

use proptest::prelude::*;
use trochoid_weights::{arithmetic as fast, reference};

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

/// Returns the sum in units of 2⁻²⁴, after a check that each weight is a whole number of units.
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

fn rounded(raw: &[f64]) -> Vec<f32> {
    let mut weights: Vec<f32> = raw.iter().map(|&w| w as f32).collect();
    fast::round_partition(&mut weights);
    weights
}

fn normalized(values: &[f32], floor: f32) -> Vec<f32> {
    let mut weights = vec![0.0; values.len() + 1];
    fast::normalize(values, floor, &mut weights);
    weights
}

fn stacked(masks: &[f32]) -> Vec<f32> {
    let mut weights = vec![0.0; masks.len() + 1];
    fast::stack(masks, &mut weights);
    weights
}

/// Blends the three channels of colors with the same weights.
fn blended(weights: &[f32], colors: &[[f32; 3]]) -> [f32; 3] {
    [0, 1, 2].map(|channel| fast::blend(&colors.iter().map(|color| color[channel]).collect::<Vec<_>>(), weights))
}

fn assert_partition(weights: &[f32]) {
    assert_eq!(units(weights), 1 << 24);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn rounded_weights_sum_to_exactly_one(raw in raw_weights(1..40)) {
        let weights = rounded(&raw);
        assert_partition(&weights);
        let narrow: Vec<f32> = raw.iter().map(|&w| w as f32).collect();
        let largest = narrow.iter().copied().fold(0.0, f32::max);
        for (&w, &narrow) in weights.iter().zip(&narrow) {
            let moved = (f64::from(w) - f64::from(narrow)).abs();
            prop_assert!(moved <= 0.5 * UNIT || narrow == largest && moved <= raw_bound(weights.len()));
            prop_assert!(narrow != 0.0 || w == 0.0);
        }
    }

    #[test]
    fn blends_stay_in_the_box((raw, colors) in raw_weights(1..40).prop_flat_map(|raw| {
        let count = raw.len();
        (Just(raw), prop::collection::vec([hostile(), hostile(), hostile()], count))
    })) {
        let weights = rounded(&raw);
        let blend = blended(&weights, &colors);
        let used = || colors.iter().zip(&weights).filter(|&(_, &w)| w > 0.0).map(|(c, _)| c);
        for channel in 0..3 {
            let min = used().map(|c| c[channel]).fold(f32::INFINITY, f32::min);
            let max = used().map(|c| c[channel]).fold(0.0, f32::max);
            prop_assert!(blend[channel] >= min && blend[channel] <= max);
            let exact = reference::blend(
                &colors.iter().map(|c| f64::from(c[channel])).collect::<Vec<_>>(), &raw);
            let diameter = colors.iter().map(|c| f64::from(c[channel])).fold(0.0, f64::max);
            // Half a unit of each weight, and a unit of all for narrowing them.
            let bound = (0.5 * raw.len() as f64 + 1.0) * diameter * UNIT + f64::from(max) * UNIT;
            prop_assert!((f64::from(blend[channel]) - exact).abs() <= bound + 1.5e-45);
        }
        let same = vec![colors[0]; colors.len()];
        prop_assert_eq!(blended(&weights, &same), colors[0]);
        // A control of weight 0 may have any value.
        let poisoned: Vec<_> = colors.iter().zip(&weights)
            .map(|(&c, &w)| if w == 0.0 { [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] } else { c }).collect();
        prop_assert_eq!(blended(&weights, &poisoned), blend);
    }

    #[test]
    fn near_constant_blends_stay_in_the_box(raw in raw_weights(2..24), base in hostile(), steps in prop::collection::vec(0_u32..3, 24)) {
        let colors: Vec<f32> = steps.iter()
            .map(|k| f32::from_bits((base.abs().to_bits() + k).min(f32::MAX.to_bits()))).collect();
        let weights = rounded(&raw);
        let blend = fast::blend(&colors[..weights.len()], &weights);
        let used = || colors.iter().zip(&weights).filter(|&(_, &w)| w > 0.0).map(|(c, _)| *c);
        prop_assert!(blend >= used().fold(f32::INFINITY, f32::min) && blend <= used().fold(0.0, f32::max));
    }

    #[test]
    fn normalize_is_a_partition_near_the_reference(
        values in prop::collection::vec(prop_oneof![hostile(), hostile().prop_map(|v| -v)], 1..40),
        floor in prop_oneof![Just(1e-3_f32), Just(f32::from_bits(1)), Just(f32::MAX), 0.01_f32..10.0],
    ) {
        let weights = normalized(&values, floor);
        assert_partition(&weights);
        let wide: Vec<f64> = values.iter().map(|&v| v.into()).collect();
        let bound = UNIT * (values.len() + 1) as f64;
        for (&w, exact) in weights.iter().zip(reference::normalize(&wide, floor.into())) {
            prop_assert!((f64::from(w) - exact).abs() <= bound);
        }
        for (&w, &v) in weights.iter().zip(&values) {
            prop_assert!(v > 0.0 || w == 0.0);
        }
    }

    #[test]
    fn stacks_are_partitions_near_the_reference(masks in prop::collection::vec(mask(), 0..20)) {
        let stack = stacked(&masks);
        assert_partition(&stack);
        let wide: Vec<f64> = masks.iter().map(|&t| t.into()).collect();
        for (&w, exact) in stack.iter().zip(reference::stack(&wide)) {
            prop_assert!((f64::from(w) - exact).abs() <= UNIT * (masks.len() + 1) as f64);
        }
    }

    #[test]
    fn permuting_values_permutes_weights(values in prop::collection::vec(0_u32..1000, 2..20), turn in 1_usize..19) {
        // Whole numbers without a tie of the largest: sums are exact, and the residual has one possible owner.
        let mut values: Vec<f32> = values.iter().map(|&v| v as f32).collect();
        values[0] = 5000.0;
        let weights = normalized(&values, 0.5);
        let turn = turn % values.len();
        values.rotate_left(turn);
        let rotated = normalized(&values, 0.5);
        let count = values.len();
        let mut expected = weights[..count].to_vec();
        expected.rotate_left(turn);
        prop_assert_eq!(&rotated[..count], &expected[..]);
        prop_assert_eq!(rotated[count], weights[count]);
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

/// Error bound of the largest weight: half a unit from each other weight, one from the weight itself, and one from the
/// error in the sum of the f32 weights.
fn raw_bound(count: usize) -> f64 {
    0.5 * UNIT * (count + 3) as f64
}

#[test]
fn the_largest_partition_still_sums_to_one() {
    let equal = vec![1.0 / 4096.0; 4096];
    assert_partition(&rounded(&equal));
    // Every weight but the first is rounded the same way, by almost half a unit.
    for offset in [0.499, -0.499] {
        let mut skewed = vec![(4095.0 + offset) * UNIT; 4096];
        skewed[0] = 1.0 - 4095.0 * skewed[1];
        assert_partition(&rounded(&skewed));
    }
}

#[test]
fn the_residual_goes_to_the_first_of_the_largest() {
    // As an f32, a third lies in the middle between 5,592,405 and 5,592,406 units.
    let third = 5_592_406.0 * UNIT as f32;
    assert_eq!(rounded(&[1.0 / 3.0; 3]), [third - 2.0 * UNIT as f32, third, third]);
}

#[test]
fn edge_cases_of_normalize() {
    assert_eq!(normalized(&[0.0, -1.0], 0.1), [0.0, 0.0, 1.0]);
    assert_eq!(normalized(&[f32::MAX, f32::MAX], 0.1), [0.5, 0.5, 0.0]);
    let tiny = f32::from_bits(1);
    assert_eq!(normalized(&[tiny, tiny], tiny), [0.5, 0.5, 0.0]);
    assert_eq!(normalized(&[f32::NAN, 1.0], 0.5), [0.0, 1.0, 0.0], "refused where it is read, harmless here");
    assert_eq!(normalized(&[f32::INFINITY, 1.0], 0.5), [1.0, 0.0, 0.0]);
    assert_eq!(normalized(&[1.0], 0.0), [1.0, 0.0]);
}

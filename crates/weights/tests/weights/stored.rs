//! Stored weights: exact sums, and as little moved as possible.

use proptest::prelude::*;
use trochoid_weights::{Apportioner, BLOCK, Storing};

#[test]
fn sums_are_exact_in_any_order_and_errors_within_their_bound() {
    let mut state = 3_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for storing in [Storing::Half, Storing::Float] {
        for count in [1_usize, 2, 3, 7, 24, 300] {
            for _ in 0..300 {
                let parts: Vec<f64> = (0..count).map(|_| (draw() - 0.2).max(0.0).powi(4) + 1e-9).collect();
                let sum: f64 = parts.iter().sum();
                let weights: Vec<f64> = parts.iter().map(|part| part / sum).collect();
                let stored = storing.round(&weights);
                assert!(stored.iter().all(|weight| *weight >= 0.0));
                assert_eq!((stored.iter().sum::<f32>(), stored.iter().rev().sum::<f32>()), (1.0, 1.0));
                // A channel of colors from 0 to 1.
                let color: Vec<f64> = (0..count).map(|_| draw()).collect();
                let mix = |weights: &mut dyn Iterator<Item = f64>| -> f64 {
                    weights.zip(&color).map(|(weight, channel)| weight * channel).sum()
                };
                let off = mix(&mut stored.iter().map(|w| f64::from(*w))) - mix(&mut weights.iter().copied());
                let mut again = weights.clone();
                let moved = storing.apportion(&mut again);
                assert!(again.iter().zip(&stored).all(|(a, b)| *a == f64::from(*b)));
                assert!(off.abs() <= moved + 1e-12, "{off} by {moved}");
                assert!(moved <= storing.error(count, 1.0) + 1e-12, "{moved}");
            }
        }
    }
}

#[test]
fn what_is_stored_already_stays_and_nothing_stays_nothing() {
    for storing in [Storing::Half, Storing::Float] {
        let unit = 1.0 / f64::from(storing.units());
        let mut weights = [0.25, 0.0, 3.0 * unit, 0.75 - 3.0 * unit, 0.0];
        let before = weights;
        assert_eq!(storing.apportion(&mut weights), 0.0);
        assert_eq!(weights, before);
        let rounded = storing.round(&[0.5, 0.0, 0.25 + unit / 3.0, 0.25 - unit / 3.0]);
        assert_eq!(rounded[1], 0.0);
        assert_eq!(rounded.iter().sum::<f32>(), 1.0);
    }
}

proptest! {
    /// Blocks of pixels are apportioned as one by one, also where remainders are equal and weights are 0.
    #[test]
    fn blocks_are_apportioned_as_their_pixels(
        parts in prop::collection::vec(prop::collection::vec(prop_oneof![Just(0.0), 1e-9..1.0, Just(0.125)], 40), BLOCK),
        colors in 1_usize..40,
    ) {
        for storing in [Storing::Half, Storing::Float] {
            let mut blocks = vec![[0.0; BLOCK]; colors];
            let (mut expected, mut most) = (Vec::new(), 0.0_f64);
            for (pixel, parts) in parts.iter().enumerate() {
                let sum: f64 = parts[..colors].iter().sum();
                let mut weights: Vec<f64> = parts[..colors].iter().map(|part| if sum > 0.0 { part / sum } else { 0.0 }).collect();
                blocks.iter_mut().zip(&weights).for_each(|(block, weight)| block[pixel] = *weight);
                most = most.max(storing.apportion(&mut weights));
                expected.push(weights);
            }
            let moved = Apportioner::new(storing).block(&mut blocks);
            for (pixel, expected) in expected.iter().enumerate() {
                prop_assert!(blocks.iter().zip(expected).all(|(block, weight)| block[pixel] == *weight), "pixel {pixel}");
            }
            prop_assert!((moved - most).abs() < 1e-12);
        }
    }
}

#[test]
fn rows_are_apportioned_as_their_pixels() {
    // Not a whole number of blocks, and pixels that mix few of the colors.
    let rows: Vec<Vec<f32>> = (0..40)
        .map(|color| {
            (0..300).map(|pixel| if (pixel / 90 + color) % 7 < 3 { (color * 7 % 11) as f32 } else { 0.0 }).collect()
        })
        .collect();
    let sum = |pixel: usize| rows.iter().map(|row| f64::from(row[pixel])).sum::<f64>();
    let rows: Vec<Vec<f32>> =
        rows.iter().map(|row| (0..300).map(|pixel| (f64::from(row[pixel]) / sum(pixel)) as f32).collect()).collect();
    let slices: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
    for storing in [Storing::Half, Storing::Float] {
        // What was in the rows before does not matter.
        let mut stored = vec![vec![7.0; 300]; 40];
        let moved = Apportioner::new(storing).rows(&slices, &mut stored);
        let mut most = 0.0_f64;
        for pixel in 0..300 {
            let mut weights: Vec<f64> = rows.iter().map(|row| f64::from(row[pixel])).collect();
            most = most.max(storing.apportion(&mut weights));
            assert!(stored.iter().zip(&weights).all(|(row, weight)| f64::from(row[pixel]) == *weight), "{pixel}");
        }
        assert!((moved - most).abs() < 1e-12);
    }
}

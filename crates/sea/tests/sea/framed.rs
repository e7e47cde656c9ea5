//! Tests of sums over squares against the plain sum.

use crate::random::Random;
use std::ops::Range;
use trochoid_sea::{FramedSea, GerstnerSpectrum, Sea};

#[test]
fn squares_and_mirrored_squares_are_the_plain_sum_to_rounding() {
    let mut random = Random(17);
    for (count, columns, rows) in [(0, 3, 2), (1, 1, 1), (9, 8, 3), (64, 16, 2), (65, 17, 2), (300, 5, 4)] {
        let spectrum = GerstnerSpectrum { count, height: 3.0, sharpness: 0.7, ..GerstnerSpectrum::default() };
        let frame = Sea::new(spectrum.waves().expect("valid")).at(5.0);
        let origin = [900.0 * random.unit(), -700.0 * random.unit()];
        let (heading_z, heading_x) = libm::sincos(6.3 * random.unit());
        let sea = FramedSea::new(&frame, origin, [heading_x, heading_z]);
        let places: Vec<(f64, f64)> = (0..rows).map(|_| (200.0 * random.unit(), 2.0 * random.unit())).collect();
        let offsets: Vec<f64> = (0..columns).map(|_| 4.0 * random.unit()).collect();
        let middle = 300.0 * random.unit() - 150.0;
        let factors = |waves: Range<usize>| (sea.rows(&places, waves.clone()), sea.columns(&offsets, waves));
        let (along, across) = factors(0..count);
        let mut both = vec![[0.0; 3]; rows * 2 * columns];
        sea.mirrored(&along, &across, middle, &mut both);
        let mut one = vec![[0.0; 3]; 2 * rows * columns];
        sea.squares(&along, &across, &[middle, -middle], &mut one);
        // The first and the last waves make up all of them.
        let parts = [0..count / 3, count / 3..count].map(|waves| {
            let (along, across) = factors(waves);
            let mut part = vec![[0.0; 3]; both.len()];
            sea.mirrored(&along, &across, middle, &mut part);
            part
        });
        let together = |index: usize| [0, 1, 2].map(|axis| parts[0][index][axis] + parts[1][index][axis]);
        let allowed: f64 = sea
            .waves()
            .iter()
            .map(|wave| {
                let [along, up, across] = wave.amplitudes.map(f64::abs);
                along.max(up).max(across) * (sea.rounding() + wave.phase_error(500.0))
            })
            .sum();
        let check = |found: [f64; 3], v: f64, (u, footprint): (f64, f64)| {
            let place = [origin[0] + heading_x * u - heading_z * v, origin[1] + heading_z * u + heading_x * v];
            let [x, y, z] = frame.evaluate(place, footprint).displacement;
            let expected = [heading_x * x + heading_z * z, y, heading_x * z - heading_z * x];
            for (found, expected) in found.into_iter().zip(expected) {
                let off = (found - expected).abs();
                assert!(off <= allowed, "{count} waves at {u}, {v}: off by {off}, {allowed} is allowed");
            }
        };
        for (row, place) in places.iter().enumerate() {
            for (column, offset) in offsets.iter().enumerate() {
                let own = &both[row * 2 * columns..];
                check(own[columns + column], middle + offset, *place);
                check(together(row * 2 * columns + columns + column), middle + offset, *place);
                check(own[columns - 1 - column], middle - offset, *place);
                check(one[row * columns + column], middle + offset, *place);
                check(one[(rows + row) * columns + column], -middle + offset, *place);
            }
        }
    }
}

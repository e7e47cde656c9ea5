//! Painting: the sum of weights times colors, however rows are divided and whatever weights are 0.

use half::f16;
use trochoid_weights::{Storing, paint};

/// Returns weights of `colors` colors at `count` pixels, plane by plane, most of them 0.
fn planes(colors: usize, count: usize, storing: Storing) -> Vec<Vec<f32>> {
    let mut state = 11_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    let mut planes = vec![vec![0.0; count]; colors];
    for pixel in 0..count {
        let mut weights: Vec<f64> = (0..colors).map(|_| (draw() - 0.6).max(0.0)).collect();
        weights[pixel / 700 % colors] += 0.01;
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        planes.iter_mut().zip(storing.round(&weights)).for_each(|(plane, weight)| plane[pixel] = weight);
    }
    planes
}

#[test]
fn pictures_are_sums_of_weighted_colors() {
    let count = 1500;
    for (colors, storing) in [(1, Storing::Half), (5, Storing::Half), (9, Storing::Float), (24, Storing::Half)] {
        let planes = planes(colors, count, storing);
        let inks: Vec<[f64; 3]> = (0..colors).map(|i| [0, 1, 2].map(|c| ((i * 5 + c * 7) % 13) as f64 / 8.0)).collect();
        let halves: Vec<Vec<u16>> =
            planes.iter().map(|plane| plane.iter().map(|weight| f16::from_f32(*weight).to_bits()).collect()).collect();
        let images = [0.25_f32, 0.5, 0.0].map(|value| vec![value; count]);
        let mut out = [(); 3].map(|()| vec![0.0_f32; count]);
        let rows =
            |start: usize, end: usize| -> Vec<&[f32]> { planes.iter().map(|plane| &plane[start..end]).collect() };
        let beside = images.each_ref().map(Vec::as_slice);
        paint(&rows(0, count), &inks, Some(beside), out.each_mut().map(Vec::as_mut_slice)).unwrap();
        for pixel in 0..count {
            for channel in 0..3 {
                let terms = planes.iter().zip(&inks).map(|(plane, ink)| f64::from(plane[pixel]) * ink[channel]);
                let expected = f64::from(images[channel][pixel]) + terms.sum::<f64>();
                assert!((f64::from(out[channel][pixel]) - expected).abs() < 2e-7, "{channel} of {pixel}");
            }
        }
        // No bit depends on where rows begin.
        let mut part = [(); 3].map(|()| vec![0.0_f32; 333]);
        let beside = images.each_ref().map(|image| &image[801..1134]);
        paint(&rows(801, 1134), &inks, Some(beside), part.each_mut().map(Vec::as_mut_slice)).unwrap();
        assert!((0..3).all(|c| part[c] == out[c][801..1134]));
        if storing == Storing::Half {
            let rows: Vec<&[u16]> = halves.iter().map(Vec::as_slice).collect();
            paint(&rows, &inks, None, out.each_mut().map(Vec::as_mut_slice)).unwrap();
            let mut plain = [(); 3].map(|()| vec![0.0_f32; count]);
            let floats: Vec<&[f32]> = planes.iter().map(Vec::as_slice).collect();
            paint(&floats, &inks, None, plain.each_mut().map(Vec::as_mut_slice)).unwrap();
            let pairs = out.iter().flatten().zip(plain.iter().flatten());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }
}

#[test]
fn illegal_weights_are_found_where_they_are() {
    let mut planes = planes(6, 1200, Storing::Float);
    let inks = vec![[0.5; 3]; 6];
    let found = |planes: &[Vec<f32>]| {
        let mut out = [(); 3].map(|()| vec![0.0_f32; 1200]);
        let rows: Vec<&[f32]> = planes.iter().map(Vec::as_slice).collect();
        paint(&rows, &inks, None, out.each_mut().map(Vec::as_mut_slice))
    };
    assert_eq!(found(&planes), Ok(()));
    planes[3][1100] = f32::NAN;
    assert_eq!(found(&planes), Err(1100));
    planes[1][777] += 2.0_f32.powi(-24);
    assert_eq!(found(&planes), Err(777));
    (planes[0][5], planes[1][5]) = (planes[0][5] + 3.0, planes[1][5] - 3.0);
    assert_eq!(found(&planes), Err(5));
    let nothing = vec![vec![0.0_f32; 1200]; 6];
    assert_eq!(found(&nothing), Err(0));
}

#[test]
fn signs_and_infinities_of_halves_are_told_apart() {
    let found = |weights: [f32; 3]| {
        // More colors than are added at once, and a pixel behind others.
        let mut planes = vec![vec![0_u16; 600]; 11];
        planes[10].fill(f16::ONE.to_bits());
        for (plane, weight) in [0, 7, 10].into_iter().zip(weights) {
            planes[plane][599] = f16::from_f32(weight).to_bits();
        }
        let rows: Vec<&[u16]> = planes.iter().map(Vec::as_slice).collect();
        let mut out = [(); 3].map(|()| vec![0.0_f32; 600]);
        paint(&rows, &[[0.5; 3]; 11], None, out.each_mut().map(Vec::as_mut_slice)).map(|()| out[0][599])
    };
    assert_eq!(found([0.25, 0.5, 0.25]), Ok(0.5));
    assert_eq!(found([-0.0, -0.0, 1.0]), Ok(0.5));
    assert_eq!(found([2.0_f32.powi(-24), 0.0, 1.0 - 2.0_f32.powi(-11)]), Err(599));
    assert_eq!(found([-0.25, 0.5, 0.75]), Err(599));
    for endless in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        assert_eq!(found([endless, 0.5, 0.25]), Err(599));
    }
}

#[test]
fn all_halves_are_converted_as_the_standard_says() {
    let halves: Vec<u16> = (0..=u16::MAX).collect();
    let one = vec![f16::ONE.to_bits(); halves.len()];
    let mut out = [(); 3].map(|()| vec![0.0_f32; halves.len()]);
    let images = [&halves[..]; 3];
    paint(&[&one[..]], &[[0.0; 3]], Some(images), out.each_mut().map(Vec::as_mut_slice)).unwrap();
    for (bits, found) in halves.iter().zip(&out[1]) {
        // The color that is added makes 0 of −0.
        let expected = f16::from_bits(*bits).to_f32() + 0.0;
        assert!(found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan(), "{bits:#06x}: {found}");
    }
}

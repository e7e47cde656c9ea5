//! Tests of the seeds of strokes.

use std::collections::BTreeMap;
use trochoid_field::random::draw;
use trochoid_nodes::inside::{Corner, Seeds, level_of, pixels, scanned};

/// Calls `found` with pixel, key, position and share of each seed of a plane at rest that appears bent, sheared and
/// scaled in the picture.
fn each(size: f64, moved: [f64; 2], pixels: f64, layer: u64, mut found: impl FnMut([i64; 2], u64, [f64; 2], f64)) {
    let corner = |x: i64, y: i64| -> Corner {
        let (x, y) = (x as f64 * 0.7 + moved[0], y as f64 + moved[1]);
        ([size * (x + 0.2 * libm::sin(y)), 3.0, size * (y + 0.3 * x)], 0.0, 1.0)
    };
    let mut seeds = Seeds::new(layer);
    for (x, y) in (0..40).flat_map(|y| (0..60).map(move |x| (x, y))) {
        let corners = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
        seeds.each(corners, 1.0, 1.1, pixels, &mut |key, at, share, _| found([x, y], key, at, share));
    }
}

#[test]
fn there_are_as_many_as_asked_for_at_any_size() {
    for size in [1e-3, 0.03, 1.0, 1.3, 1.7, 2.0, 70.0, 1e5] {
        for spacing in [1.5, 4.0, 9.0f64] {
            let mut sum = 0.0;
            each(size, [0.0; 2], spacing * spacing, 3, |_, _, _, share| sum += share);
            let expected = 40.0 * 60.0 / (spacing * spacing);
            let slack = 3.0 * expected.sqrt() + 0.3 * expected;
            assert!((sum - expected).abs() < slack, "{sum} at size {size}, expected {expected}");
        }
    }
}

#[test]
fn they_stay_where_they_are_on_the_surface() {
    // When the surface moves by a fraction of a pixel, so do its seeds, and new ones appear only at the borders.
    let find = |moved: [f64; 2]| {
        let mut found = BTreeMap::new();
        each(0.8, moved, 25.0, 5, |[x, y], key, at, share| {
            let at = [x as f64 + at[0], y as f64 + at[1]];
            assert!(found.insert(key, (at, share)).is_none(), "found twice");
        });
        found
    };
    let (before, after) = (find([0.0; 2]), find([-0.07, 0.1]));
    let mut kept = 0;
    for (key, (at, share)) in &before {
        let inner = (2.0..58.0).contains(&at[0]) && (2.0..38.0).contains(&at[1]);
        match after.get(key) {
            Some((there, now)) => {
                let moved = [there[0] - at[0], there[1] - at[1]];
                assert!((moved[0] - 0.1).abs() < 0.05 && (moved[1] + 0.1).abs() < 0.05, "{moved:?}");
                assert!((share - now).abs() < 0.3, "{share} becomes {now}");
                kept += 1;
            }
            None => assert!(!inner || *share < 0.3, "a seed of share {share} at {at:?} is gone"),
        }
    }
    assert!(kept > 60, "{kept} seeds kept");
}

#[test]
fn larger_patches_hold_the_seeds_of_those_in_them() {
    // The rest points of this plane are linear in the picture, so both tilings find each seed at the same position.
    let corner = |x: i64, y: i64| -> Corner { ([0.3 * x as f64, 0.0, 0.2 * y as f64], 2.0, 1.0) };
    let find = |side: i64| {
        let (mut found, mut seeds) = (BTreeMap::new(), Seeds::new(9));
        for (y, x) in (0..40).step_by(side as usize).flat_map(|y| (0..60).step_by(side as usize).map(move |x| (y, x))) {
            let [right, below] = [x + side, y + side];
            let corners = [corner(x, y), corner(right, y), corner(x, below), corner(right, below)];
            let area = seeds.each(corners, side as f64, 1.1, 36.0, &mut |key, at, share, part| {
                assert_eq!(part, 2.0);
                found.insert(key, [x as f64 + at[0], y as f64 + at[1], share]);
            });
            assert!(area.is_some());
        }
        found
    };
    let (small, large) = (find(1), find(2));
    assert!(small.len() > 60 && small.keys().eq(large.keys()), "{} and {} seeds", small.len(), large.len());
    for (a, b) in small.values().zip(large.values()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?}, {b:?}");
    }
}

#[test]
fn levels_are_whole_logarithms() {
    for exponent in -40..40 {
        let area = libm::exp2(f64::from(exponent) * 0.37);
        let expected = libm::floor(0.5 * libm::log2(area * 9.0)) as i64;
        assert_eq!(level_of(area, 9.0), Some(expected));
    }
    assert_eq!(level_of(0.0, 9.0), None);
    assert_eq!(level_of(f64::INFINITY, 9.0), None);
    assert_eq!(level_of(f64::NAN, 9.0), None);
}

#[test]
fn patches_do_not_span_edges() {
    let corner = |part: f64, depth: f64| -> Corner { ([0.0, depth, part], part, depth) };
    let placed = |corners: [Corner; 4], side: f64| Seeds::new(0).each(corners, side, 1.1, 9.0, &mut |_, _, _, _| {});
    let near = corner(0.0, 10.0);
    assert!(placed([near, near, near, corner(1.0, 10.0)], 1.0).is_none());
    assert!(placed([near, corner(0.0, 12.0), near, near], 1.0).is_none());
    assert!(placed([near, corner(0.0, 10.5), near, near], 2.0).is_some());
    let sky = corner(-1.0, f64::INFINITY);
    assert!(placed([sky; 4], 1.0).is_some_and(|area| area.is_nan() || area == 0.0));
}

/// Corners of a row of patches: a smooth surface, also turned to the sides and far from the origin, and with hostile values
/// on it.
fn corners(index: u64, below: u64, count: usize) -> Vec<Corner> {
    let random = |which: u64| draw(index, which);
    let scale = libm::exp2(12.0 * random(0) - 8.0);
    let far = if index.is_multiple_of(5) { 1e9 * random(1) } else { 100.0 * random(1) };
    let hostile = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e18, 1e-310, -0.0, 0.0];
    let corner = |x: usize| -> Corner {
        let (u, v) = (x as f64 * scale - far, (below as f64 + 0.2 * libm::sin(x as f64)) * scale + far);
        let mut rest = [u, 0.1 * v, v];
        rest.rotate_left(index as usize % 3);
        let (mut part, mut depth) = (1.0, 10.0 + random(2));
        let which = draw(index + below, 100 + x as u64);
        if index % 4 == 1 && which < 0.2 {
            let value = hostile[(which * 40.0) as usize];
            match x % 5 {
                axis @ 0..3 => rest[axis] = value,
                3 => part = value,
                _ => depth = value,
            }
        }
        if index % 4 == 2 && which < 0.2 {
            (part, depth) = (-1.0, f64::INFINITY);
        }
        (rest, part, depth)
    };
    (0..count).map(corner).collect()
}

#[test]
fn scans_miss_no_seed_and_sort_out_most_patches_without_any() {
    let (mut hold, mut without, mut sorted_out) = (0, 0, 0);
    for index in 0..600 {
        let count = 1 + (70.0 * draw(index, 9)) as usize;
        let (side, spacing) = (1.0 + (index % 2) as f64, 2.0 + 20.0 * draw(index, 10));
        let sizes: Vec<f64> =
            (0..count).map(|x| if index % 3 == 0 { draw(index, 200 + x as u64) } else { 1.0 }).collect();
        let rows = [corners(index, 0, count + 1), corners(index, 1, count + 1)];
        let found = scanned(index, [&rows[0], &rows[1]], side, 1.5, &sizes, spacing);
        assert!(found.is_sorted_by(|a, b| a < b) && found.iter().all(|patch| *patch < count), "{found:?}");
        let mut seeds = Seeds::new(index);
        for patch in 0..count {
            let corners = [rows[0][patch], rows[0][patch + 1], rows[1][patch], rows[1][patch + 1]];
            let mut some = false;
            seeds.each(corners, side, 1.5, pixels(spacing, sizes[patch]), &mut |_, _, _, _| some = true);
            assert!(!some || found.contains(&patch), "row {index}: the seed of patch {patch} is missed");
            hold += usize::from(some);
            without += usize::from(!some);
            sorted_out += usize::from(!found.contains(&patch));
        }
    }
    assert!(hold > 1_000 && sorted_out > 8_000, "{hold} with seeds; {sorted_out} of {without} sorted out");
}

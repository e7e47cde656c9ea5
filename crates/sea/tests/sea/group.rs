//! Tests of wave groups: one crest at its focus, and how it travels.

use std::f64::consts::FRAC_PI_2;
use trochoid_sea::{Sea, WaveError, WaveGroup, WaveParameter};

fn sea(group: WaveGroup) -> Sea {
    Sea::new(group.waves().expect("valid"))
}

fn group() -> WaveGroup {
    WaveGroup { height: 3.0, focus: [40.0, -25.0], time: 7.0, direction: 0.4, ..WaveGroup::default() }
}

#[test]
fn the_crest_stands_at_its_focus_at_its_time() {
    for waves in [[5, 5], [1, 1], [7, 1], [1, 4], [20, 9]] {
        let group = WaveGroup { waves, seed: 5, ..group() };
        let sample = sea(group).at(group.time).evaluate(group.focus, 0.0);
        let [x, y, z] = sample.displacement;
        assert!((y - 3.0).abs() < 1e-9 && x.abs() < 1e-9 && z.abs() < 1e-9, "{waves:?}: {sample:?}");
        assert!(sample.slope.iter().all(|slope| slope.abs() < 1e-9), "{waves:?}");
    }
}

#[test]
fn the_packet_is_a_wave_under_a_bell() {
    // With infinitely many waves the sum is the bell curve; 1.8 standard deviations and 1600 waves come close to it.
    let group = WaveGroup { waves: [40, 40], direction: 0.0, sharpness: 0.0, focus: [0.0; 2], time: 0.0, ..group() };
    let frame = sea(group).at(0.0);
    for (x, z) in [(0.0, 10.0), (0.0, -20.0), (15.0, 0.0), (30.0, 8.0), (-30.0, 5.0)] {
        let bell = (-(x / group.along).powi(2) / 2.0 - (z / group.across).powi(2) / 2.0f64).exp();
        let expected = 3.0 * bell * (std::f64::consts::TAU * x / group.wavelength).cos();
        let found = frame.evaluate([x, z], 0.0).displacement[1];
        assert!((found - expected).abs() < 0.35, "({x}, {z}): {found} for {expected}");
    }
    // Far away, hardly anything is left.
    for far in [[90.0, 0.0], [0.0, 90.0], [-70.0, 70.0]] {
        assert!(frame.evaluate(far, 0.0).displacement[1].abs() < 0.35, "{far:?}");
    }
}

#[test]
fn sharpness_is_the_share_of_the_cusp_at_the_focus() {
    for (sharpness, direction) in [(0.0, 0.0), (0.5, 0.9), (1.0, -2.0), (1.5, FRAC_PI_2)] {
        let group = WaveGroup { sharpness, direction, across: 6.0, ..group() };
        let [xx, xz, zz] = sea(group).at(group.time).evaluate(group.focus, 0.0).strain;
        let (c, s) = (direction.cos(), direction.sin());
        let along = xx * c * c + 2.0 * xz * c * s + zz * s * s;
        assert!((along + sharpness).abs() < 1e-9, "{sharpness}: {along}");
    }
}

#[test]
fn a_crest_with_a_speed_travels_unchanged() {
    let group = WaveGroup { speed: Some(2.5), sharpness: 0.7, ..group() };
    let sea = sea(group);
    let (before, after) = (sea.at(7.0), sea.at(11.0));
    let (dx, dz) = (10.0 * group.direction.cos(), 10.0 * group.direction.sin());
    for place in [[40.0, -25.0], [31.0, -20.0], [55.0, -44.0]] {
        let moved = [place[0] + dx, place[1] + dz];
        let (a, b) = (before.evaluate(place, 0.0).displacement, after.evaluate(moved, 0.0).displacement);
        assert!((0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-9), "{a:?}, {b:?}");
    }
}

#[test]
fn in_deep_water_the_crest_comes_and_goes() {
    let group = group();
    let sea = sea(group);
    let highest = |time: f64| {
        let frame = sea.at(time);
        let height = |i: usize| {
            let place = [(i % 60) as f64 * 3.0 - 90.0, (i / 60) as f64 * 3.0 - 90.0];
            frame.evaluate([place[0] + 40.0, place[1] - 25.0], 0.0).displacement[1]
        };
        (0..3600).map(height).fold(f64::MIN, f64::max)
    };
    assert!(highest(7.0) > 2.9);
    assert!(highest(-8.0) < 2.4 && highest(22.0) < 2.4);
}

#[test]
fn a_seed_decides_and_groups_repeat() {
    assert_eq!(group().waves(), group().waves());
    assert_ne!(group().waves(), WaveGroup { seed: 1, ..group() }.waves());
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |group: WaveGroup| -> WaveError { group.waves().expect_err("refused") };
    assert_eq!(refused(WaveGroup { along: 9.0, ..group() }).parameter, WaveParameter::Along);
    assert_eq!(refused(WaveGroup { across: 0.0, ..group() }).parameter, WaveParameter::Across);
    assert_eq!(refused(WaveGroup { wavelength: f64::NAN, ..group() }).parameter, WaveParameter::Wavelength);
    assert_eq!(refused(WaveGroup { waves: [0, 3], ..group() }).parameter, WaveParameter::Waves);
    assert_eq!(refused(WaveGroup { waves: [usize::MAX, 3], ..group() }).parameter, WaveParameter::Waves);
    assert_eq!(refused(WaveGroup { waves: [200, 200], ..group() }).parameter, WaveParameter::Waves);
    assert_eq!(refused(WaveGroup { time: f64::INFINITY, ..group() }).parameter, WaveParameter::Time);
    // The shortest accepted packet still has waves of one direction only.
    for wave in (WaveGroup { along: 9.3, seed: 3, ..group() }).waves().expect("valid") {
        let [x, z] = wave.direction;
        assert!(x * group().direction.cos() + z * group().direction.sin() > 0.0);
    }
}

//! Tests of crossed ripples: the sum of two waves against the product that is printed.

use crate::random::Random;
use std::f64::consts::TAU;
use trochoid_sea::{GRAVITY, Ripple, Sea};

fn height(ripple: &Ripple, time: f64, place: [f64; 2]) -> f64 {
    Sea::new(ripple.waves().expect("valid").to_vec()).at(time).evaluate(place, 0.0).displacement[1]
}

/// Returns the product, straight from the text, with the position rotated so that the ripples travel along x.
fn product(ripple: &Ripple, time: f64, [x, z]: [f64; 2]) -> f64 {
    let (sin, cos) = ripple.direction.sin_cos();
    let (along, across) = (x * cos + z * sin, z * cos - x * sin);
    let [k1, k2] = ripple.lengths.map(|length| TAU / length);
    let (p, q) = if ripple.literal {
        let turned = ripple.frequency.unwrap_or(1.0) * time;
        (k1 * along + turned + ripple.phase, k2 * across + turned)
    } else {
        let turned = ripple.frequency.unwrap_or((GRAVITY * (k1 * k1 + k2 * k2).sqrt()).sqrt()) * time;
        (k1 * along - turned + ripple.phase, k2 * across)
    };
    ripple.height * p.sin() * q.cos()
}

#[test]
fn the_printed_line_is_met() {
    // pos.y += cos(pos.z * 5.0 + uTime) * 0.1 * sin(pos.x * 5.0 + uTime)
    let ripple = Ripple { literal: true, ..Ripple::default() };
    for (x, z, time) in [(0.0, 0.0, 0.0), (0.3, -0.7, 0.0), (1.9, 4.2, 7.5), (-12.0, 3.3, 100.0)] {
        let printed = (z * 5.0f64 + time).cos() * 0.1 * (x * 5.0f64 + time).sin();
        assert!((height(&ripple, time, [x, z]) - printed).abs() < 1e-12, "({x}, {z}) at {time}");
    }
}

#[test]
fn two_waves_make_the_product() {
    let mut random = Random(5);
    for _ in 0..400 {
        let mut between = |low: f64, high: f64| random.between(low, high);
        let ripple = Ripple {
            height: between(-3.0, 3.0),
            lengths: [10f64.powf(between(-3.0, 5.0)), 10f64.powf(between(-3.0, 5.0))],
            direction: between(-9.0, 9.0),
            frequency: (between(0.0, 1.0) < 0.5).then_some(between(-30.0, 30.0)),
            phase: between(-9.0, 9.0),
            literal: between(0.0, 1.0) < 0.5,
        };
        let far = 10f64.powf(between(-1.0, 7.0));
        let (time, place) = (far * between(-1.0, 1.0), [far * between(-1.0, 1.0), far * between(-1.0, 1.0)]);
        let (found, truth) = (height(&ripple, time, place), product(&ripple, time, place));
        // Phases of u radians are known to u·2⁻⁵³, by either method.
        let frequency = ripple.frequency.unwrap_or(300.0).abs();
        let phase = far * (2.0 * frequency + TAU / ripple.lengths[0] + TAU / ripple.lengths[1]) + 10.0;
        let error = 4e-16 * phase * ripple.height.abs() + 1e-12;
        assert!((found - truth).abs() <= 10.0 * error, "{ripple:?} at {time}, {place:?}: {found} for {truth}");
    }
}

#[test]
fn settled_ripples_travel_unchanged_and_printed_ones_do_not() {
    let settled = Ripple { direction: 0.8, lengths: [3.0, 5.0], ..Ripple::default() };
    let [wave, other] = settled.waves().expect("valid");
    assert_eq!((wave.angular_frequency, wave.wavelength), (other.angular_frequency, other.wavelength));
    let pace = wave.angular_frequency / (TAU / 3.0);
    for place in [[0.4, 0.1], [-3.0, 2.0]] {
        let moved = [place[0] + 2.0 * pace * 0.8f64.cos(), place[1] + 2.0 * pace * 0.8f64.sin()];
        assert!((height(&settled, 5.0, place) - height(&settled, 7.0, moved)).abs() < 1e-12);
    }
    let [twice, still] = Ripple { literal: true, ..settled }.waves().expect("valid");
    assert_eq!((twice.angular_frequency, still.angular_frequency), (2.0, 0.0));
}

#[test]
fn figures_out_of_range_are_refused_by_name() {
    let ripple = Ripple::default();
    for (wrong, name) in [
        (Ripple { height: f64::NAN, ..ripple }, "height"),
        (Ripple { lengths: [0.0, 1.0], ..ripple }, "wavelength"),
        (Ripple { lengths: [1.0, f64::INFINITY], ..ripple }, "wavelength"),
        (Ripple { direction: f64::INFINITY, ..ripple }, "direction"),
        (Ripple { phase: f64::NAN, ..ripple }, "phase"),
        (Ripple { frequency: Some(f64::INFINITY), ..ripple }, "frequency"),
    ] {
        assert_eq!(wrong.waves().expect_err("refused").parameter.to_string(), name);
    }
}

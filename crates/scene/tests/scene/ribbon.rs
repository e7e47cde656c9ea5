//! Tests of ribbons.

use trochoid_scene::claws::{Ribbon, Shape};

const STRAIGHT: Shape = Shape { curl: 0.0, late: 1.5, taper: 1.0, bulge: 0.0 };

#[test]
fn a_straight_ribbon_is_a_wedge() {
    let ribbon = Ribbon::new(&STRAIGHT, [10.0, 5.0], 0.0, 24.0, 6.0);
    let at = |x: f64, y: f64| ribbon.at([x, y]);
    let middle = at(22.0, 5.0).unwrap();
    assert!((middle.along - 0.5).abs() < 1e-12 && middle.across == 0.0 && (middle.half_width - 3.0).abs() < 1e-12);
    let right = at(22.0, 6.5).unwrap();
    assert!((right.across - 0.5).abs() < 0.02 && right.across > 0.0, "y points down: {right:?}");
    assert!(at(22.0, 3.5).unwrap().across < 0.0);
    assert!(at(22.0, 8.2).is_none() && at(35.0, 5.0).is_none());
    // The end at the root is round.
    assert!(at(9.0, 5.0).is_some_and(|within| within.along < 0.2) && at(5.0, 5.0).is_none());
}

#[test]
fn it_bends_late_and_as_far_as_it_says() {
    let shape = Shape { curl: 2.0, late: 2.5, ..STRAIGHT };
    let ribbon = Ribbon::new(&shape, [0.0; 2], 0.3, 100.0, 10.0);
    let (tip, direction) = ribbon.spine(1.0);
    assert!((direction - 2.3).abs() < 1e-12);
    // Integrate the direction in many small steps.
    let mut point = [0.0; 2];
    for step in 0..100_000 {
        let s = (f64::from(step) + 0.5) / 1e5;
        let (sin, cos) = libm::sincos(0.3 + 2.0 * libm::pow(s, 2.5));
        point = [point[0] + cos * 1e-3, point[1] + sin * 1e-3];
    }
    assert!((tip[0] - point[0]).abs() < 0.2 && (tip[1] - point[1]).abs() < 0.2, "{tip:?}, expected {point:?}");
    let ([x, y], early) = ribbon.spine(0.4);
    assert!((early - 0.3 - 2.0 * libm::pow(9.0 / 24.0, 2.5)).abs() < 1e-12);
    assert!(ribbon.at([x, y]).is_some_and(|within| within.across.abs() < 1e-9));
    let [[x0, x1], [y0, y1]] = ribbon.bounds();
    for place in (0..4000).map(|i| [f64::from(i % 63) * 3.0 - 40.0, f64::from(i / 63) * 3.0 - 40.0]) {
        let inside = (x0..=x1).contains(&place[0]) && (y0..=y1).contains(&place[1]);
        assert!(inside || ribbon.at(place).is_none(), "{place:?} lies beyond the bounds");
    }
}

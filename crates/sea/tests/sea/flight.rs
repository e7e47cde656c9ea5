//! Tests of a drop's flight in closed form.

use trochoid_sea::GRAVITY;
use trochoid_sea::inside::{decays, fly};

#[test]
fn both_forms_of_the_decays_meet() {
    for s in [0.099_999_999, 0.1] {
        let (first, second) = (-libm::expm1(-s) / s, (s + libm::expm1(-s)) / (s * s));
        let found = decays(s);
        assert!((found.0 - first).abs() < 1e-15 && (found.1 - second).abs() < 1e-13, "{s}: {found:?}");
    }
    assert_eq!(decays(0.0), (1.0, 0.5));
}

#[test]
fn flight_solves_its_equation() {
    // Compared with many small steps of the midpoint rule.
    for drag in [0.0, 0.3, 4.0] {
        let (start, push, wind) = ([1.0, 2.0, -3.0], [4.0, 9.0, -2.0], [8.0, 0.5, 1.0]);
        let (mut x, mut v) = (start, push);
        let steps = 20_000;
        let dt = 1.5 / f64::from(steps);
        let pull = |v: [f64; 3], axis: usize| drag * (wind[axis] - v[axis]) - [0.0, GRAVITY, 0.0][axis];
        for _ in 0..steps {
            let middle: [f64; 3] = std::array::from_fn(|axis| v[axis] + pull(v, axis) * dt / 2.0);
            for axis in 0..3 {
                x[axis] += middle[axis] * dt;
                v[axis] += pull(middle, axis) * dt;
            }
        }
        let (place, speed) = fly(start, push, wind, drag, 1.5);
        for axis in 0..3 {
            assert!((place[axis] - x[axis]).abs() < 1e-6, "{drag}: {place:?}, expected {x:?}");
            assert!((speed[axis] - v[axis]).abs() < 1e-6, "{drag}: {speed:?}, expected {v:?}");
        }
    }
}

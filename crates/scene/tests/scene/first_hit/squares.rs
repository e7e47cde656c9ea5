//! Tests of displacements between the points of squares.

use trochoid_scene::inside::first_hit::{
    LONG_POINTS, LONG_ROUNDING, PARTS, POINTS, ROUNDING, SIDE, between, doubled, nodes,
};

#[test]
fn values_between_points_are_those_of_the_polynomial_within_the_rounding() {
    let (coarse, fine) = (nodes::<POINTS>(), nodes::<SIDE>());
    for case in 0..20 {
        let part = |by: f64| (f64::from(case) * by + 0.2).fract() - 0.5;
        let (a, b) = (12.0 * part(0.618), 12.0 * part(0.414));
        let of = |u: f64, v: f64| libm::cos(a * u + b * v + part(0.732)) + part(0.31) * u * v;
        let own = coarse.map(|u| coarse.map(|v| of(u, v)));
        let values = between(&own);
        for (row, values) in values.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                let [u, v] = [row, column]
                    .map(|index| ((2 * (index / SIDE) + 1) as f64 - PARTS as f64 + fine[index % SIDE]) / PARTS as f64);
                // Waves of 6 rad to the side are 1e-20 off.
                let off = (value - of(u, v)).abs();
                assert!(off <= 1.5 * ROUNDING, "case {case} at {u}, {v}: {off:e}");
            }
        }
    }
    const { assert!(ROUNDING < 5e-11) };
}

#[test]
fn values_of_long_waves_at_all_points_are_those_of_their_polynomial_within_the_rounding() {
    let (long, points) = (nodes::<LONG_POINTS>(), nodes::<POINTS>());
    for case in 0..40 {
        let part = |by: f64| (f64::from(case) * by + 0.2).fract() - 0.5;
        let (a, b) = (2.4 * part(0.618), 2.4 * part(0.414));
        let of = |u: f64, v: f64| libm::cos(a * u + b * v + part(0.732)) + part(0.31) * u * v;
        for (u, values) in points.into_iter().zip(doubled(&long.map(|u| long.map(|v| of(u, v))))) {
            for (v, value) in points.into_iter().zip(values) {
                // Waves of 1.2 rad to the side are 2e-15 off.
                let off = (value - of(u, v)).abs();
                assert!(off <= 1.5 * LONG_ROUNDING, "case {case} at {u}, {v}: {off:e}");
            }
        }
    }
    const { assert!(LONG_ROUNDING < 5e-12) };
}

//! Tests of the layers of Clouds.

use trochoid_nodes::inside::{BEND, CloudLayer};
use trochoid_scene::{DVec3, Ray};

#[test]
fn layers_come_down_to_the_horizon() {
    let layer = CloudLayer::new(900.0, 400.0, 0.3, 0.5);
    let ray = |from: f64, up: f64| Ray {
        origin: DVec3::new(0.0, from, 0.0),
        direction: DVec3::new(0.0, up, -1.0).normalize(),
    };
    let span = |from: f64, up: f64| layer.span(&ray(from, up), BEND, 1e7);
    // Straight up the ray meets the layer as over a plane; at the horizon, the Earth hides anything higher.
    let up = Ray { origin: DVec3::ZERO, direction: DVec3::Y };
    assert_eq!(layer.span(&up, BEND, 1e7), Some([900.0, 1300.0]));
    let [near, far] = span(0.0, 0.0).unwrap();
    assert!((near - (900.0 / BEND).sqrt()).abs() < 1e-6 && (far - (1300.0 / BEND).sqrt()).abs() < 1e-6);
    // The segment changes continuously down to the horizon; below it, there is none.
    let mut before = near;
    for step in 0..2000 {
        let [near, far] = span(0.0, f64::from(step) * 1e-5).unwrap();
        assert!(near <= before && before - near < 2e3 && far > near, "{step}: {near} after {before}");
        before = near;
    }
    assert_eq!(span(0.0, -1e-9), None);
    // From within and above: down to the base, or out through the top if the ray does not reach the base.
    let [near, far] = span(1000.0, -0.1).unwrap();
    assert!(near == 0.0 && (far - 100.0 / 0.0995).abs() < 10.0, "{far}");
    let [near, far] = span(1000.0, -1e-4).unwrap();
    assert!(near == 0.0 && far > (300.0 / BEND).sqrt(), "{far}");
    assert!(span(5000.0, -0.2).is_some_and(|[near, far]| near > 18_000.0 && far > near));
    assert_eq!(span(5000.0, -1e-4), None, "it passes over the layer");
    assert_eq!(span(5000.0, 0.1), None);
    // Without a bend, layers are planes.
    assert_eq!(layer.span(&ray(1000.0, 0.0), 0.0, 500.0), Some([0.0, 500.0]));
    assert_eq!(layer.span(&ray(0.0, 0.0), 0.0, 500.0), None);
    assert_eq!(layer.span(&ray(0.0, -0.5), 0.0, 500.0), None);
}

#[test]
fn parts_grow_in_number_and_make_up_the_way() {
    let layer = CloudLayer::new(900.0, 400.0, 0.3, 0.5);
    for (length, steps, most) in [(400.0, 6, 6), (100.0, 6, 6), (500.0, 6, 8), (1e6, 6, 36), (1e6, 1, 6)] {
        let parts = layer.cut([50.0, 50.0 + length], steps);
        assert!(parts.len() <= most + 1 && parts.len() >= most, "{length}: {}", parts.len());
        let sum: f64 = parts.iter().map(|(_, length)| length).sum();
        assert!((sum - length).abs() < 1e-9 * length, "{sum} of {length}");
        assert!(parts.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}

#[test]
fn what_cannot_be_told_apart_has_its_mean_density() {
    for softness in [0.0, 0.3, 2.0] {
        let layer = CloudLayer::new(0.0, 1.0, softness, 0.0);
        for (noise, spread) in [(0.0, 0.4), (0.1, 0.05), (-0.2, 0.1), (-0.2, 0.7), (0.5, 1e-9)] {
            let count = 20_000;
            let at = |index: i32| noise + spread * (2.0 * (f64::from(index) + 0.5) / f64::from(count) - 1.0);
            let mean = (0..count).map(|index| layer.density(at(index), 0.5, 0.0)).sum::<f64>() / f64::from(count);
            let found = layer.density(noise, 0.5, spread);
            assert!((found - mean).abs() < 1e-3, "{softness}, {noise} ± {spread}: {found}, expected {mean}");
        }
    }
}

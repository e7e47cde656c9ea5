//! Tests of LightPool.

use crate::testing::{Frame, frame, refused, view};
use trochoid_graph::{Channel, Reference};

/// Returns light that falls from a direction, in a pool of 20 m by 5 m.
fn falling(direction: [f64; 3]) -> Frame {
    let turn = libm::atan2(0.8, 0.6).to_degrees();
    let nodes = format!(
        r#""camera": {{ "type": "Camera" }}, "sea": {{ "type": "GerstnerSea", "count": 0 }},
        "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
        "light": {{ "type": "Light", "direction": {direction:?} }},
        "noise": {{ "type": "FieldMath", "expression": "0" }},
        "out": {{ "type": "LightPool", "view": "view", "light": "light", "noise": "noise", "ragged": 0.5, "from": 0,
            "to": 1, "pools": [{{ "x": 10, "z": -5, "length": 20, "width": 5, "direction": {turn:?} }}] }}"#
    );
    frame("weights", &nodes)
}

/// Returns the mask at a point.
fn mask(frame: &Frame, [x, y, z]: [f64; 3], noise: f64) -> f64 {
    frame.mask_of(&|name| match name {
        "noise" => Reference::Field(vec![noise]),
        _ => view(&[(Channel::PositionX, x), (Channel::PositionY, y), (Channel::PositionZ, z)]),
    })
}

#[test]
fn a_pool_is_brightest_in_its_center_and_as_long_as_it_says() {
    let pool = falling([0.0, 1.0, 0.0]);
    let at = |x: f64, z: f64| mask(&pool, [x, 3.0, z], 0.0);
    assert_eq!(at(10.0, -5.0), 1.0);
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let edge = smooth(libm::exp(-1.0));
    for side in [-1.0, 1.0] {
        let along = at(10.0 + side * 20.0 * 0.6, -5.0 + side * 20.0 * 0.8);
        let across = at(10.0 - side * 5.0 * 0.8, -5.0 + side * 5.0 * 0.6);
        assert!((along - edge).abs() < 1e-12 && (across - edge).abs() < 1e-12, "{along}, {across}, {edge}");
    }
    assert_eq!(at(1e9, 0.0), 0.0);
    assert!(mask(&pool, [10.0, 0.0, -5.0], -1.0) < 0.6, "noise takes from it");
}

#[test]
fn slanting_light_meets_crests_beside_the_pool() {
    // A point two meters up is reached by the ray that would meet height 0 four meters away along x.
    let slanting = falling([1.0, 0.5, 0.0]);
    assert_eq!(mask(&slanting, [14.0, 2.0, -5.0], 0.0), 1.0);
    assert!(mask(&slanting, [10.0, 2.0, -5.0], 0.0) < 0.9);
    // Light from below falls straight down.
    assert_eq!(mask(&falling([1.0, -0.5, 0.0]), [10.0, 2.0, -5.0], 0.0), 1.0);
}

#[test]
fn edges_run_upward() {
    let nodes = r#""camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "out": { "type": "LightPool", "view": "view", "from": 0.5, "to": 0.25 }"#;
    assert!(refused("weights", nodes).contains("0.25 below from"));
}

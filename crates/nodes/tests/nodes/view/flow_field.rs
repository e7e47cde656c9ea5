//! Tests of FlowField.

use crate::testing::{frame, refused};
use trochoid_nodes::inside::{doubled, halved, projected};
use trochoid_scene::DVec3;

#[test]
fn halving_undoes_doubling() {
    for degrees in -89..=90 {
        let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
        let ([x, y], length) = halved(doubled([cos, sin]));
        assert!((length - 1.0).abs() < 1e-12);
        assert!((x - cos).abs() < 1e-7 && (y - sin).abs() < 1e-7, "{degrees}: {x}, {y}");
        let (other, _) = halved(doubled([-cos, -sin]));
        assert_eq!(other, [x, y], "a line has two directions");
    }
    assert_eq!(halved([0.0; 2]), ([0.0; 2], 0.0));
}

#[test]
fn projection_is_the_slope_of_places_in_the_picture() {
    let camera = trochoid_scene::Camera {
        position: DVec3::new(1.0, 4.0, 9.0),
        target: DVec3::new(0.0, 1.0, 0.0),
        roll: 0.3,
        projection: trochoid_scene::Projection::Perspective { fov: 0.9 },
    };
    let eye = camera.projector(trochoid_image::Format::new(64, 48, 1).unwrap());
    for index in 0..200 {
        let t = f64::from(index);
        let point = DVec3::new(3.0 * libm::sin(t), libm::sin(2.7 * t), -4.0 + 3.0 * libm::cos(1.3 * t));
        let way = DVec3::new(libm::cos(5.1 * t), libm::sin(3.3 * t), libm::cos(t));
        let place = |by: f64| eye.project(point + way * by).unwrap().0;
        let (before, after) = (place(-1e-5), place(1e-5));
        let [x, y] = [after[0] - before[0], after[1] - before[1]];
        let expected = [x, y].map(|along| along / x.hypot(y));
        let found = projected(&eye, point, way).unwrap();
        assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5), "{found:?}, {expected:?}");
    }
}

#[test]
fn directions_by_hand_are_the_same_everywhere() {
    let frame = frame("field", r#""out": { "type": "FlowField", "along": "constant", "turn": 30 }"#);
    let truth = frame.truth([1.5, 1.5]);
    assert!((truth[0] - 0.75f64.sqrt()).abs() < 1e-9 && (truth[1] - 0.5).abs() < 1e-9, "{truth:?}");
    let id = frame.graph.find("out").unwrap();
    assert!((frame.filled(id, 0, 1, [1.5, 1.5]) - 0.5).abs() < 1e-6);
}

#[test]
fn needs_what_it_follows() {
    assert!(refused("field", r#""out": { "type": "FlowField" }"#).contains("slope without a view"));
    let contour = r#""out": { "type": "FlowField", "along": "contour" }"#;
    assert!(refused("field", contour).contains("contour without a field"));
}

//! Tests of InFront.

use crate::testing::{frame, refused, view};
use trochoid_graph::Channel;

const SCENE: &str = r#""c": { "type": "Camera" }, "s": { "type": "GerstnerSea", "count": 0 },
    "t": { "type": "GerstnerSea", "count": 0, "level": -1 },
    "v": { "type": "Render", "camera": "c", "surfaces": ["s"] },
    "w": { "type": "Render", "camera": "c", "surfaces": ["t"] }"#;

#[test]
fn depths_by_two_cameras_are_refused() {
    let nodes = r#""a": { "type": "Camera" }, "b": { "type": "Camera", "fov": 41 },
        "s": { "type": "GerstnerSea", "count": 0 },
        "v": { "type": "Render", "camera": "a", "surfaces": ["s"] },
        "w": { "type": "Render", "camera": "b", "surfaces": ["s"] },
        "out": { "type": "InFront", "view": "v", "other": "w" }"#;
    let faults = refused("weights", nodes);
    assert!(faults.contains("views by different cameras") && faults.contains("connect the camera of"), "{faults}");
}

#[test]
fn nothing_is_behind_everything() {
    let nothing = f64::INFINITY;
    let mask = |depth: f64, other: f64, soft: f64| {
        let nodes = format!(r#"{SCENE}, "out": {{ "type": "InFront", "view": "v", "other": "w", "soft": {soft} }}"#);
        frame("weights", &nodes).mask_of(&|name| view(&[(Channel::Depth, if name == "v" { depth } else { other })]))
    };
    for soft in [0.0, 2.0] {
        assert_eq!((mask(nothing, nothing, soft), mask(nothing, 5.0, soft), mask(5.0, nothing, soft)), (0.0, 0.0, 1.0));
        assert_eq!((mask(1.0, 5.0, soft), mask(5.0, 1.0, soft)), (1.0, 0.0));
    }
    assert_eq!((mask(5.0, 5.0, 0.0), mask(5.0, 5.0, 2.0), mask(5.0, 5.5, 2.0)), (0.0, 0.5, 0.75));
}

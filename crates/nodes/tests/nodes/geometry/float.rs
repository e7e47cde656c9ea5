//! Tests of Float.

use crate::testing::{Frame, graph, refused};
use std::path::Path;

#[test]
fn only_water_floats_things() {
    let nodes = |sea: &str| {
        format!(
            r#""c": {{ "type": "Camera" }}, "water": {{ "type": "RippleSea" }},
            "m": {{ "type": "BezierModel", "patches": [{{ "points": [{{ "at": [0, 0, 0] }}, {{ "at": [1, 0, 0] }},
                {{ "at": [0, 0, 1] }}, {{ "at": [1, 0, 1] }}] }}] }},
            "f": {{ "type": "Float", "model": "m", "sea": "{sea}", "bodies": [{{ "x": 1 }}, {{ "x": 4 }}] }},
            "v": {{ "type": "Render", "camera": "c", "surfaces": ["f"] }},
            "out": {{ "type": "Depth", "view": "v" }}"#
        )
    };
    assert!(Frame::new(graph("field", &nodes("water"), Path::new(".")).unwrap()).is_ok());
    let faults = refused("field", &nodes("m"));
    assert!(faults.contains("which has no water level") && faults.contains("RippleSea or ToonSea"), "{faults}");
}

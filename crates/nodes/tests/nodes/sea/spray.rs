//! Tests of Spray.

use crate::testing::refused;

const SCENE: &str = r#""c": { "type": "Camera" }, "s": { "type": "GerstnerSea", "count": 4 },
    "v": { "type": "Render", "camera": "c", "surfaces": ["s"] },"#;

#[test]
fn what_would_take_too_much_is_refused_with_the_knob_to_change() {
    for (knobs, expected) in [
        (r#""size": [1e6, 1e6]"#, "smaller or \\\"cell\\\" larger"),
        (r#""lifetime": 10000, "rate": 10000"#, "steps in a lifetime"),
        (r#""size": [400, 400], "lifetime": 200"#, "cells over all steps"),
        (r#""density": 1e6, "cell": 10, "size": [20, 20]"#, "drops from a cell"),
        (r#""size": [-1, 5]"#, "not negative"),
        (r#""bursts": [{ "count": 500000 }, { "count": 1 }]"#, "drops at a time"),
    ] {
        let nodes = format!(r#"{SCENE} "out": {{ "type": "Spray", "view": "v", "sea": "s", {knobs} }}"#);
        let faults = refused("weights", &nodes);
        assert!(faults.contains(expected), "{knobs}: {faults}");
    }
}

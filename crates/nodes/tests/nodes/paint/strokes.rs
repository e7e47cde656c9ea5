//! Tests of Strokes.

use crate::testing::refused;

#[test]
fn a_flow_has_two_components() {
    let nodes = r##""x": { "type": "ScreenX" },
        "out": { "type": "Strokes", "image": "#808080", "flow": "x", "layers": [{}] }"##;
    let faults = refused("color", nodes);
    assert!(faults.contains("2 components"), "{faults}");
}

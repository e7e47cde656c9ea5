//! Tests of ObjectMask.

use crate::testing::refused;

#[test]
fn nothing_chosen_and_no_places_are_refused() {
    let nodes = |knobs: &str| {
        format!(
            r#""c": {{ "type": "Camera" }}, "s": {{ "type": "BezierModel", "model": "a.json" }},
            "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }},
            "out": {{ "type": "ObjectMask", "view": "v" {knobs} }}"#
        )
    };
    assert!(refused("weights", &nodes("")).contains("no surface"));
    for index in ["0.5", "-1", "64"] {
        let faults = refused("weights", &nodes(&format!(r#", "indices": [{index}]"#)));
        assert!(faults.contains("whole numbers"), "{faults}");
    }
}

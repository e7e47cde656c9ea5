//! Tests of ToonSea.

use crate::testing::refused;

#[test]
fn faults_of_bursts_name_the_list_that_they_are_in() {
    let (near, far) = (r#"[{ "path": [0, 0, 1, 1, 2, 2, 3, 3] }]"#, r#"[{ "path": [1e10, 0, 1, 1, 2, 2, 3, 3] }]"#);
    for (lists, port) in [
        (format!(r#""bursts": {far}"#), "bursts"),
        (format!(r#""bursts": {near}, "guides": {far}"#), "guides"),
        (format!(r#""bursts": {near}, "guides": {near}, "bodies": {far}"#), "bodies"),
    ] {
        let nodes = format!(
            r#""c": {{ "type": "Camera" }}, "s": {{ "type": "ToonSea", {lists} }},
            "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }}, "out": {{ "type": "Depth", "view": "v" }}"#
        );
        let faults = refused("field", &nodes);
        let place = format!("port: Some(\"{port}\"), found: \"control point 10000000000");
        assert!(faults.contains(&place), "{port}: {faults}");
    }
}

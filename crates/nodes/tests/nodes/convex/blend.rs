//! Tests of Blend.

use crate::testing::{agrees, refused};

const XY: &str = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;

#[test]
fn any_weights_blend() {
    let colors = r#""colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"#;
    for weights in [
        r#"{ "type": "Stack", "weights": ["x", "y"] }"#,
        r#"{ "type": "Bands", "field": "x", "thresholds": [0.3, 0.7], "width": 0.2 }"#,
        r#"{ "type": "Normalize", "fields": ["x", "y"], "floor": 0.5 }"#,
    ] {
        let out = format!(r#"{XY}, "w": {weights}, "out": {{ "type": "Blend", {colors}, "weights": "w" }}"#);
        agrees("color", &out);
    }
    agrees("color", &format!(r#""out": {{ "type": "Blend", {colors}, "weights": [0.5, 0.3, 0.2] }}"#));
    agrees(
        "color",
        &format!(r#"{XY}, "out": {{ "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": "x" }}"#),
    );
}

#[test]
fn as_many_colors_as_weights() {
    let few = r#""out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": [0.5, 0.25, 0.25] }"#;
    let text = refused("color", few);
    assert!(text.contains("2 colors for 3 weights") && text.contains("darker than each of its colors"), "{text}");
    let many = r#""x": { "type": "ScreenX" },
        "out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "weights": "x" }"#;
    assert!(refused("color", many).contains("3 colors for 2 weights"));
}

#[test]
fn a_disabled_mask_leaves_the_stack() {
    let nodes = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY", "disabled": true },
        "w": { "type": "Stack", "weights": ["x", "y"] },
        "out": { "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0]], "weights": "w" }"#;
    agrees("color", nodes);
}

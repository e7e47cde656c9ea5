//! Tests of Switch.

use crate::testing::{agrees, frame, graph, refused};

#[test]
fn any_image_is_handed_on() {
    let nodes = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "weights": { "type": "Stack", "weights": ["x", "y"] },
        "color": { "type": "Mix", "a": "#123", "b": "#def", "weight": "x" }"##;
    for which in [0, 1] {
        for (key, inputs) in [
            ("weights", r#""x", "y""#),
            ("weights", r#"0.25, "y""#),
            ("weights", r#""weights", "weights""#),
            ("color", r##""color", "#456""##),
            ("color", r##"[1, 2, 3], "color""##),
        ] {
            agrees(key, &format!(r#"{nodes}, "out": {{ "type": "Switch", "inputs": [{inputs}], "which": {which} }}"#));
        }
    }
}

#[test]
fn switches_of_switches_know_their_kind() {
    let nodes = r#""out": { "type": "Switch", "inputs": ["b"] }, "b": { "type": "Switch", "inputs": ["c", "x"] },
        "c": { "type": "Switch", "inputs": ["x"] }, "x": { "type": "ScreenX" }"#;
    assert_eq!(frame("weights", nodes).lowered([0.5, 0.5]), [1.0, 0.0]);
    let looped = r#""out": { "type": "Switch", "inputs": ["b"] }, "b": { "type": "Switch", "inputs": ["out"] }"#;
    assert!(refused("weights", looped).contains("loop"));
}

#[test]
fn keys_hold_until_the_next() {
    let keyed = |keys: &str| {
        format!(r#""out": {{ "type": "Switch", "inputs": [0.25, 0.5, 0.75], "which": {{ "keys": [{keys}] }} }}"#)
    };
    let graph = graph("weights", &keyed("[1, 0], [10, 2]"), std::path::Path::new(".")).unwrap();
    let id = graph.find("out").unwrap();
    let which = [0, 1, 9, 10, 11].map(|frame| graph.settle(id, frame).node().identity().unwrap().number());
    assert_eq!(which, [0.25, 0.25, 0.25, 0.75, 0.75].map(Some));
    let text = refused("weights", &keyed("[1, 0], [10, 3]"));
    assert!(text.contains("3, with 3 inputs") && text.contains("a whole number from 0 to 2"), "{text}");
    assert!(refused("weights", &keyed("[1, 0], [10, 1.5]")).contains("a whole number"));
    let linear = r#""out": { "type": "Switch", "inputs": [0, 1],
        "which": { "keys": [[1, 0], [10, 1]], "interpolation": "linear" } }"#;
    assert!(refused("weights", linear).contains("holds until the next"));
}

#[test]
fn inputs_are_of_one_kind() {
    let text = refused("color", r##""out": { "type": "Switch", "inputs": ["#fff", 0.5] }"##);
    assert!(text.contains("a Color as inputs[0] and a mask as inputs[1]"), "{text}");
    let text = refused("color", r#""out": { "type": "Switch", "inputs": [] }"#);
    assert!(text.contains("a list of 1 to 256"), "{text}");
    assert!(refused("color", r#""out": { "type": "Switch", "inputs": [1.5] }"#).contains("1.5"));
}

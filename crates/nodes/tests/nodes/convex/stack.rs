//! Tests of Stack.

use crate::testing::{agrees, frame};

#[test]
fn weights_agree_with_the_formula() {
    let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
    for weights in [r#""x""#, r#""x", "y""#, r#""x", 0.25, "y", 0.5"#] {
        agrees("weights", &format!(r#"{xy}, "out": {{ "type": "Stack", "weights": [{weights}] }}"#));
    }
}

#[test]
fn the_first_lies_on_top() {
    let frame = frame("weights", r#""out": { "type": "Stack", "weights": [0.75, 1, 1] }"#);
    assert_eq!(frame.lowered([0.5, 0.5]), [0.75, 0.25, 0.0, 0.0]);
}

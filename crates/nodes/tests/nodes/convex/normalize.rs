//! Tests of Normalize.

use crate::testing::{agrees, frame};

#[test]
fn weights_agree_with_the_formula() {
    let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
    for fields in [r#""x""#, r#""x", "y""#, r#""x", "y", -3, 0.2"#] {
        let out = format!(r#"{xy}, "out": {{ "type": "Normalize", "fields": [{fields}], "floor": 0.5 }}"#);
        agrees("weights", &out);
    }
}

#[test]
fn nothing_goes_to_the_last() {
    let frame = frame("weights", r#""out": { "type": "Normalize", "fields": [-1, 0] }"#);
    assert_eq!(frame.lowered([0.5, 0.5]), [0.0, 0.0, 1.0]);
    assert_eq!(frame.truth([0.5, 0.5]), [0.0, 0.0, 1.0]);
}

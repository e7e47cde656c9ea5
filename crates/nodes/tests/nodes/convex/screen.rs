//! Tests of Screen.

use crate::testing::agrees;

#[test]
fn any_of_the_masks() {
    let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
    agrees("weights", &format!(r#"{xy}, "out": {{ "type": "Screen", "weights": ["x", "y", 0.25] }}"#));
}

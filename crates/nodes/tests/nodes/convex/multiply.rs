//! Tests of Multiply.

use crate::testing::agrees;

#[test]
fn all_masks_at_once() {
    let xy = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }"#;
    agrees("weights", &format!(r#"{xy}, "out": {{ "type": "Multiply", "weights": ["x", "y", 0.5] }}"#));
}

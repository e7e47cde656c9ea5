//! Tests of Invert.

use crate::testing::agrees;

#[test]
fn weights_change_sides() {
    agrees("weights", r#""x": { "type": "ScreenX" }, "out": { "type": "Invert", "weight": "x" }"#);
    agrees("weights", r#""out": { "type": "Invert", "weight": 0.3 }"#);
}

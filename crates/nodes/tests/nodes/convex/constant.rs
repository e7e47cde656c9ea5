//! Tests of Constant.

use crate::testing::{agrees, frame};

#[test]
fn a_color_is_itself() {
    agrees("color", r##""out": { "type": "Constant", "color": "#8b9aa1" }"##);
    let nodes = r#""out": { "type": "Constant", "color": [0.25, 0.5, 4] }"#;
    assert_eq!(frame("color", nodes).lowered([0.5, 0.5]), [0.25, 0.5, 4.0]);
}

//! Tests of ScreenX.

use crate::testing::frame;

#[test]
fn from_the_first_center_to_the_last() {
    let frame = frame("weights", r#""out": { "type": "ScreenX" }"#);
    let id = frame.graph.find("out").unwrap();
    for (x, t) in [(0.5, 0.0), (3.5, 1.0), (2.0, 0.5), (0.25, 0.0), (3.75, 1.0), (1.25, 0.25)] {
        assert_eq!(frame.filled(id, 0, 0, [x, 1.5]), t);
        assert_eq!(frame.truth([x, 1.5])[1], f64::from(t));
    }
}

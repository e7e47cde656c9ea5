//! Tests of ScreenY.

use crate::testing::frame;

#[test]
fn from_the_first_center_to_the_last() {
    let frame = frame("weights", r#""out": { "type": "ScreenY" }"#);
    let id = frame.graph.find("out").unwrap();
    for (y, t) in [(0.5, 0.0), (2.5, 1.0), (1.5, 0.5), (0.25, 0.0), (2.75, 1.0), (1.0, 0.25)] {
        assert_eq!(frame.filled(id, 0, 0, [1.5, y]), t);
        assert_eq!(frame.truth([1.5, y])[1], f64::from(t));
    }
}

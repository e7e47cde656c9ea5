//! Tests of Ramp.

use crate::testing::{agrees, frame, refused};

fn ramp(interpolation: &str, stops: &str) -> String {
    format!(
        r#""x": {{ "type": "ScreenX" }},
        "out": {{ "type": "Ramp", "weight": "x", "interpolation": "{interpolation}", "stops": [{stops}] }}"#
    )
}

const STOPS: &str = r#"{ "at": 0.1, "color": [1, 0, 0] }, { "at": 0.4, "color": [0, 1, 0] },
    { "at": 0.4, "color": [0.5, 0.5, 0] }, { "at": 0.9, "color": [0, 0, 1] }"#;

#[test]
fn the_chain_of_mixes_is_the_sum_of_hats() {
    for interpolation in ["linear", "smooth", "step"] {
        agrees("color", &ramp(interpolation, STOPS));
    }
    agrees("color", &ramp("linear", r#"{ "at": 0.5, "color": [1, 2, 3] }"#));
}

#[test]
fn a_stop_shows_its_color() {
    for interpolation in ["linear", "smooth", "step"] {
        let stops = r#"{ "at": 0, "color": [0.1, 0.7, 0.3] }, { "at": 0.5, "color": [0.3, 0.9, 0.1] },
            { "at": 0.5, "color": [0.2, 0.6, 0.4] }, { "at": 1, "color": [0.7, 0.2, 0.9] }"#;
        let frame = frame("color", &ramp(interpolation, stops));
        assert_eq!(frame.lowered([0.5, 0.5]), [0.1, 0.7, 0.3]);
        assert_eq!(frame.lowered([2.0, 0.5]), [0.2, 0.6, 0.4], "the later of two at one place");
        assert_eq!(frame.lowered([3.5, 0.5]), [0.7, 0.2, 0.9]);
    }
}

#[test]
fn stops_ascend() {
    let stops = r#"{ "at": 0.5, "color": [1, 0, 0] }, { "at": 0.4, "color": [0, 1, 0] }"#;
    assert!(refused("color", &ramp("linear", stops)).contains("a stop at 0.4 after one at 0.5"));
}

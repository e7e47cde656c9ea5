//! Tests of Bands.

use crate::testing::{agrees, frame, refused};

fn bands(thresholds: &str, width: f64) -> String {
    format!(
        r#""x": {{ "type": "ScreenX" }},
        "out": {{ "type": "Bands", "field": "x", "thresholds": [{thresholds}], "width": {width} }}"#
    )
}

#[test]
fn weights_agree_with_the_formula() {
    for thresholds in ["0.4", "0.2, 0.6", "0.1, 0.3, 0.31, 0.8"] {
        for width in [0.0, 0.15, 0.9] {
            agrees("weights", &bands(thresholds, width));
        }
    }
}

#[test]
fn the_lowest_band_is_first_and_a_threshold_belongs_to_the_upper() {
    let hard = frame("weights", &bands("0.25, 0.5, 0.75", 0.0));
    assert_eq!(hard.lowered([0.5, 0.5]), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(hard.lowered([2.0, 0.5]), [0.0, 0.0, 1.0, 0.0]);
    assert_eq!(hard.lowered([3.5, 0.5]), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(frame("weights", &bands("0.5", 0.0)).lowered([2.0, 0.5]), [0.0, 1.0]);
}

#[test]
fn thresholds_ascend() {
    assert!(refused("weights", &bands("0.5, 0.2", 0.0)).contains("0.2 after 0.5"));
    assert!(refused("weights", &bands("3e38", 3e38)).contains("beyond the range of f32"));
}

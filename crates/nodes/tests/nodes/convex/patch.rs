//! Tests of Patch.

use crate::testing::{agrees, frame, refused};

fn patch(count: usize) -> String {
    let color = |i: usize| format!("[{}, {}, {}]", i, (i * 7) % 5, (i * i) % 3);
    let colors: Vec<String> = (0..count).map(color).collect();
    format!(
        r#""x": {{ "type": "ScreenX" }}, "y": {{ "type": "ScreenY" }},
        "out": {{ "type": "Patch", "u": "x", "v": "y", "colors": [{}] }}"#,
        colors.join(", ")
    )
}

#[test]
fn casteljau_is_bernstein() {
    agrees("color", &patch(4));
    let frame = frame("color", &patch(16));
    for at in [[0.6, 0.7], [1.9, 2.2], [3.3, 1.1]] {
        for (truth, found) in frame.truth(at).iter().zip(frame.lowered(at)) {
            assert!((truth - f64::from(found)).abs() < 1e-5, "{truth} and {found}");
        }
    }
}

#[test]
fn rows_run_along_u() {
    let frame = frame("color", &patch(16));
    for (at, first) in [([0.5, 0.5], 0.0), ([3.5, 0.5], 3.0), ([0.5, 2.5], 12.0), ([3.5, 2.5], 15.0)] {
        assert_eq!(frame.lowered(at)[0], first);
    }
}

#[test]
fn other_counts_are_refused() {
    assert!(refused("color", &patch(9)).contains("9 colors"));
}

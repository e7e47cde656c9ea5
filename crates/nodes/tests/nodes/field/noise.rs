//! Tests of Noise.

use crate::testing::{frame, refused};

#[test]
fn follows_its_offset_and_agrees_with_the_reference() {
    for kind in ["fbm", "ridged", "cellular", "edges"] {
        for offset in ["[0, 0, 0]", "[1e7, -3e6, 5]"] {
            let nodes = format!(
                r#""out": {{ "type": "Noise", "kind": "{kind}", "scale": 0.31, "offset": {offset}, "seed": 5 }}"#
            );
            let frame = frame("field", &nodes);
            let id = frame.graph.find("out").unwrap();
            for (x, y) in (0..12).flat_map(|y| (0..16).map(move |x| (x, y))) {
                let at = [f64::from(x) / 4.0 + 0.125, f64::from(y) / 4.0 + 0.125];
                let (found, truth) = (frame.filled(id, 0, 0, at), frame.truth(at)[0]);
                assert!((f64::from(found) - truth).abs() < 3e-6, "{kind} at {at:?}: {found}, expected {truth}");
            }
        }
    }
}

#[test]
fn needs_a_view_off_the_screen() {
    let faults = refused("field", r#""out": { "type": "Noise", "space": "rest" }"#);
    assert!(faults.contains("rest without a view"), "{faults}");
}

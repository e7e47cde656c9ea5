//! Tests of Clouds.

use crate::testing::frame;
use trochoid_graph::Reference;

/// Returns a document with clouds, seen by a camera and lit from a direction.
fn clouds(camera: &str, direction: &str, layers: &str) -> String {
    format!(
        r#""camera": {{ "type": "Camera", {camera} }}, "sun": {{ "type": "Light", {direction} }},
           "clouds": {{ "type": "Clouds", "camera": "camera", "light": "sun", "wind": 30, "steps": 5,
             "layers": [{layers}] }},
           "out": {{ "type": "Clamp", "field": "clouds", "min": 0, "max": 1 }}"#
    )
}

#[test]
fn agree_with_the_reference_from_below_within_and_above() {
    let up = r#""position": [0, 2, 0], "target": [0, 20, -60]"#;
    let within = r#""position": [5e5, 1700, 0], "target": [5e5, 1700, -60]"#;
    let above = r#""position": [0, 9000, 0], "target": [0, 0, -6000]"#;
    let flat = r#""projection": "orthographic", "height": 5000, "target": [0, 9, 0]"#;
    let two = r#"{ "scale": 700, "cover": 0.6 }, { "height": 4000, "thickness": 100, "stretch": 4, "softness": 0.8 }"#;
    let hard = r#"{ "softness": 0, "rounding": 2, "cover": 1, "opacity": 1000, "scale": 0.01 }"#;
    let none = r#"{ "cover": 0, "softness": 0 }"#;
    for camera in [up, within, above, flat] {
        for direction in ["[0, 0.3, -1]", "[1, 0, 0]", "[0, -1, 0.2]"] {
            for layers in [two, hard, none] {
                let nodes = clouds(camera, &format!(r#""direction": {direction}"#), layers);
                let frame = frame("weights", &nodes);
                let id = frame.graph.find("clouds").unwrap();
                let mut off = 0;
                for index in 0..40 {
                    let at = [f64::from(index % 8) / 2.0 + 0.2, f64::from(index / 8) * 0.6 + 0.1];
                    let values = [0, 1, 2].map(|output| match frame.reference(id, output, at) {
                        Reference::Mask(value) => value,
                        Reference::Field(values) => values[0],
                        _ => unreachable!(),
                    });
                    for (output, truth) in values.into_iter().enumerate() {
                        let found = f64::from(frame.filled(id, output, 0, at));
                        assert!(output == 2 || (0.0..=1.0).contains(&found), "{found}");
                        let near = (found - truth).abs() < 2e-3 * truth.abs().max(1.0);
                        off += usize::from(!(near || found == truth));
                    }
                }
                // Hard edges may fall to either side, and at densities near 0 rounding errors are divided by the
                // density.
                assert!(off <= 3, "{off} of 120 differ: {nodes}");
            }
        }
    }
}

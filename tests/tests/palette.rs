//! Linearity in the palette: a picture is the sum of its control colors times its weights, so a finished frame
//! can be recolored without evaluating the graph again.

use crate::support::{evaluate, graph, settings};
use trochoid::{Buffers, CheckedGraph};

/// A small picture of five control colors; the outputs after the first are weights.
fn painted(colors: &[[f32; 3]; 5]) -> CheckedGraph {
    let [c0, c1, c2, c3, c4] = colors.map(|color| format!("{:?}", color.map(f64::from)));
    let nodes = format!(
        r#""x": {{ "type": "ScreenX" }}, "y": {{ "type": "ScreenY" }},
        "t": {{ "type": "Clamp", "field": "x", "min": 0.2, "max": 0.9, "smooth": true }},
        "w": {{ "type": "Normalize", "fields": ["x", "y"], "floor": 1.5 }},
        "a": {{ "type": "Mix", "a": {c0}, "b": {c1}, "weight": "t" }},
        "b": {{ "type": "Blend", "colors": ["a", {c2}, {c3}], "weights": "w" }},
        "out": {{ "type": "Mix", "a": "b", "b": {c4}, "weight": "y" }}"#
    );
    let outputs =
        r#""out": { "color": "out" }, "t": { "weights": "t" }, "w": { "weights": "w" }, "y": { "weights": "y" }"#;
    graph(r#""width": 32, "height": 16, "samples": 1"#, &nodes, outputs)
}

/// Returns the weight of each control color at a pixel, from the weight outputs alone.
fn weights(frame: &trochoid::Frame, at: usize) -> [f64; 5] {
    let value = |picture: usize, channel: usize| f64::from(frame.pictures[picture].planes[channel].samples()[at]);
    let (t, y) = (value(1, 0), value(3, 0));
    let w = [value(2, 0), value(2, 1), value(2, 2)];
    let below = 1.0 - y;
    [(1.0 - t) * w[0] * below, t * w[0] * below, w[1] * below, w[2] * below, y]
}

#[test]
fn new_colors_need_no_new_evaluation() {
    let old = [[0.1, 0.2, 0.3], [0.9, 0.8, 0.7], [0.0, 1.0, 0.0], [0.5, 0.0, 0.25], [0.3, 0.3, 0.9]];
    let new = [[4.0, 0.0, 1.0], [0.25, 0.5, 0.0], [1.0, 1.0, 2.0], [0.0, 0.125, 0.75], [3.0, 0.5, 0.0]];
    let before = evaluate(&painted(&old), 1, &Buffers::new(), &settings(|_| ()));
    let after = evaluate(&painted(&new), 1, &Buffers::new(), &settings(|_| ()));
    for at in 0..32 * 16 {
        let weights = weights(&before, at);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-7, "{weights:?} at {at}");
        for (colors, frame) in [(&old, &before), (&new, &after)] {
            for c in 0..3 {
                let sum: f64 = weights.iter().zip(colors).map(|(w, color)| w * f64::from(color[c])).sum();
                let found = f64::from(frame.pictures[0].planes[c].samples()[at]);
                // Three levels of 1.5 ulp at 4.
                assert!((found - sum).abs() < 3.0 * 1.5 * 4.8e-7, "{found} and {sum} at {at}");
            }
        }
    }
    // The weights do not depend on the colors.
    for picture in 1..4 {
        assert_eq!(before.pictures[picture].planes, after.pictures[picture].planes);
    }
}

//! Values that vary along one axis are computed only for that axis, in every order of evaluation and for every tile.

use crate::support::{graph, under_all_settings};
use trochoid::{Buffers, Format};

const WIDTH: usize = 7;
const HEIGHT: usize = 5;

/// Values that vary by row, by column, by both, by neither, or by pixel, each through curves that fused and unfused
/// code must compute alike.
fn nodes(list: &[&str]) -> String {
    let curve = |name: &str, of: &str| {
        format!(
            r#""{name}": {{ "type": "Clamp", "field": "{of}", "min": 0.1, "max": 0.9, "smooth": true, "power": 2.5 }}"#
        )
    };
    let mut nodes = vec![
        r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }, "pixels": { "type": "ScreenX" }"#.to_string(),
        curve("column", "x"),
        curve("row", "y"),
        curve("pixel", "pixels"),
        r#""constant": { "type": "Invert", "weight": 0.3 }"#.to_string(),
        r#""both": { "type": "Multiply", "weights": ["row", "column"] }"#.to_string(),
        r#""all": { "type": "Screen", "weights": ["both", "pixel", "constant"] }"#.to_string(),
    ];
    for name in list {
        nodes.push(format!(
            r##""layers_{name}": {{ "type": "Stack", "weights": ["{name}", 0.25, "constant"] }},
            "shares_{name}": {{ "type": "Normalize", "fields": ["{name}", 0.5] }},
            "mix_{name}": {{ "type": "Mix", "a": "#123", "b": [3, 1, 0.5], "weight": "{name}" }},
            "blend_{name}": {{ "type": "Blend", "colors": ["mix_{name}", "#fed", "#987"], "weights": "shares_{name}" }},
            "out_{name}": {{ "type": "Blend", "colors": ["blend_{name}", "#abc", "#def", "#000"],
                "weights": "layers_{name}" }}"##
        ));
    }
    nodes.join(",\n")
}

#[test]
fn every_variance_gives_the_same_bits_in_every_order() {
    let names = ["row", "column", "pixel", "constant", "both", "all"];
    let pixels: Vec<f32> = (0..WIDTH * HEIGHT).map(|i| ((i * 13) % 35) as f32 / 34.0).collect();
    let buffers = Buffers::new().with("pixels", &[&pixels]);
    // One output at a time, so that each kind of variance is also tested alone; then all together.
    let mut sets: Vec<Vec<&str>> = names.iter().map(|name| vec![*name]).collect();
    sets.push(vec!["row", "pixel"]);
    sets.push(names.to_vec());
    for set in sets {
        let outputs: Vec<String> = set
            .iter()
            .map(|name| {
                format!(
                    r#""out_{name}": {{ "color": "out_{name}" }}, "layers_{name}": {{ "weights": "layers_{name}" }},
                    "{name}": {{ "weights": "{name}" }}, "field_{name}": {{ "field": "{name}" }}"#
                )
            })
            .collect();
        let graph = graph(&format!(r#""width": {WIDTH}, "height": {HEIGHT}"#), &nodes(&names), &outputs.join(", "));
        for samples in [1, 4, 16] {
            let format = Format::new(WIDTH as u32, HEIGHT as u32, samples).unwrap();
            let what = format!("{set:?} with {samples} samples");
            under_all_settings(&graph.clone().with_format(format), 1, &buffers, &what);
            under_all_settings(&graph.clone().with_format(format), 1, &Buffers::new(), &format!("{what}, unbound"));
        }
    }
}

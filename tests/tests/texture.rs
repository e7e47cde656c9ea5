//! Textures that are seen smaller than they are stored.

use crate::support::{evaluate, folder, graph_in, settings, write_exr};
use trochoid::{Buffers, Picture};

/// A scrolling checkerboard on water up to the horizon; `footprint` is the entry of the texture, if any.
fn scrolling(footprint: &str) -> String {
    format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 48, "height": 27 }}, "frames": {{ "first": 1, "last": 9 }},
        "nodes": {{
          "camera": {{ "type": "Camera", "position": [0, 2, 0], "target": [0.3, 1.6, -3], "fov": 60 }},
          "sea": {{ "type": "GerstnerSea", "count": 0 }},
          "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
          "at": {{ "type": "UV", "view": "view" }},
          "depth": {{ "type": "Depth", "view": "view" }},
          "u": {{ "type": "FieldMath", "expression": "0.25 * a.x + 0.061 * frame", "a": "at" }},
          "v": {{ "type": "FieldMath", "expression": "0.25 * a.y + 0.037 * frame", "a": "at" }},
          "covered": {{ "type": "FieldMath", "expression": "0.25 * min(a, 1e4)^2 * 0.024 / 2", "a": "depth" }},
          "board": {{ "type": "Texture", "file": "board.exr", "as": "field", "u": "u", "v": "v" {footprint} }}
        }},
        "outputs": {{ "board": {{ "field": "board" }}, "seen": {{ "weights": "view.coverage" }} }} }}"#
    )
}

/// Returns the mean change from frame to frame of the pixels that the horizon is in or just above, of 255.
fn flicker(text: &str, folder: &std::path::Path) -> f64 {
    let graph = graph_in(folder, text);
    let frames: Vec<_> = (1..=9).map(|frame| evaluate(&graph, frame, &Buffers::new(), &settings(|_| ()))).collect();
    let samples = |picture: &Picture| picture.planes[0].samples().to_vec();
    let seen = samples(&frames[0].pictures[1]);
    let horizon = seen.iter().position(|coverage| *coverage > 0.0).unwrap() / 48 * 48;
    let far = horizon..horizon + 3 * 48;
    let all: Vec<Vec<f32>> = frames.iter().map(|frame| samples(&frame.pictures[0])[far.clone()].to_vec()).collect();
    let changes = all.windows(2).flat_map(|two| two[0].iter().zip(&two[1]).map(|(a, b)| f64::from((a - b).abs())));
    let changes: Vec<f64> = changes.collect();
    255.0 * changes.iter().sum::<f64>() / changes.len() as f64
}

#[test]
fn at_the_horizon_a_texture_with_a_footprint_does_not_flicker() {
    let folder = folder();
    let samples: Vec<f32> = (0..64).map(|pixel| ((pixel % 8 + pixel / 8) % 2) as f32).collect();
    write_exr(&folder.path().join("board.exr"), 8, 8, &[("Y", &samples)]);
    let without = flicker(&scrolling(""), folder.path());
    assert!(without > 40.0, "{without}");
    let with = flicker(&scrolling(r#", "footprint": "covered""#), folder.path());
    assert!(with < 3.0, "{with}");
}

//! Tests of Decompose.

use crate::testing::{Frame, graph, refused};
use trochoid_image::Window;
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};

fn decompose(colors: &str) -> String {
    format!(r#""out": {{ "type": "Decompose", "file": "a.exr", "colors": [{colors}] }}"#)
}

#[test]
fn a_blend_of_the_same_colors_is_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let colors = [[0.1_f32, 0.2, 0.3], [0.5, 0.5, 0.5], [0.9, 0.1, 0.4], [0.3, 0.7, 0.2]];
    let channel = |c: usize| colors.iter().map(|color| color[c]).collect::<Vec<f32>>();
    let planes = [0, 1, 2].map(channel);
    let channels = ["R", "G", "B"].iter().zip(&planes);
    let channels = channels.map(|(name, plane)| ExrChannel::float(*name, Samples::contiguous(plane))).collect();
    write_exr(folder.path().join("a.exr"), &ExrImage { channels, ..ExrImage::new(Window::sized(2, 2)) }).unwrap();
    for softness in ["0", "0.2", "1"] {
        let nodes = format!(
            r##""taken": {{ "type": "Decompose", "file": "a.exr", "fit": "nearest", "softness": {softness},
                "colors": ["#000", "#f00", "#0f0", "#00f", "#ff0", "#0ff", "#f0f", "#fff"] }},
            "out": {{ "type": "Blend", "weights": "taken",
                "colors": ["#000", "#f00", "#0f0", "#00f", "#ff0", "#0ff", "#f0f", "#fff"] }}"##
        );
        let frame = Frame::new(graph("color", &nodes, folder.path()).unwrap()).unwrap();
        for (index, color) in colors.iter().enumerate() {
            let at = [0.5 + 2.0 * (index % 2) as f64, 0.5 + 2.0 * (index / 2) as f64];
            let found = frame.truth(at);
            let off = found.iter().zip(color).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{softness}: {found:?} for {color:?}");
        }
    }
}

#[test]
fn palettes_must_be_colors_of_their_own() {
    for (colors, told) in [
        (r##""#000""##, r#"found: "1 color", expected: "2 to 24 colors""#),
        (r##""#000", "blue""##, r#"found: "\"blue\"", expected: "a color""#),
        (r##""#000", "palette.deep""##, "whatever the document's"),
        (r##""#000", "#fff", "#000000""##, r#"expected: "colors that differ""#),
    ] {
        let found = refused("weights", &decompose(colors));
        assert!(found.contains(told), "{found}");
    }
}

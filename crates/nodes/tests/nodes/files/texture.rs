//! Tests of Texture.

use crate::testing::{Frame, graph, refused};
use trochoid_graph::Reference;
use trochoid_image::Window;
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};

#[test]
fn coordinates_come_back_to_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    // Values are positions across: ½ in the middle of the first pixel.
    let samples = [0.5, 1.5, 2.5, 3.5];
    let channels = vec![ExrChannel::float("Y", Samples::contiguous(&samples))];
    write_exr(folder.path().join("a.exr"), &ExrImage { channels, ..ExrImage::new(Window::sized(4, 1)) }).unwrap();
    let frames = ["repeat", "clamp", "mirror"].map(|wrap| {
        let nodes = format!(
            r#""u": {{ "type": "FieldMath", "expression": "0" }},
            "out": {{ "type": "Texture", "file": "a.exr", "as": "field", "u": "u", "v": 0.5, "wrap": "{wrap}" }}"#
        );
        Frame::new(graph("field", &nodes, folder.path()).unwrap()).unwrap()
    });
    // Halfway between the last and the first pixel; and the middles of both, which repeat at the edges.
    let (seam, first, last) = (2.0, 0.5, 3.5);
    for (at, expected) in [
        (0.25, [1.0, 1.0, 1.0]),
        (1.25, [1.0, last, 3.0]),
        (-0.25, [3.0, first, 1.0]),
        (-3.75, [1.0, first, 1.0]),
        (0.0, [seam, first, first]),
        (1e30, [seam, last, first]),
        (f64::INFINITY, [seam, last, first]),
        (f64::NEG_INFINITY, [seam, first, first]),
        (f64::NAN, [seam, first, first]),
    ] {
        let found = frames.each_ref().map(|frame| frame.given([0.5; 2], &|_, _| Reference::Field(vec![at])));
        let found = found.map(|outputs| match &outputs[..] {
            [Reference::Field(values)] => values[0],
            _ => panic!("a field of one component"),
        });
        assert_eq!(found, expected, "{at}");
    }
}

#[test]
fn knobs_of_colors_are_refused_of_fields() {
    let node = r#""out": { "type": "Texture", "file": "a.exr", "as": "field", "premultiplied": true, "u": 0, "v": 0 }"#;
    assert!(refused("field", node).contains("a Texture as field"));
}

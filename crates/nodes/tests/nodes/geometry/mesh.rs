//! Tests of Mesh.

use crate::testing::{Frame, graph, refused};
use std::path::Path;
use trochoid_graph::NodeError;
use trochoid_scene::DVec3;

fn nodes(knobs: &str) -> String {
    format!(
        r#""c": {{ "type": "Camera", "position": [0, 0, 5], "target": [0, 0, 0] }},
        "s": {{ "type": "Mesh", {knobs} }}, "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }},
        "out": {{ "type": "Normal", "view": "v" }}"#
    )
}

/// Two triangles that meet at an edge, with a seam of texture coordinates along it.
const TENT: &str = "v -2 -2 0\nv 2 -2 0\nv 0 0 1\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 0.5 1\nvt 0 1\n\
                    f 1/1 2/2 3/3\nf 3/4 2/2 4/1\nf 1/1 3/3 4/4\n";

fn prepared(knobs: &str) -> Result<Frame, NodeError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tent.obj"), TENT).unwrap();
    Frame::new(graph("field", &nodes(knobs), folder.path()).unwrap())
}

fn normal(frame: &Frame, at: [f64; 2]) -> DVec3 {
    DVec3::from_slice(&frame.truth(at))
}

#[test]
fn normals_are_smooth_across_seams_or_flat() {
    let smooth = prepared(r#""file": "tent.obj""#).unwrap();
    let flat = prepared(r#""file": "tent.obj", "normals": "flat""#).unwrap();
    // Right and left of the edge that rises from the tent's point.
    let (left, right) = ([1.98, 1.3], [2.02, 1.3]);
    let bend = |frame: &Frame| normal(frame, left).distance(normal(frame, right));
    assert!(bend(&smooth) < 0.05 && bend(&flat) > 0.3, "{} {}", bend(&smooth), bend(&flat));
    for frame in [&smooth, &flat] {
        assert!(normal(frame, left).z > 0.5);
    }
}

#[test]
fn models_whose_z_points_up_are_turned() {
    let up = prepared(r#""file": "tent.obj", "up": "z", "rotate": [90, 0, 0]"#).unwrap();
    let as_it_is = prepared(r#""file": "tent.obj""#).unwrap();
    for at in [[2.0, 1.2], [1.7, 1.6], [2.4, 1.7]] {
        assert!(normal(&up, at).distance(normal(&as_it_is, at)) < 1e-9);
    }
}

#[test]
fn knobs_without_sense_and_files_that_are_none_are_refused() {
    let message = |result: Result<Frame, NodeError>| result.err().unwrap().to_string();
    assert!(refused("field", &nodes(r#""file": "a.obj", "scale": [1, 1, 0]"#)).contains("other than 0"));
    assert!(refused("field", &nodes(r#""up": "y""#)).contains("file"));
    assert!(message(prepared(r#""file": "none.obj""#)).contains("none.obj"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let error = message(Frame::new(graph("field", &nodes(r#""file": "Cargo.toml""#), root).unwrap()));
    assert!(error.contains("Cargo.toml: found no triangle"), "{error}");
}

//! Tests of BezierModel.

use crate::testing::{graph, prepare, refused};
use std::path::Path;
use std::sync::Arc;
use trochoid_graph::Pool;
use trochoid_image::Format;
use trochoid_scene::{Camera, DVec3, Projection, Ray, Surface, first_reference};

fn nodes(knobs: &str) -> String {
    format!(
        r#""c": {{ "type": "Camera" }}, "s": {{ "type": "BezierModel", {knobs} }},
        "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }}, "out": {{ "type": "Depth", "view": "v" }}"#
    )
}

const FIVE: &str = r#""patches": [{ "points": [{ "at": [0, 0, 0] }, { "at": [0, 0, 0] }, { "at": [0, 0, 0] },
    { "at": [0, 0, 0] }, { "at": [1, 0, 0] }] }]"#;
const RAILS: &str = r#"{ "points": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }, { "at": [2, 1, 0] }] },
    { "points": [{ "at": [0, 0, 1] }, { "at": { "keys": [[1, [1, 0, 1]], [9, [1, 4, 1]]] } },
        { "at": [2, 0, 1] }] }"#;

#[test]
fn what_makes_no_surface_is_refused() {
    for (knobs, part) in [
        (r#""stretch": 1"#, "no patches"),
        (r#""model": "a.json", "scale": [1, 0, 1]"#, "factors other than 0"),
        (FIVE, "5 points of patches[0]"),
        (r#""rails": [{ "points": [{ "at": [0,0,0] }, { "at": [1,0,0] }] }]"#, "1 rails"),
    ] {
        let faults = refused("field", &nodes(knobs));
        assert!(faults.contains(part), "{knobs}: {faults}");
    }
}

#[test]
fn keyed_points_move_and_the_notes_report_joints() {
    let graph = graph("field", &nodes(&format!(r#""rails": [{RAILS}]"#)), Path::new(".")).unwrap();
    let camera = Camera {
        position: DVec3::Y,
        target: DVec3::ZERO,
        roll: 0.0,
        projection: Projection::Orthographic { height: 9.0 },
    };
    let eye = camera.projector(Format::new(64, 64, 1).unwrap());
    // The height of the joint at the second rail.
    let corner = |frame: i64| {
        let context = graph.frame_context(frame, 1 << 30);
        let handle = prepare(&graph, "s", &context, None, &Pool::new()).unwrap().handle().unwrap();
        let surface: &Arc<dyn Surface> = handle.downcast_ref().unwrap();
        let ray = Ray { origin: DVec3::new(1.0 + 1e-9, 10.0, 1.0 - 1e-9), direction: DVec3::NEG_Y };
        10.0 - first_reference(&eye, &[&**surface], &ray, 100.0).unwrap().unwrap()
    };
    for (frame, height) in [(1, 0.0), (5, 2.0), (9, 4.0)] {
        assert!((corner(frame) - height).abs() < 1e-6, "{} in frame {frame}", corner(frame));
    }
    let notes = graph.settle(graph.find("s").unwrap(), 1).node().notes(graph.times());
    assert!(notes[0].starts_with("2 patches, 1 joint: no gaps"), "{notes:?}");
}

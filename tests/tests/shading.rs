//! Shading per pixel: values that samples share, and values that they must not share.

use crate::support::{bits, evaluate, graph, pixels_are_as_the_whole, sample, settings, under_all_settings};
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, ReferenceFrame, Silent};

/// Nodes of a sea and a sail before the sky, with passes that samples share and passes that they do not.
const NODES: &str = r##"
        "camera": { "type": "Camera", "position": [0, 3, 12], "target": [0, 1, 0], "fov": 50 },
        "sun": { "type": "Light", "direction": [0.5, 0.6, 1] },
        "waves": { "type": "GerstnerSea", "wavelength": 6, "spread": 1, "height": 1.5, "count": 20, "seed": 3 },
        "sail": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-1, 0, 5] }, { "at": [2, -1, 4] },
          { "at": [0, 4, 5] }, { "at": [1, 3.5, 3] }] }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["waves", "sail"] },
        "cosine": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
        "shine": { "type": "Specular", "view": "view", "lights": ["sun"], "shininess": 20 },
        "lace": { "type": "Noise", "view": "view", "space": "world", "scale": 0.7 },
        "grain": { "type": "Grain", "threads": 12 },
        "height": { "type": "Height", "view": "view" },
        "half": { "type": "Clamp", "field": "height", "min": -0.2, "max": 0.6 },
        "torn": { "type": "FieldMath", "expression": "a + 0.4 * b - 0.2 * c", "a": "half", "b": "lace", "c": "grain" },
        "foam": { "type": "Clamp", "field": "torn", "min": 0.1, "max": 0.9 },
        "edge": { "type": "Outline", "view": "view", "width": 1.5 },
        "depth": { "type": "Depth", "view": "view" },
        "haze": { "type": "Clamp", "field": "depth", "min": 5, "max": 60 },
        "sail_only": { "type": "ObjectMask", "view": "view", "indices": [1] },
        "sea": { "type": "Mix", "a": "#123a5c", "b": "#d8e4d0", "weight": "foam" },
        "lit": { "type": "Mix", "a": "sea", "b": "#ffe0a0", "weight": "cosine" },
        "shiny": { "type": "Mix", "a": "lit", "b": "#ffffff", "weight": "shine" },
        "shade": { "type": "Shadow", "view": "view", "lights": ["sun"], "size": 30 },
        "dim": { "type": "Mix", "a": "shiny", "b": "#0c2030", "weight": "shade" },
        "both": { "type": "Mix", "a": "dim", "b": "#c03020", "weight": "sail_only" },
        "far": { "type": "Mix", "a": "both", "b": "#90a0b0", "weight": "haze" },
        "inked": { "type": "Mix", "a": "far", "b": "#000000", "weight": "edge" },
        "beauty": { "type": "Mix", "a": "#f0d090", "b": "inked", "weight": "view.coverage" }"##;

fn scene(format: &str) -> CheckedGraph {
    graph(format, NODES, r#""beauty": { "color": "beauty" }, "torn": { "field": "torn" }"#)
}

#[test]
fn shading_by_the_pixel_keeps_its_bits_and_its_reference() {
    let format = |shading: &str| format!(r#""width": 40, "height": 22, "samples": 4, "shading": "{shading}""#);
    let graph = scene(&format("pixel"));
    let frame = under_all_settings(&graph, 7, &Buffers::new(), "shading by the pixel");
    let each = evaluate(&scene(&format("sample")), 7, &Buffers::new(), &settings(|_| ()));
    let apart = |x: i64, y: i64, other: &dyn Fn(usize) -> f64| {
        (0..3).map(|c| (f64::from(sample(&frame.pictures[0], c, x, y)) - other(c)).abs()).fold(0.0, f64::max)
    };
    let pixels = || (0..22).flat_map(|y| (0..40).map(move |x| (x, y)));
    // The picture differs, but only a little.
    let distances = pixels().map(|(x, y)| apart(x, y, &|c| f64::from(sample(&each.pictures[0], c, x, y))));
    let distances: Vec<f64> = distances.collect();
    let changed = distances.iter().filter(|distance| **distance > 0.0).count();
    let furthest = distances.iter().copied().fold(0.0, f64::max);
    assert!(changed > 200 && furthest < 0.2, "{changed} pixels changed, by up to {furthest}");
    let reference = ReferenceFrame::new(&graph, "beauty", 7).unwrap();
    let some: Vec<(i64, i64)> = pixels().step_by(7).collect();
    let missed = some.iter().filter(|(x, y)| {
        let truth = reference.pixel(*x, *y).unwrap();
        apart(*x, *y, &|c| truth[c]) > 4e-3
    });
    // At an edge, rounding decides what a sample sees, and so which value it shares.
    let missed = missed.count();
    assert!(10 * missed < some.len(), "{missed} of {} pixels miss the reference", some.len());
    let certifier = Certifier::new(&graph, &[], 7, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    pixels_are_as_the_whole(&graph, 7, &frame, &certified, "shading by the pixel");
    // A field is taken at the center, whatever the shading.
    assert_eq!(bits(&frame.pictures[1]), bits(&each.pictures[1]));
}

#[test]
fn edges_of_surfaces_are_as_fine_as_the_samples() {
    // A sail of one color before the sky: nothing is shaded, so nothing may change.
    let nodes = r##""camera": { "type": "Camera", "position": [0, 0, 5], "target": [0, 0, 0], "fov": 40 },
        "sail": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-1, -1, 0] }, { "at": [1, -0.7, 0] },
          { "at": [-0.4, 1, 0] }, { "at": [0.9, 0.8, 1] }] }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sail"] },
        "beauty": { "type": "Mix", "a": "#ffffff", "b": "#000000", "weight": "view.coverage" }"##;
    let picture = |shading: &str| {
        let format = format!(r#""width": 64, "height": 64, "samples": 16, "shading": "{shading}""#);
        let graph = graph(&format, nodes, r#""beauty": { "color": "beauty" }"#);
        evaluate(&graph, 1, &Buffers::new(), &settings(|_| ())).pictures[0].planes[0].samples().to_vec()
    };
    let (each, shared) = (picture("sample"), picture("pixel"));
    assert_eq!(each, shared);
    assert!(each.iter().filter(|value| **value > 0.0 && **value < 1.0).count() > 40, "the edge has steps");
}

#[test]
fn what_samples_share_is_mixed_once_before_strokes_with_the_bits_of_each_sample() {
    // Nothing of red is mixed in, but where depends on the place of each sample, so nothing is shared.
    let strokes = |image: &str| {
        format!(
            r#"{{ "type": "Strokes", "image": "{image}", "view": "view",
                 "layers": [{{ "length": 9, "width": 4, "spacing": 5 }}, {{ "length": 4, "width": 2, "spacing": 5 }}] }}"#
        )
    };
    let nodes = format!(
        r##"{NODES},
        "before": {{ "type": "Mix", "a": "#f0d090", "b": "far", "weight": "view.coverage" }},
        "nothing": {{ "type": "FieldMath", "a": "height", "expression": "0 * a" }},
        "never": {{ "type": "Clamp", "field": "nothing", "min": 0, "max": 1 }},
        "across": {{ "type": "ScreenX" }},
        "nowhere": {{ "type": "Multiply", "weights": ["across", "never"] }},
        "again": {{ "type": "Mix", "a": "before", "b": "#ff0000", "weight": "nowhere" }},
        "once": {}, "each": {}"##,
        strokes("before"),
        strokes("again"),
    );
    let format = r#""width": 60, "height": 34, "samples": 4, "shading": "pixel""#;
    let outputs = r#""once": { "color": "once" }, "each": { "color": "each" }"#;
    let frame = under_all_settings(&graph(format, &nodes, outputs), 7, &Buffers::new(), "strokes by the pixel");
    assert_eq!(bits(&frame.pictures[0]), bits(&frame.pictures[1]));
}

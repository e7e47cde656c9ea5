//! Adaptive sampling: pixels around which first samples differ take all samples, others keep the first one.

use crate::support::{bits, evaluate, graph, sample, settings, under_all_settings};
use trochoid::{Buffers, CheckedGraph, Frame, Picture, Switches};

const WIDTH: i64 = 48;
const HEIGHT: i64 = 26;

/// A sea with lines, filters, noise and paint, in which every way to fill a stage is taken.
const NODES: &str = r##""camera": { "type": "Camera", "position": [0, 3, 8], "target": [0, 1.5, 0] },
    "sun": { "type": "Light", "direction": [0.5, 0.6, 1] },
    "waves": { "type": "GerstnerSea", "count": 8, "seed": 3 },
    "sail": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-1, 0, 3] }, { "at": [2, -1, 2] },
        { "at": [0, 3, 3] }, { "at": [1, 2.5, 1] }] }] },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["waves", "sail"] },
    "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "cosine": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
    "toon": { "type": "Clamp", "field": "lit_field", "min": 0.5, "max": 0.52 },
    "lit_field": { "type": "FieldMath", "expression": "a", "a": "cosine" },
    "edges": { "type": "Outline", "view": "view", "width": 1.5 },
    "rims": { "type": "Silhouette", "view": "view", "width": 2 },
    "veins": { "type": "SurfaceLines", "view": "view", "scale": 2 },
    "sail_only": { "type": "ObjectMask", "view": "view", "indices": [1] },
    "lace": { "type": "Noise", "view": "view", "space": "world", "scale": 0.7 },
    "torn": { "type": "Clamp", "field": "lace", "min": 0.1, "max": 0.12 },
    "soft": { "type": "Blur", "image": "torn", "size": 1.5 },
    "right": { "type": "Clamp", "field": "across", "min": 0.5, "max": 0.6 },
    "shades": { "type": "Mix", "a": "#123a5c", "b": "#4080a0", "weight": "toon" },
    "foamy": { "type": "Mix", "a": "shades", "b": "#e8f0f0", "weight": "soft" },
    "veined": { "type": "Mix", "a": "foamy", "b": "#ffffff", "weight": "veins" },
    "part": { "type": "Mix", "a": "shades", "b": "veined", "weight": "right" },
    "both": { "type": "Mix", "a": "part", "b": "#c03020", "weight": "sail_only" },
    "rimmed": { "type": "Mix", "a": "both", "b": "#fff080", "weight": "rims" },
    "inked": { "type": "Mix", "a": "rimmed", "b": "#000000", "weight": "edges" },
    "moved": { "type": "Warp", "image": "inked", "dx": "lace", "reach": 2 },
    "painted": { "type": "Strokes", "image": "inked", "view": "view",
        "layers": [{ "length": 9, "width": 4, "spacing": 5 }] },
    "brushed": { "type": "Mix", "a": "inked", "b": "painted", "weight": "right" },
    "mixed": { "type": "Mix", "a": "brushed", "b": "moved", "weight": "down" },
    "beauty": { "type": "Mix", "a": "#f0d090", "b": "mixed", "weight": "view.coverage" }"##;

const OUTPUTS: &str = r#""beauty": { "color": "beauty" }, "inked": { "color": "inked" }, "toon": { "field": "toon" },
    "lace": { "field": "lace" }"#;

fn scene(samples: u32, shading: &str, tolerance: Option<f32>) -> CheckedGraph {
    let adaptive = tolerance.map(|tolerance| format!(r#", "adaptive": {tolerance}"#)).unwrap_or_default();
    let format =
        format!(r#""width": {WIDTH}, "height": {HEIGHT}, "samples": {samples}, "shading": "{shading}"{adaptive}"#);
    graph(&format, NODES, OUTPUTS)
}

fn picture(samples: u32, shading: &str, tolerance: Option<f32>) -> Frame {
    evaluate(&scene(samples, shading, tolerance), 1, &Buffers::new(), &settings(|_| ()))
}

/// Whether first samples around a pixel differ by more than a tolerance, straight from the definition.
fn differs(first: &Picture, x: i64, y: i64, tolerance: f32) -> bool {
    (0..first.planes.len()).any(|channel| {
        let rows = (y - 1).max(0)..(y + 2).min(HEIGHT);
        let around = rows.flat_map(|y| ((x - 1).max(0)..(x + 2).min(WIDTH)).map(move |x| (x, y)));
        let roots: Vec<f32> = around.map(|(x, y)| sample(first, channel, x, y).sqrt()).collect();
        roots.iter().any(|a| roots.iter().any(|b| a - b > tolerance))
    })
}

#[test]
fn pixels_keep_their_first_sample_where_those_around_are_alike() {
    for (samples, shading) in [(4, "sample"), (4, "pixel"), (16, "sample")] {
        // All values are at most 1, so nothing differs by more.
        let first = picture(samples, shading, Some(1.0));
        let mean = picture(samples, shading, None);
        for tolerance in [0.0, 0.02, 0.2] {
            let what = format!("{samples} samples, shaded by the {shading}, to {tolerance}");
            let graph = scene(samples, shading, Some(tolerance));
            let found = match tolerance == 0.02 && samples == 4 {
                true => under_all_settings(&graph, 1, &Buffers::new(), &what),
                false => evaluate(&graph, 1, &Buffers::new(), &settings(|_| ())),
            };
            let mut kept = 0;
            for (output, picture) in found.pictures.iter().enumerate().take(3) {
                for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
                    let differs = differs(&first.pictures[output], x, y, tolerance);
                    kept += usize::from(!differs);
                    let expected = if differs { &mean.pictures[output] } else { &first.pictures[output] };
                    for channel in 0..picture.planes.len() {
                        let [found, expected] = [picture, expected].map(|from| sample(from, channel, x, y));
                        assert_eq!(found.to_bits(), expected.to_bits(), "{what}: output {output} at {x}, {y}");
                    }
                }
            }
            let all = 3 * (WIDTH * HEIGHT) as usize;
            assert!(tolerance == 0.0 || (kept > all / 10 && kept < all), "{what}: {kept} of {all} keep the first");
            // A field is taken at the center.
            assert_eq!(bits(&found.pictures[3]), bits(&mean.pictures[3]));
        }
    }
}

#[test]
fn the_first_sample_lies_where_the_manual_says() {
    let nodes = r#""across": { "type": "ScreenX" }, "out": { "type": "Clamp", "field": "across", "min": 0, "max": 1 }"#;
    let format = r#""width": 20, "height": 3, "samples": 4, "adaptive": 1"#;
    let graph = graph(format, nodes, r#""out": { "field": "out" }"#);
    let found = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    for x in 0..20 {
        let expected = ((x as f64 + 0.125 - 0.5) / 19.0).clamp(0.0, 1.0);
        assert!((f64::from(sample(&found.pictures[0], 0, x, 1)) - expected).abs() < 1e-6, "{x}");
    }
}

#[test]
fn costly_stages_take_fewer_samples() {
    let filled =
        |frame: &Frame, name: &str| frame.nodes.iter().find(|node| node.name == name).map_or(0, |node| node.pixels);
    let all = (4 * WIDTH * HEIGHT) as u64;
    let nodes = r##""across": { "type": "ScreenX" }, "noise": { "type": "Noise", "scale": 0.3 },
        "half": { "type": "Clamp", "field": "across", "min": 0.5, "max": 0.51 },
        "most": { "type": "Multiply", "weights": ["half", 0.75] },
        "spots": { "type": "Clamp", "field": "noise", "min": 0, "max": 1 },
        "dim": { "type": "Mix", "a": "#204060", "b": "#204061", "weight": "spots" },
        "out": { "type": "Mix", "a": "dim", "b": "#e0d0c0", "weight": "most" }"##;
    let format = |adaptive: &str| format!(r#""width": {WIDTH}, "height": {HEIGHT}, "samples": 4{adaptive}"#);
    let graph = graph(&format(r#", "adaptive": 0.05"#), nodes, r#""out": { "color": "out" }"#);
    let run = |switches: Switches| evaluate(&graph, 1, &Buffers::new(), &settings(|s| s.switches = switches));
    let [sparse, dense] = [true, false].map(|sparse| run(Switches { sparse, ..Switches::ALL }));
    let [sparse, dense] = [&sparse, &dense].map(|frame| filled(frame, "noise"));
    assert!(dense == all && sparse < all / 2 && sparse >= all / 4, "{sparse} and {dense} of {all}");
}

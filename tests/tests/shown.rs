//! Costly stages are filled only where they show; the pictures stay bit-identical.

use crate::support::{evaluate, graph, settings, under_all_settings};
use trochoid::Buffers;

const SIZE: [u64; 2] = [40, 24];

/// Samples, what is shaded, and more keys of formats.
const FORMATS: [(u64, &str, &str); 5] = [
    (1, "sample", ""),
    (4, "sample", ""),
    (4, "pixel", ""),
    (4, "sample", r#", "adaptive": 0.05"#),
    (4, "pixel", r#", "adaptive": 0.05"#),
];

/// Masks that are 0 on one side, 1 on the other, and neither between; noise, and colors that it mixes.
const NODES: &str = r##""across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "most": { "type": "Clamp", "field": "across", "min": 0.3, "max": 0.35 },
    "left": { "type": "Invert", "weight": "most" },
    "right": { "type": "Clamp", "field": "across", "min": 0.6, "max": 0.7 },
    "low": { "type": "Clamp", "field": "down", "min": 0.5, "max": 0.52 },
    "noise": { "type": "Noise", "scale": 0.2 },
    "veins": { "type": "Clamp", "field": "noise", "min": -0.2, "max": 0.3 },
    "other": { "type": "Noise", "scale": 0.1, "seed": 4 },
    "spots": { "type": "Clamp", "field": "other", "min": 0, "max": 0.1 },
    "marble": { "type": "Mix", "a": "#234", "b": "#fed", "weight": "veins" },
    "spotted": { "type": "Mix", "a": "#a41", "b": "#ff8", "weight": "spots" },
    "slope": { "type": "Mix", "a": "#0a2c40", "b": "#e0b070", "weight": "down" },
    "soft": { "type": "Blur", "image": "veins", "size": 5 },
    "moved": { "type": "Warp", "image": "marble", "dx": "noise", "reach": 3 },
    "painted": { "type": "Strokes", "image": "slope", "flow": "along",
        "layers": [{ "length": 16, "width": 5, "spacing": 4 }] },
    "along": { "type": "FlowField", "along": "gradient", "field": "noise", "smooth": 1 }"##;

/// A stage that shows in places only, and the largest share of the picture in which it may be filled.
type Shown = (&'static str, f64);

/// What is tested, nodes, and what of them shows.
const CASES: [(&str, &str, &[Shown]); 8] = [
    (
        "behind a weight of 0",
        r##""out": { "type": "Mix", "a": "#123", "b": "marble", "weight": "right" }"##,
        &[("noise", 0.45)],
    ),
    (
        "behind a weight of 1",
        r##""out": { "type": "Mix", "a": "marble", "b": "#123", "weight": "most" }"##,
        &[("noise", 0.4)],
    ),
    (
        "strokes within a window, and what they alone read everywhere",
        r##""out": { "type": "Mix", "a": "#123", "b": "painted", "weight": "right" }"##,
        &[("painted", 0.5)],
    ),
    (
        "filters",
        r##""both": { "type": "Mix", "a": "moved", "b": "#fff", "weight": "soft" },
            "out": { "type": "Mix", "a": "#123", "b": "both", "weight": "right" }"##,
        &[("moved", 0.45), ("soft", 0.45)],
    ),
    (
        "what decides shows in places only itself",
        r##""within": { "type": "Multiply", "weights": ["right", "spots"] },
            "out": { "type": "Mix", "a": "#123", "b": "painted", "weight": "within" }"##,
        &[("other", 0.45), ("painted", 0.5)],
    ),
    (
        "one behind the other, and beside it",
        r##""inner": { "type": "Mix", "a": "marble", "b": "spotted", "weight": "low" },
            "out": { "type": "Mix", "a": "inner", "b": "#123", "weight": "right" }"##,
        &[("noise", 0.6), ("other", 0.6)],
    ),
    (
        "parts of a blend",
        r##""parts": { "type": "Bands", "field": "across", "thresholds": [0.4, 0.8] },
            "out": { "type": "Blend", "colors": ["marble", "spotted", "painted"], "weights": "parts" }"##,
        &[("noise", 1.0), ("other", 1.0), ("painted", 1.0)],
    ),
    (
        "shown on either side",
        r##""one": { "type": "Mix", "a": "#123", "b": "marble", "weight": "right" },
            "out": { "type": "Mix", "a": "one", "b": "marble", "weight": "left" }"##,
        &[("noise", 1.0)],
    ),
];

#[test]
fn costly_stages_are_filled_only_where_they_show() {
    for (samples, shading, more) in FORMATS {
        let [width, height] = SIZE;
        let format =
            format!(r#""width": {width}, "height": {height}, "samples": {samples}, "shading": "{shading}"{more}"#);
        for (what, out, shown) in CASES {
            let graph = graph(&format, &format!("{NODES},\n{out}"), r#""out": { "color": "out" }"#);
            let what = format!("{what}, {samples} samples, shading by the {shading}{more}");
            let frame = under_all_settings(&graph, 1, &Buffers::new(), &what);
            assert_eq!(frame.pictures[0].audit.hull_exits, 0, "{what}");
            let everywhere = evaluate(&graph, 1, &Buffers::new(), &settings(|s| s.switches.demand = false));
            let filled = |frame: &trochoid::Frame, name: &str| {
                frame.nodes.iter().find(|report| report.name == name).unwrap().pixels
            };
            for (name, most) in shown {
                let all = width * height * samples;
                assert_eq!(filled(&everywhere, name), all, "{what}: {name} without demand");
                // Samples that share results are filled everywhere.
                let most = if shading == "pixel" { all } else { (all as f64 * most) as u64 };
                let found = filled(&frame, name);
                assert!(found <= most && found > 0, "{what}: {name} filled at {found} samples of {all}");
            }
        }
    }
}

#[test]
fn lines_of_a_view_are_drawn_only_where_they_show() {
    let nodes = r##""camera": { "type": "Camera", "position": [0, 3, 8], "target": [0, 0, 0] },
        "sea": { "type": "GerstnerSea", "count": 6, "seed": 3 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "across": { "type": "ScreenX" },
        "right": { "type": "Clamp", "field": "across", "min": 0.6, "max": 0.7 },
        "edges": { "type": "Outline", "view": "view", "width": 2, "depth_step": 0.02 },
        "rims": { "type": "Silhouette", "view": "view", "width": 2 },
        "veins": { "type": "SurfaceLines", "view": "view", "scale": 2 },
        "drawn": { "type": "Mix", "a": "#def", "b": "#012", "weight": "edges" },
        "rimmed": { "type": "Mix", "a": "drawn", "b": "#950", "weight": "rims" },
        "veined": { "type": "Mix", "a": "rimmed", "b": "#fff", "weight": "veins" },
        "out": { "type": "Mix", "a": "#468", "b": "veined", "weight": "right" }"##;
    for (samples, shading, more) in FORMATS {
        let format = format!(r#""width": 60, "height": 32, "samples": {samples}, "shading": "{shading}"{more}"#);
        let graph = graph(&format, nodes, r#""out": { "color": "out" }"#);
        let frame = under_all_settings(&graph, 1, &Buffers::new(), &format);
        for name in ["edges", "rims", "veins"] {
            let filled = frame.nodes.iter().find(|report| report.name == name).unwrap().pixels;
            let most = if shading == "pixel" { 60 * 32 * samples } else { 60 * 32 * samples / 2 };
            assert!(filled <= most, "{format}: {name} filled at {filled} samples");
        }
    }
}

#[test]
fn a_view_behind_another_one_is_filled_only_where_it_shows() {
    let nodes = r##""camera": { "type": "Camera", "position": [0, 3, 8], "target": [0, 3, 0] },
        "above": { "type": "Camera", "position": [0, 20, 0.5], "target": [0, 0, 0] },
        "sun": { "type": "Light", "direction": [0.8, 0.36, -0.05] },
        "sea": { "type": "GerstnerSea", "count": 6, "seed": 3 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "deck": { "type": "Render", "camera": "above", "surfaces": ["sea"] },
        "height": { "type": "Height", "view": "deck" },
        "tall": { "type": "Clamp", "field": "height", "min": -0.5, "max": 0.5 },
        "cosine": { "type": "NonSpecular", "view": "deck", "lights": ["sun"] },
        "bright": { "type": "Clamp", "field": "cosine", "min": 0.2, "max": 0.9, "power": 1.5 },
        "glint": { "type": "Specular", "view": "deck", "lights": ["sun"], "shininess": 40 },
        "skin": { "type": "Fresnel", "view": "deck" },
        "far": { "type": "Depth", "view": "deck" },
        "near": { "type": "Clamp", "field": "far", "min": 15, "max": 22 },
        "clouds": { "type": "Mix", "a": "#234", "b": "#fed", "weight": "tall" },
        "lit": { "type": "Mix", "a": "clouds", "b": "#fa8", "weight": "bright" },
        "gilded": { "type": "Mix", "a": "lit", "b": "#fff", "weight": "glint" },
        "veiled": { "type": "Mix", "a": "gilded", "b": "#88a", "weight": "skin" },
        "sky": { "type": "Mix", "a": "veiled", "b": "#012", "weight": "near" },
        "out": { "type": "Mix", "a": "sky", "b": "#0a2c40", "weight": "view.coverage" }"##;
    for (samples, shading, more) in FORMATS {
        let [width, height] = [60, 32];
        let format =
            format!(r#""width": {width}, "height": {height}, "samples": {samples}, "shading": "{shading}"{more}"#);
        let graph = graph(&format, nodes, r#""out": { "color": "out" }"#);
        let frame = under_all_settings(&graph, 1, &Buffers::new(), &format);
        assert_eq!(frame.pictures[0].audit.hull_exits, 0, "{format}");
        let filled = |name: &str| frame.nodes.iter().find(|report| report.name == name).unwrap().pixels;
        let all = width * height * samples;
        let is_adaptive = !more.is_empty();
        assert!(is_adaptive || filled("view") >= all, "{format}: the view that decides is filled everywhere");
        let found = filled("deck");
        if shading == "sample" {
            assert!(found > 0 && found < all * 2 / 3, "{format}: deck filled at {found} samples of {all}");
        }
    }
}

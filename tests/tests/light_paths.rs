//! Light paths from visible points: thickness, transmitted light, and shadows, in mild and in hostile scenes.

use crate::support::{all_bits, evaluate, graph, sample, settings, state, under_all_settings};
use trochoid::{Buffers, CheckedGraph, ReferenceFrame, State};

const OUTPUTS: &str = r#""thick": { "field": "thick" }, "behind": { "field": "behind" },
    "glow": { "weights": "glow" }, "shade": { "weights": "shade" }, "soft": { "weights": "soft" }"#;

/// Returns all passes of some surfaces, seen from a point, in light from a direction.
fn scene(size: [u32; 2], eye: &str, light: &str, surfaces: &[&str]) -> CheckedGraph {
    let names: Vec<String> = (0..surfaces.len()).map(|index| format!("s{index}")).collect();
    let nodes: Vec<String> = names.iter().zip(surfaces).map(|(name, node)| format!(r#""{name}": {node}"#)).collect();
    graph(
        &format!(r#""width": {}, "height": {}"#, size[0], size[1]),
        &format!(
            r#""camera": {{ "type": "Camera", {eye} }}, "sun": {{ "type": "Light", {light} }},
            "lamp": {{ "type": "Light", "kind": "spot", "position": [3, 8, 4], "angle": 60 }}, {},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": [{}] }},
            "thick": {{ "type": "Thickness", "view": "view", "light": "sun" }},
            "behind": {{ "type": "Thickness", "view": "view", "ray": "eye", "beyond": 0, "distance": 7 }},
            "glow": {{ "type": "Translucency", "view": "view", "lights": ["sun", "lamp"] }},
            "shade": {{ "type": "Shadow", "view": "view", "lights": ["sun"] }},
            "soft": {{ "type": "Shadow", "view": "view", "lights": ["lamp", "sun"], "size": 8, "rays": 3 }}"#,
            nodes.join(", "),
            names.iter().map(|name| format!(r#""{name}""#)).collect::<Vec<_>>().join(", "),
        ),
        OUTPUTS,
    )
}

const ABOVE: &str = r#""position": [0, 5, 14], "target": [0, 1, 0]"#;
const MILD: &str = r#"{ "type": "GerstnerSea", "count": 6, "wavelength": 9, "spread": 0.2, "height": 1.5 }"#;
const SHEET: &str = r#"{ "type": "BezierModel", "patches": [{ "points": [{ "at": [-3, 0, 2] }, { "at": [3, 0, 2] },
    { "at": [-3, 4, -2] }, { "at": [3, 5, -1] }] }] }"#;

#[test]
fn passes_agree_with_the_continuous_surfaces() {
    let cases = [
        scene([24, 14], ABOVE, r#""direction": [0.3, 0.5, -1]"#, &[MILD]),
        scene([24, 14], ABOVE, r#""direction": [-0.8, 0.4, 0.2]"#, &[SHEET, MILD]),
        scene([24, 14], ABOVE, r#""direction": [0.3, -0.6, -1]"#, &[MILD]),
    ];
    for (number, graph) in cases.iter().enumerate() {
        let frame = evaluate(graph, 1, &Buffers::new(), &settings(|s| s.threads = 2));
        for picture in &frame.pictures {
            let name = &graph.outputs()[picture.output].name;
            let reference = ReferenceFrame::new(graph, name, 1).unwrap();
            let (mut off, mut count) = (Vec::new(), 0);
            for index in 0..48 {
                let (x, y) = ((index * 37 + 5) % 24, (index * 5 + 3) % 14);
                let (found, truth) = (f64::from(sample(picture, 0, x, y)), reference.pixel(x, y).unwrap()[0]);
                count += 1;
                // Lengths are in meters; masks range from 0 to 1.
                let tolerance = if name == "thick" || name == "behind" { 0.05 + 0.02 * truth } else { 0.02 };
                if (found - truth).abs() > tolerance {
                    off.push((x, y, found, truth));
                }
            }
            // Near edges, rounding decides what a ray meets.
            assert!(off.len() * 8 <= count, "case {number}, {name}: {} of {count} differ: {off:?}", off.len());
        }
    }
}

#[test]
fn hostile_scenes_stay_in_range_and_keep_their_bits() {
    let wild = r#"{ "type": "GerstnerSea", "count": 40, "wavelength": 5, "height": 6, "sharpness": 10, "spread": 1 }"#;
    let flat = r#"{ "type": "GerstnerSea", "count": 0 }"#;
    let toon = r#"{ "type": "ToonSea", "columns": 32, "rows": 32, "preroll": 4,
        "bursts": [{ "path": [0, 0, 2, 1, 3, 3, 1, 4], "height": 9 }] }"#;
    let cases = [
        scene([7, 5], ABOVE, r#""direction": [0, 0, -1]"#, &[wild]),
        scene([7, 5], ABOVE, r#""direction": [1, -0.001, 0]"#, &[flat]),
        scene([7, 5], r#""position": [0, -3, 9], "target": [0, 0, 0]"#, r#""direction": [0, 1, 0]"#, &[MILD, SHEET]),
        scene([7, 5], r#""position": [0, 5, 9], "target": [0, 90, 0]"#, r#""direction": [0, -1, 0]"#, &[wild]),
        scene([7, 5], r#""position": [1e6, 3, -1e6], "target": [1e6, 0, 0]"#, r#""direction": [0, 0.1, 1]"#, &[wild]),
        scene([7, 5], r#""projection": "orthographic", "height": 9"#, r#""direction": [1, 0, 0]"#, &[toon, SHEET]),
    ];
    for (number, graph) in cases.iter().enumerate() {
        let frame = under_all_settings(graph, 1, &Buffers::new(), &format!("case {number}"));
        for picture in &frame.pictures {
            let name = &graph.outputs()[picture.output].name;
            let most = match name.as_str() {
                "thick" => 50.0,
                "behind" => 7.0,
                _ => 1.0,
            };
            for value in picture.planes[0].samples() {
                assert!((0.0..=most).contains(value), "case {number}: {name} holds {value}");
            }
        }
    }
}

#[test]
fn a_light_below_the_horizon_leaves_the_sea_in_shadow() {
    let graph = scene([16, 9], r#""position": [0, 30, 1], "target": [0, 0, 0]"#, r#""direction": [0, -1, 0]"#, &[MILD]);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    let all = |output: &str, value: f32| {
        let picture = frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == output).unwrap();
        assert!(picture.planes[0].samples().iter().all(|found| *found == value), "{output}");
    };
    all("shade", 1.0);
    all("thick", 50.0);
}

#[test]
fn a_view_of_passes_alone_is_refused() {
    for (ty, output) in [("Shadow", "weights"), ("Translucency", "weights"), ("Thickness", "field")] {
        let lights = if ty == "Thickness" { "" } else { r#", "lights": ["sun"]"# };
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 2, "height": 2 }}, "nodes": {{
            "camera": {{ "type": "Camera" }}, "sun": {{ "type": "Light" }},
            "view": {{ "type": "ViewFromPasses", "file": "a.exr", "depth": "depth.Z", "normal": "N", "position": "P",
                "camera": "camera" }},
            "out": {{ "type": "{ty}", "view": "view"{lights} }} }},
            "outputs": {{ "out": {{ "{output}": "out" }} }} }}"#
        );
        let error = trochoid::parse("test.json", &text, std::path::Path::new("."), &[]).unwrap_err().to_string();
        assert!(error.contains("a view of passes") && error.contains("connect a Render"), "{error}");
    }
}

/// A sea whose clouds, shadows and glow are weighted by `weight`.
fn weighted(weight: &str, nodes: &str, sky: &str, water: &str) -> CheckedGraph {
    graph(
        r#""width": 24, "height": 14"#,
        &format!(
            r##""camera": {{ "type": "Camera", {ABOVE} }}, "sun": {{ "type": "Light", "direction": [0.3, 0.4, -1] }},
            "s": {MILD}, "view": {{ "type": "Render", "camera": "camera", "surfaces": ["s"] }},
            "across": {{ "type": "ScreenX" }}, "light": {{ "type": "NonSpecular", "view": "view", "lights": ["sun"] }},
            "clear": {{ "type": "Mix", "a": "#abc", "b": "#fed", "weight": "across" }},
            "deep": {{ "type": "Mix", "a": "#012", "b": "#245", "weight": "light" }}, {nodes}
            "out": {{ "type": "Mix", "a": "{sky}", "b": "{water}", "weight": "view.coverage" }}"##
        )
        .replace("WEIGHT", weight),
        r#""out": { "color": "out" }"#,
    )
}

#[test]
fn passes_without_weight_are_not_computed_and_change_no_bit() {
    let nodes = r##"
        "clouds": { "type": "Clouds", "camera": "camera", "light": "sun", "layers": [{ "cover": 0.8 }] },
        "shade": { "type": "Shadow", "view": "view", "lights": ["sun"] },
        "thick": { "type": "Thickness", "view": "view", "light": "sun" },
        "glow": { "type": "Translucency", "view": "view", "lights": ["sun"] },
        "thin": { "type": "Clamp", "field": "thick", "min": 9, "max": 10 },
        "veil": { "type": "Multiply", "weights": ["clouds", WEIGHT] },
        "shaded": { "type": "Multiply", "weights": ["shade", WEIGHT, "thin"] },
        "glowing": { "type": "Multiply", "weights": ["glow", WEIGHT] },
        "puff": { "type": "Mix", "a": "#556", "b": "#fff", "weight": "clouds.light" },
        "sky": { "type": "Mix", "a": "clear", "b": "puff", "weight": "veil" },
        "dim": { "type": "Mix", "a": "deep", "b": "#000", "weight": "shaded" },
        "water": { "type": "Mix", "a": "dim", "b": "#7c9", "weight": "glowing" },"##;
    let render = |graph: &CheckedGraph| evaluate(graph, 1, &Buffers::new(), &settings(|_| ()));
    let without = render(&weighted("0", "", "clear", "deep"));
    let weightless = weighted("0", nodes, "sky", "water");
    let frame = render(&weightless);
    assert_eq!(all_bits(&frame), all_bits(&without));
    for node in ["clouds", "shade", "thick", "glow"] {
        assert!(matches!(state(&frame, node), State::LeftOut(_)), "{node}: {:?}", state(&frame, node));
    }
    under_all_settings(&weightless, 1, &Buffers::new(), "without weight");
    let heavy = render(&weighted("1", nodes, "sky", "water"));
    assert_ne!(all_bits(&heavy), all_bits(&without));
    for node in ["clouds", "shade", "thick", "glow"] {
        assert_eq!(*state(&heavy, node), State::Evaluated, "{node}");
    }
}

#[test]
fn the_wind_carries_clouds_along() {
    let seen_from = |x: f64| {
        let nodes = format!(
            r#""camera": {{ "type": "Camera", "position": [{x}, 0, 0], "target": [{x}, 30, -60] }},
            "sun": {{ "type": "Light", "direction": [0.3, 0.4, -1] }},
            "clouds": {{ "type": "Clouds", "camera": "camera", "light": "sun", "layers": [
                {{ "height": 300, "scale": 200, "speed": 48 }}, {{ "scale": 500, "stretch": 3, "speed": 48 }}] }}"#
        );
        let outputs = r#""density": { "weights": "clouds" }, "light": { "weights": "clouds.light" }"#;
        graph(r#""width": 24, "height": 14"#, &nodes, outputs)
    };
    let render = |graph: &CheckedGraph, frame: i64| evaluate(graph, frame, &Buffers::new(), &settings(|_| ()));
    // After one second the clouds are 48 m ahead: a camera 48 m behind sees the same at the start.
    let (start, later, behind) =
        (render(&seen_from(0.0), 1), render(&seen_from(0.0), 25), render(&seen_from(-48.0), 1));
    assert_ne!(all_bits(&start), all_bits(&later));
    let planes = |frame: &trochoid::Frame| -> Vec<(f32, f32)> {
        let samples = |picture: usize| frame.pictures[picture].planes[0].samples().to_vec();
        samples(0).into_iter().zip(samples(1)).collect()
    };
    for ((density, light), (same, lit)) in planes(&later).into_iter().zip(planes(&behind)) {
        assert!((density - same).abs() < 1e-3, "{density}, expected {same}");
        // Where the density is nearly 0, the light is a quotient of two tiny numbers, so the products are compared.
        assert!((density * light - same * lit).abs() < 1e-3, "{light}, expected {lit}");
    }
}

//! Strokes: bit-identical results for all tiles, weights that do not depend on colors, preserved edges, and seeds that
//! stay on the water.

use crate::support::{all_bits, evaluate, graph, sample, settings, under_all_settings};
use trochoid::{Buffers, CheckedGraph, Format, Picture, ReferenceFrame, Window};

const FORMAT: &str = r#""width": 56, "height": 40"#;

/// A hilly sea before a sky; `{A}`, `{B}` and `{C}` stand for control colors.
const SEA: &str = r##"
    "camera": { "type": "Camera", "position": [0, 4, 0], "target": [0, 3, -10], "fov": 60 },
    "sea": { "type": "GerstnerSea", "count": 12, "wavelength": 12, "height": 3, "seed": 3 },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "light": { "type": "NonSpecular", "view": "view", "lights": [{LIGHT}] },
    "sun": { "type": "Light", "direction": [1, 0.4, 0.2] },
    "depth": { "type": "Depth", "view": "view" },
    "near": { "type": "FieldMath", "a": "depth", "expression": "if(a > 1e5, 1, 12/a)" },
    "nearness": { "type": "Clamp", "field": "near", "min": 0, "max": 1 },
    "flow": { "type": "FlowField", "view": "view", "turn": 20, "steep": 0.2, "still": -20, "waver": 30, "smooth": 1 },
    "lit": { "type": "Mix", "a": {A}, "b": {B}, "weight": "light" },
    "image": { "type": "Mix", "a": {C}, "b": "lit", "weight": "view.coverage" },
    "over": { "type": "Stack", "weights": ["uncovered", "dark"] },
    "uncovered": { "type": "Invert", "weight": "view.coverage" },
    "dark": { "type": "Invert", "weight": "light" }"##;

const STROKES: &str = r#""type": "Strokes", "view": "view", "flow": "flow", "size": "nearness", "detail": 0.25,
    "layers": [
    { "length": 12, "width": 5, "spacing": 5.5, "turn": 30 },
    { "length": 14, "width": 4, "spacing": 4, "stray": 3 },
    { "length": 9, "width": 2.5, "spacing": 3, "opacity": 1, "turn": 40 },
    { "length": 5, "width": 1, "spacing": 2.5, "bristle": 0.2 }]"#;

fn sea(colors: [&str; 3], lost: f64) -> CheckedGraph {
    let [a, b, c] = colors;
    let nodes = SEA.replace("{LIGHT}", "\"sun\"").replace("{A}", a).replace("{B}", b).replace("{C}", c);
    let nodes = format!(
        r#"{nodes}, "painted": {{ "image": "image", "lost": {lost}, {STROKES} }},
        "weights": {{ "image": "over", "lost": {lost}, {STROKES} }}"#
    );
    let outputs =
        r#""painted": { "color": "painted" }, "image": { "color": "image" }, "weights": { "weights": "weights" }"#;
    graph(FORMAT, &nodes, outputs)
}

const COLORS: [&str; 3] = ["[0, 0.125, 0.25]", "[1, 0.75, 0.5]", "[0.25, 0.5, 1]"];

fn picture<'f>(graph: &CheckedGraph, frame: &'f trochoid::Frame, output: &str) -> &'f Picture {
    frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == output).unwrap()
}

fn pixels(picture: &Picture) -> impl Iterator<Item = (i64, i64)> {
    let window = picture.planes[0].window();
    (window.y0..window.y1).flat_map(move |y| (window.x0..window.x1).map(move |x| (x, y)))
}

#[test]
fn strokes_have_the_same_bits_in_any_tiles() {
    let graph = sea(COLORS, 0.5);
    let plain = settings(|s| s.tile = Some((1 << 20, 1 << 20)));
    // The last is painted in several parts even where it is one tile.
    for (width, height, samples) in [(56, 40, 1), (56, 40, 4), (150, 80, 1)] {
        let graph = graph.clone().with_format(Format::new(width, height, samples).unwrap());
        let whole = evaluate(&graph, 5, &Buffers::new(), &plain);
        assert!(whole.pictures.iter().all(|picture| picture.audit.hull_exits + picture.audit.nan_count == 0));
        for (threads, tile) in [(1, (9, 7)), (2, (16, 16)), (3, (56, 3))] {
            let tiled =
                evaluate(&graph, 5, &Buffers::new(), &settings(|s| (s.threads, s.tile) = (threads, Some(tile))));
            assert!(all_bits(&tiled) == all_bits(&whole), "tiles of {tile:?}, {width} × {height}, {samples} samples");
        }
    }
    let region = Window::new(20, 15, 33, 24);
    let part = evaluate(&graph, 5, &Buffers::new(), &settings(|s| s.region = Some(region)));
    let whole = evaluate(&graph, 5, &Buffers::new(), &plain);
    for (part, whole) in part.pictures.iter().zip(&whole.pictures) {
        for (x, y) in pixels(part) {
            assert_eq!(sample(part, 0, x, y).to_bits(), sample(whole, 0, x, y).to_bits(), "({x}, {y})");
        }
    }
}

#[test]
fn strokes_have_the_same_bits_under_all_settings() {
    let graph = sea(COLORS, 0.5).with_format(Format::new(36, 26, 1).unwrap());
    let frame = under_all_settings(&graph, 2, &Buffers::new(), "strokes");
    let [painted, image] = ["painted", "image"].map(|output| picture(&graph, &frame, output));
    let moved = pixels(painted).filter(|(x, y)| sample(painted, 0, *x, *y) != sample(image, 0, *x, *y)).count();
    assert!(moved > 60, "strokes change only {moved} pixels");
}

#[test]
fn painted_colors_are_the_weights_of_strokes_times_the_control_colors() {
    for (colors, controls) in [
        (COLORS, [[0.0, 0.125, 0.25], [1.0, 0.75, 0.5], [0.25, 0.5, 1.0]]),
        (["[1, 0, 0.5]", "[0, 0.25, 1]", "[0.0625, 1, 0]"], [[1.0, 0.0, 0.5], [0.0, 0.25, 1.0], [0.0625, 1.0, 0.0]]),
    ] {
        let graph = sea(colors, 0.4);
        let frame = evaluate(&graph, 3, &Buffers::new(), &settings(|_| ()));
        let [painted, weights] = ["painted", "weights"].map(|output| picture(&graph, &frame, output));
        for (x, y) in pixels(painted) {
            // Weights of the sky, of the dark color, and what is left for the bright one.
            let [sky, dark, bright] = [0, 1, 2].map(|way| f64::from(sample(weights, way, x, y)));
            assert!((sky + dark + bright - 1.0).abs() < 1e-6);
            for channel in 0..3 {
                let [a, b, c] = controls.map(|color: [f64; 3]| color[channel]);
                let expected = dark * a + bright * b + sky * c;
                let found = f64::from(sample(painted, channel, x, y));
                assert!((found - expected).abs() < 1e-6, "({x}, {y}): {found}, the weights say {expected}");
            }
        }
    }
}

#[test]
fn the_reference_paints_the_same() {
    // The sea is flat, because the reference follows the formula of the waves and the fast path triangles.
    let nodes = SEA.replace("\"count\": 12", "\"count\": 0").replace("{LIGHT}", "\"sun\"");
    let nodes = nodes.replace("{A}", COLORS[0]).replace("{B}", "\"across\"").replace("{C}", COLORS[2]);
    let nodes = format!(
        r#"{nodes}, "x": {{ "type": "ScreenX" }},
        "across": {{ "type": "Mix", "a": [1, 0, 0], "b": [0, 1, 0], "weight": "x" }},
        "painted": {{ "image": "image", "lost": 0.5, {STROKES} }}"#
    );
    let graph = graph(FORMAT, &nodes, r#""painted": { "color": "painted" }"#);
    // Each sample of a pixel paints what lies under the pixel anew.
    for (samples, pixels) in [(1, &[(3, 35), (20, 22), (40, 30), (50, 5)][..]), (4, &[(20, 22)])] {
        let graph = graph.clone().with_format(Format::new(56, 40, samples).unwrap());
        let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
        let reference = ReferenceFrame::new(&graph, "painted", 1).unwrap();
        for &(x, y) in pixels {
            for (channel, truth) in reference.pixel(x, y).unwrap().into_iter().enumerate() {
                let found = f64::from(sample(&frame.pictures[0], channel, x, y));
                assert!((found - truth).abs() < 1e-3, "({x}, {y}), channel {channel}: {found}, expected {truth}");
            }
        }
    }
}

#[test]
fn a_density_in_each_layer_equals_that_density_at_the_port() {
    let strokes = |density: &str, first: &str, last: &str| {
        format!(
            r##"{{ "type": "Strokes", "image": "x", "density": {density}, "layers": [
                {{ "length": 9, "width": 4, "spacing": 6, "density": {first} }},
                {{ "length": 6, "width": 2, "spacing": 3, "density": {last} }}] }}"##
        )
    };
    let nodes = format!(
        r#""x": {{ "type": "ScreenX" }}, "port": {}, "layers": {}, "full": {}, "coarse": {}"#,
        strokes("0.5", "1", "1"),
        strokes("1", "0.5", "0.5"),
        strokes("1", "1", "1"),
        strokes("1", "1", "0")
    );
    let outputs = ["port", "layers", "full", "coarse"].map(|name| format!(r#""{name}": {{ "weights": "{name}" }}"#));
    let graph = graph(FORMAT, &nodes, &outputs.join(", "));
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    let [port, layers, full, coarse] = ["port", "layers", "full", "coarse"].map(|name| picture(&graph, &frame, name));
    let differ =
        |a: &Picture, b: &Picture| pixels(a).filter(|(x, y)| sample(a, 0, *x, *y) != sample(b, 0, *x, *y)).count();
    assert_eq!(differ(port, layers), 0, "half of each layer is half of all");
    assert!(differ(full, layers) > 200, "half the strokes change only {} pixels", differ(full, layers));
    assert!(differ(full, coarse) > 200 && differ(layers, coarse) > 200, "each layer has a density of its own");
}

#[test]
fn a_draft_has_the_strokes_of_the_whole_picture() {
    let strokes = |height: &str, figures: [f64; 4]| {
        let [length, width, spacing, stray] = figures;
        let nodes = format!(
            r##""x": {{ "type": "ScreenX" }}, "t": {{ "type": "Clamp", "field": "x", "min": 0, "max": 1 }},
            "image": {{ "type": "Mix", "a": "#102030", "b": "#f0c080", "weight": "t" }},
            "painted": {{ "type": "Strokes", "image": "image", {height} "layers": [
              {{ "length": {length}, "width": {width}, "spacing": {spacing}, "stray": {stray} }}] }}"##
        );
        let graph = graph(FORMAT, &nodes, r#""painted": { "color": "painted" }"#);
        all_bits(&evaluate(&graph, 1, &Buffers::new(), &settings(|_| ())))
    };
    let own = strokes("", [12.0, 4.0, 5.0, 1.0]);
    assert_eq!(own, strokes(r#""height": 40,"#, [12.0, 4.0, 5.0, 1.0]));
    assert_eq!(own, strokes(r#""height": 160,"#, [48.0, 16.0, 20.0, 4.0]));
    assert_ne!(own, strokes(r#""height": 160,"#, [12.0, 4.0, 5.0, 1.0]));
}

#[test]
fn no_stroke_that_keeps_to_edges_crosses_one() {
    // Sea and sky have one color each, so strokes that stay on their side change nothing.
    let kept = sea(["[1, 0, 0]", "[1, 0, 0]", "[0, 0, 1]"], 0.0);
    let frame = evaluate(&kept, 7, &Buffers::new(), &settings(|_| ()));
    let [painted, image] = ["painted", "image"].map(|output| picture(&kept, &frame, output));
    assert!(pixels(image).any(|(x, y)| sample(image, 0, x, y) == 0.0), "there is no sky");
    for (x, y) in pixels(painted) {
        assert_eq!(sample(painted, 0, x, y), sample(image, 0, x, y), "({x}, {y})");
    }
    let lost = sea(["[1, 0, 0]", "[1, 0, 0]", "[0, 0, 1]"], 1.0);
    let frame = evaluate(&lost, 7, &Buffers::new(), &settings(|_| ()));
    let [painted, image] = ["painted", "image"].map(|output| picture(&lost, &frame, output));
    let crossed = pixels(painted).filter(|(x, y)| sample(painted, 0, *x, *y) != sample(image, 0, *x, *y)).count();
    assert!(crossed > 30, "lost edges are crossed at only {crossed} pixels");
}

#[test]
fn strokes_move_with_the_water_and_not_with_the_picture() {
    // A camera that looks straight down moves by 3 pixels per frame over still water.
    let nodes = |anchor: &str| {
        format!(
            r##""camera": {{ "type": "Camera", "projection": "orthographic", "height": 40, "fov": 60,
                "position": {{ "keys": [[1, [0, 50, 0]], [5, [12, 50, 0]]] }},
                "target": {{ "keys": [[1, [0, 0, 0]], [5, [12, 0, 0]]] }} }},
            "sea": {{ "type": "GerstnerSea", "count": 0 }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
            "noise": {{ "type": "Noise", "view": "view", "space": "rest", "scale": 12, "filter": false }},
            "mask": {{ "type": "Clamp", "field": "noise", "min": -0.5, "max": 0.5 }},
            "image": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "mask" }},
            "out": {{ "type": "Strokes", "image": "image", "view": "view", "anchor": "{anchor}", "layers": [
                {{ "length": 10, "width": 4, "spacing": 5.5 }},
                {{ "length": 5, "width": 2, "spacing": 3, "stray": 2 }}] }}"##
        )
    };
    let difference = |anchor: &str, output: &str| {
        let graph = graph(FORMAT, &nodes(anchor), &format!(r#""out": {{ "color": "{output}" }}"#));
        let [before, after] = [2, 3].map(|frame| evaluate(&graph, frame, &Buffers::new(), &settings(|_| ())));
        let (before, after) = (&before.pictures[0], &after.pictures[0]);
        let (mut sum, mut count) = (0.0, 0);
        // Far from the border, where strokes come and go.
        for (x, y) in (16..38).flat_map(|x| (16..24).map(move |y| (x, y))) {
            sum += f64::from((sample(before, 0, x + 3, y) - sample(after, 0, x, y)).abs());
            count += 1;
        }
        sum / f64::from(count)
    };
    let (bare, rest, screen) = (difference("rest", "image"), difference("rest", "out"), difference("screen", "out"));
    assert!(bare < 1e-4, "the image itself moves by 3 pixels a frame: {bare}");
    assert!(rest < 1e-3, "strokes on the water change by {rest}");
    assert!(screen > 10.0 * rest.max(1e-4), "strokes on the picture change by only {screen}");
}

/// Returns the area that hooks cover at a frame, in pixels.
fn hooked(graph: &CheckedGraph, frame: i64) -> f64 {
    let frame = evaluate(graph, frame, &Buffers::new(), &settings(|_| ()));
    let window = graph.format().window();
    let places = (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| (x, y)));
    places.map(|(x, y)| f64::from(sample(&frame.pictures[0], 0, x, y))).sum()
}

#[test]
fn hooks_grow_and_shrink_without_jumps() {
    // The sheet turns by a degree per frame, away from the camera and back.
    let nodes = r#"
        "camera": { "type": "Camera", "position": [0, 0, 20], "target": [0, 0, 0], "projection": "orthographic", "height": 8 },
        "sheet": { "type": "BezierModel", "rotate": { "keys": [[1, [0, 0, 0]], [181, [180, 0, 0]]] }, "rails": [
            { "points": [{ "at": [-4, 2, 0] }, { "at": [0, 2.5, 0] }, { "at": [4, 2, 0] }] },
            { "points": [{ "at": [-4, -2, 0] }, { "at": [0, -2.5, 0] }, { "at": [4, -2, 0] }] }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sheet"] },
        "hooks": { "type": "Hooks", "view": "view", "rows": [
            { "from": [0.1, 0.5], "to": [0.9, 0.5], "count": 5, "length": 2, "width": 0.8, "thumbs": 2 }] }"#;
    let graph = graph(FORMAT, nodes, r#""mask": { "weights": "hooks.mask" }"#);
    let covered: Vec<f64> = (55..=127).map(|frame| hooked(&graph, frame)).collect();
    let most = covered.iter().copied().fold(0.0, f64::max);
    assert!(most > 25.0, "{most} pixels");
    assert_eq!(covered[91 - 55], 0.0, "the sheet is seen from its edge");
    for (step, pair) in covered.windows(2).enumerate() {
        assert!((pair[0] - pair[1]).abs() < 0.25 * most, "{pair:?} of {most} at {} degrees", step + 54);
    }
}

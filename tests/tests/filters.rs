//! Filters: their results do not depend on tiles, threads, regions or switches, respect the border of the image, and
//! stay in the hull.

use crate::support::{all_bits, evaluate, graph, graph_in, sample, settings, under_all_settings, write_exr};
use std::path::Path;
use trochoid::io::{ExrChannel, ExrImage, Samples};
use trochoid::{Buffers, CheckedGraph, Format, Frame, Plan, ReferenceFrame, Switches, Window};

const FORMAT: &str = r#""width": 23, "height": 17"#;

/// Filters of filters, before and after pointwise nodes, of every kind of value.
const CHAINS: &str = r##"
    "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
    "t": { "type": "Clamp", "field": "x", "min": 0.3, "max": 0.55 },
    "u": { "type": "Clamp", "field": "y", "min": 0.7, "max": 0.7 },
    "spot": { "type": "Multiply", "weights": ["t", "u"] },
    "paint": { "type": "Mix", "a": "#102030", "b": "#f0e0a0", "weight": "spot" },
    "soft": { "type": "Blur", "image": "paint", "size": 1.25 },
    "bent": { "type": "Warp", "image": "soft", "dx": "far", "dy": "x", "reach": 5 },
    "far": { "type": "Blur", "image": "depth", "size": 2, "filter": "box" },
    "depth": { "type": "Depth", "view": "view" },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 8 },
    "again": { "type": "Blur", "image": "bent", "size": 2.5, "size_y": 0.5, "filter": "box" },
    "mask": { "type": "Blur", "image": "spot", "size": 1.5 },
    "column": { "type": "Blur", "image": "x", "size": 0.75 },
    "layers": { "type": "Stack", "weights": ["t", "u"] },
    "three": { "type": "Blur", "image": "layers", "size": 1 },
    "moved": { "type": "Warp", "image": "three", "dx": 1.3, "dy": "mask" },
    "out": { "type": "Mix", "a": "again", "b": "soft", "weight": "mask" },
    "blend": { "type": "Blend", "colors": ["out", "bent", "#804020"], "weights": "moved" },
    "plain": { "type": "Blur", "image": "#123456", "size": 3 },
    "number": { "type": "Warp", "image": 0.25, "dx": "x" }"##;

const OUTPUTS: &str = r#""out": { "color": "out" }, "blend": { "color": "blend" }, "mask": { "weights": "mask" },
    "column": { "weights": "column" }, "moved": { "weights": "moved" }, "far": { "field": "far" },
    "plain": { "color": "plain" }, "number": { "weights": "number" }"#;

fn chains(samples: u32) -> CheckedGraph {
    graph(FORMAT, CHAINS, OUTPUTS).with_format(Format::new(23, 17, samples).unwrap())
}

fn outside_hull(frame: &Frame) -> u64 {
    frame.pictures.iter().map(|picture| picture.audit.hull_exits + picture.audit.nan_count).sum()
}

#[test]
fn chains_have_the_same_bits_under_all_settings() {
    for samples in [1, 4] {
        let graph = chains(samples);
        let frame = under_all_settings(&graph, 1, &Buffers::new(), &format!("{samples} samples"));
        assert_eq!(outside_hull(&frame), 0);
        let expected = all_bits(&frame);
        for (threads, tile) in [(1, (7, 3)), (2, (256, 16)), (3, (5, 17))] {
            for switches in [Switches::ALL, Switches::NONE] {
                let settings = settings(|s| (s.threads, s.tile, s.switches) = (threads, Some(tile), switches));
                let found = evaluate(&graph, 1, &Buffers::new(), &settings);
                assert!(all_bits(&found) == expected, "{samples} samples, {threads} threads, tiles of {tile:?}");
            }
        }
    }
}

#[test]
fn a_region_holds_what_the_whole_picture_does() {
    let graph = chains(1);
    let whole = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    for region in [Window::new(0, 0, 1, 1), Window::new(9, 5, 14, 6), Window::new(20, 3, 23, 17)] {
        let part =
            evaluate(&graph, 1, &Buffers::new(), &settings(|s| (s.region, s.tile) = (Some(region), Some((4, 2)))));
        for (part, whole) in part.pictures.iter().zip(&whole.pictures) {
            for channel in 0..part.planes.len() {
                for (x, y) in (region.y0..region.y1).flat_map(|y| (region.x0..region.x1).map(move |x| (x, y))) {
                    let (found, expected) = (sample(part, channel, x, y), sample(whole, channel, x, y));
                    assert_eq!(found.to_bits(), expected.to_bits(), "({x}, {y}) of {region}");
                }
            }
        }
    }
}

#[test]
fn the_reference_agrees_on_chains() {
    for samples in [1, 4] {
        // The sea is flat, because the reference follows the formula of the waves and the fast path triangles.
        let nodes = CHAINS.replace(r#""count": 8"#, r#""count": 0"#);
        let graph = graph(FORMAT, &nodes, OUTPUTS).with_format(Format::new(23, 17, samples).unwrap());
        let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
        for picture in &frame.pictures {
            let output = &graph.outputs()[picture.output].name;
            let reference = ReferenceFrame::new(&graph, output, 1).unwrap();
            for (x, y) in [(0, 0), (22, 16), (11, 12), (7, 5)] {
                for (channel, truth) in reference.pixel(x, y).unwrap().into_iter().enumerate() {
                    let found = f64::from(sample(picture, channel, x, y));
                    // A displacement is a depth of some meters; its rounding in f32 is visible at edges in the picture.
                    let near = found == truth || (found - truth).abs() <= 2e-5 * truth.abs().max(1.0);
                    assert!(near, "{samples} samples, {output} at ({x}, {y}): {found}, expected {truth}");
                }
            }
        }
    }
}

#[test]
fn halos_add_up_along_chains() {
    let halo = |output: &str| {
        let graph = chains(1);
        Plan::new(&graph, &[output], 1, &[], &settings(|_| ())).unwrap().halo()
    };
    assert_eq!(halo("column"), (3, 3));
    assert_eq!(halo("far"), (2, 2));
    // On the longest path: a box of 2.5 and ½, a reach of 5, and a Gaussian of 1.25.
    assert_eq!(halo("out"), (3 + 5 + 5, 1 + 5 + 5));
    let none = graph(FORMAT, r#""x": { "type": "ScreenX" }"#, r#""x": { "weights": "x" }"#);
    assert_eq!(Plan::new(&none, &[], 1, &[], &settings(|_| ())).unwrap().halo(), (0, 0));
}

#[test]
fn controls_are_found_through_filters() {
    let nodes = r##"
        "x": { "type": "ScreenX" },
        "mix": { "type": "Mix", "a": [0.1, 0.7, 0.3], "b": [0.9, 0.2, 0.4], "weight": "x" },
        "soft": { "type": "Blur", "image": "mix", "size": 2 },
        "bent": { "type": "Warp", "image": "soft", "dx": 1.5 },
        "flat": { "type": "Blur", "image": [0.5, 0.25, 1], "size": 2 },
        "out": { "type": "Mix", "a": "bent", "b": "flat", "weight": "x" }"##;
    let graph = graph(FORMAT, nodes, r#""out": { "color": "out" }, "flat": { "color": "flat" }"#);
    let frame = under_all_settings(&graph, 1, &Buffers::new(), "controls");
    let [out, flat] = &frame.pictures[..] else { panic!("two outputs") };
    assert_eq!((out.control_count, out.audit.hull_exits), (3, 0));
    assert_eq!(out.control_colors, [[0.1, 0.7, 0.3], [0.5, 0.25, 1.0], [0.9, 0.2, 0.4]]);
    assert_eq!((flat.control_count, flat.audit.hull_exits), (1, 0));
    for (plane, value) in flat.planes.iter().zip([0.5, 0.25, 1.0]) {
        assert!(plane.samples().iter().all(|v| *v == value), "a constant does not change");
    }
    // If a buffer replaces the image, the corners of the hull of its pixels are the palette.
    let planes = [0.0, 0.5, 1.0]
        .map(|phase: f32| -> Vec<f32> { (0..23 * 17).map(|i| (i as f32 + phase).sin().abs()).collect() });
    let buffers = Buffers::new().with("mix", &planes.each_ref().map(Vec::as_slice));
    let frame = under_all_settings(&graph, 1, &buffers, "bound");
    let sound = &frame.pictures[0];
    assert!(sound.control_count > 16 && sound.audit.hull_exits == 0, "{}", sound.control_count);
    // The corners of a cube, and much within it.
    let cube = [1, 2, 4].map(|bit| -> Vec<f32> {
        (0..23 * 17).map(|i| if i < 8 { f32::from(i & bit > 0) } else { 0.25 + i as f32 / 1024.0 }).collect()
    });
    let buffers = Buffers::new().with("mix", &cube.each_ref().map(Vec::as_slice));
    let frame = under_all_settings(&graph, 1, &buffers, "bound to a cube");
    assert_eq!((frame.pictures[0].control_count, frame.pictures[0].audit.hull_exits), (8 + 1, 0));
    // A color that is the same everywhere is one color, however many pixels have it.
    let flat = [0.5, 0.25, 1.0].map(|value| vec![value; 23 * 17]);
    let buffers = Buffers::new().with("mix", &flat.each_ref().map(Vec::as_slice));
    let frame = under_all_settings(&graph, 1, &buffers, "bound to one color");
    assert_eq!((frame.pictures[0].control_count, frame.pictures[0].audit.hull_exits), (1, 0));
    let buffers = Buffers::new().with("mix", &[&flat[0], &flat[0], &flat[0]]);
    let frame = under_all_settings(&graph, 1, &buffers, "bound to another color");
    assert_eq!((frame.pictures[0].control_count, frame.pictures[0].audit.judged), (2, 23 * 17));
}

#[test]
fn hostile_values_stay_in_range() {
    let nodes = r##"
        "paint": { "type": "Constant", "color": [0, 0, 0] }, "x": { "type": "ScreenX" },
        "layers": { "type": "Stack", "weights": ["x", "x"] }, "field": { "type": "Depth", "view": "view" },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
        "soft": { "type": "Blur", "image": "paint", "size": 1.7 },
        "bent": { "type": "Warp", "image": "paint", "dx": "field", "dy": 0.3, "reach": 4 },
        "three": { "type": "Blur", "image": "layers", "size": 2.2, "filter": "box" },
        "moved": { "type": "Warp", "image": "layers", "dx": 0.7, "dy": 0.3 },
        "smeared": { "type": "Blur", "image": "field", "size": 1 }"##;
    let outputs = r#""soft": { "color": "soft" }, "bent": { "color": "bent" }, "three": { "weights": "three" },
        "moved": { "weights": "moved" }, "smeared": { "field": "smeared" }"#;
    let graph = graph(FORMAT, nodes, outputs);
    let area = 23 * 17;
    let of = |values: &[f32], step: usize| -> Vec<f32> {
        (0..area).map(|i| values[(i * step + i / 5) % values.len()]).collect()
    };
    let colors = of(&[0.0, f32::MAX, 1e-45, 1.0, f32::MIN_POSITIVE, 3e38, 0.1], 3);
    let field = of(&[f32::INFINITY, 3.0, f32::NEG_INFINITY, f32::MAX, -1e-45, 0.0, f32::MIN, 2.5], 5);
    let parts: Vec<[f32; 3]> =
        (0..area).map(|i| [[1.0, 0.0, 0.0], [1e-30, 1.0, 0.0], [0.3, 0.3, 0.4]][(i * 7 + i / 4) % 3]).collect();
    let parts = [0, 1, 2].map(|c| -> Vec<f32> { parts.iter().map(|w| w[c]).collect() });
    let buffers = Buffers::new()
        .with("paint", &[&colors, &colors, &colors])
        .with("layers", &parts.each_ref().map(Vec::as_slice))
        .with("field", &[&field]);
    let frame = under_all_settings(&graph, 1, &buffers, "hostile");
    assert_eq!(outside_hull(&frame), 0, "no NaN, and no color outside the hull");
    for picture in &frame.pictures[2..4] {
        for at in 0..area {
            let weights: Vec<f64> = picture.planes.iter().map(|plane| f64::from(plane.samples()[at])).collect();
            assert_eq!(weights.iter().sum::<f64>(), 1.0, "{weights:?}");
            assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)), "{weights:?}");
        }
    }
}

#[test]
fn a_kernel_much_larger_than_the_picture_averages_its_edges() {
    let nodes = r#""x": { "type": "ScreenX" }, "wide": { "type": "Blur", "image": "x", "size": 10000, "filter": "box" },
        "soft": { "type": "Blur", "image": "x", "size": 10000 }"#;
    let outputs = r#""wide": { "weights": "wide" }, "soft": { "weights": "soft" }"#;
    let graph = graph(r#""width": 100, "height": 100"#, nodes, outputs);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    for picture in &frame.pictures {
        // Nearly all of the kernel lies on the repeated edges.
        assert!(picture.planes[0].samples().iter().all(|v| (v - 0.5).abs() < 0.01));
    }
}

/// Writes a gray picture with these windows.
fn write_windows(path: &Path, display: Window, data: Window, value: impl Fn(i64, i64) -> f32) {
    let at = |(x, y): (i64, i64)| value(x, y);
    let samples: Vec<f32> = (data.y0..data.y1).flat_map(|y| (data.x0..data.x1).map(move |x| (x, y))).map(at).collect();
    let channels = ["R", "G", "B"].map(|name| ExrChannel::float(name, Samples::contiguous(&samples))).into();
    trochoid::io::write_exr(path, &ExrImage { display, data, channels, ..ExrImage::new(display) }).unwrap();
}

/// Returns the mean of 3 × 3 pixels; outside `window`, its nearest pixel repeats.
fn nine(value: &dyn Fn(i64, i64) -> f32, window: Window, x: i64, y: i64) -> f64 {
    let at = |x: i64, y: i64| f64::from(value(x.clamp(window.x0, window.x1 - 1), y.clamp(window.y0, window.y1 - 1)));
    (-1..2).flat_map(|dy| (-1..2).map(move |dx| (dx, dy))).map(|(dx, dy)| at(x + dx, y + dy)).sum::<f64>() / 9.0
}

#[test]
fn images_end_where_their_pixels_do() {
    let folder = tempfile::tempdir().unwrap();
    let value = |x: i64, y: i64| (x * x + 3 * y + 40) as f32;
    let (picture, over, under) = (Window::sized(6, 4), Window::new(-3, -2, 9, 6), Window::new(1, 1, 4, 3));
    write_windows(&folder.path().join("over.exr"), picture, over, value);
    write_windows(&folder.path().join("under.exr"), picture, under, value);
    let text = r##"{ "trochoid": 1, "format": { "width": 6, "height": 4 }, "nodes": {
        "over": { "type": "Read", "file": "over.exr", "as": "color" },
        "under": { "type": "Read", "file": "under.exr", "as": "color" },
        "red": { "type": "Read", "file": "under.exr", "as": "color", "outside": [7, 7, 7] },
        "switched": { "type": "Switch", "inputs": ["under", "over"], "which": 1 },
        "mixed": { "type": "Mix", "a": "over", "b": "#000", "weight": 0 },
        "blur_over": { "type": "Blur", "image": "over", "size": 1, "filter": "box" },
        "blur_under": { "type": "Blur", "image": "under", "size": 1, "filter": "box" },
        "blur_red": { "type": "Blur", "image": "red", "size": 1, "filter": "box" },
        "blur_switched": { "type": "Blur", "image": "switched", "size": 1, "filter": "box" },
        "blur_mixed": { "type": "Blur", "image": "mixed", "size": 1, "filter": "box" },
        "twice": { "type": "Warp", "image": "blur_over", "dx": -2, "dy": 0 },
        "bound": { "type": "ScreenX" },
        "here": { "type": "Warp", "image": "blur_over", "dx": -2, "dy": "bound" } },
        "outputs": { "blur_over": { "color": "blur_over" }, "blur_under": { "color": "blur_under" },
            "blur_red": { "color": "blur_red" }, "blur_switched": { "color": "blur_switched" },
            "blur_mixed": { "color": "blur_mixed" }, "twice": { "color": "twice" }, "here": { "color": "here" } } }"##;
    let graph = graph_in(folder.path(), text);
    let zero = [0.0f32; 24];
    let frame = under_all_settings(&graph, 1, &Buffers::new().with("bound", &[&zero]), "windows");
    assert_eq!(outside_hull(&frame), 0);
    let nearest = |x: i64, y: i64| value(x.clamp(1, 3), y.clamp(1, 2));
    let red = |x: i64, y: i64| if under.contains(x, y) { value(x, y) } else { 7.0 };
    for (x, y) in (0..4).flat_map(|y| (0..6).map(move |x| (x, y))) {
        let expected = [
            nine(&value, over, x, y),
            nine(&nearest, picture, x, y),
            // Outside the picture its border repeats, whatever `outside` is.
            nine(&red, picture, x, y),
            nine(&value, over, x, y),
            // The mix ends at the border of the picture, although its weight is 0.
            nine(&value, picture, x, y),
            nine(&value, over, x - 2, y),
            nine(&value, over, x - 2, y),
        ];
        for (picture, expected) in frame.pictures.iter().zip(expected) {
            let found = f64::from(sample(picture, 0, x, y));
            let output = &graph.outputs()[picture.output].name;
            assert!((found - expected).abs() < 1e-4, "{output} at ({x}, {y}): {found}, expected {expected}");
        }
    }
    for output in ["blur_over", "blur_red", "blur_mixed", "twice"] {
        let reference = ReferenceFrame::new(&graph, output, 1).unwrap();
        let picture = frame.pictures.iter().find(|p| graph.outputs()[p.output].name == output).unwrap();
        for (x, y) in [(0, 0), (5, 3), (2, 1)] {
            let truth = reference.pixel(x, y).unwrap()[0];
            assert!((truth - f64::from(sample(picture, 0, x, y))).abs() < 1e-4, "{output} at ({x}, {y})");
        }
    }
}

#[test]
fn textures_are_controls_and_filtered_like_files() {
    let folder = tempfile::tempdir().unwrap();
    let values: Vec<f32> = (0..20).map(|i| i as f32 / 20.0).collect();
    write_exr(&folder.path().join("a.exr"), 5, 4, &[("R", &values), ("G", &values), ("B", &[0.5; 20])]);
    let text = r#"{ "trochoid": 1, "format": { "width": 16, "height": 9 }, "nodes": {
        "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "u": { "type": "Warp", "image": "x", "dx": 1.5 },
        "texture": { "type": "Texture", "file": "a.exr", "as": "color", "u": "u", "v": "y", "wrap": "mirror" },
        "out": { "type": "Blur", "image": "texture", "size": 0.8 } },
        "outputs": { "out": { "color": "out" }, "texture": { "color": "texture" } } }"#;
    let frame = under_all_settings(&graph_in(folder.path(), text), 1, &Buffers::new(), "texture");
    assert_eq!(outside_hull(&frame), 0);
    assert!(frame.pictures.iter().all(|picture| picture.control_count == 20));
}

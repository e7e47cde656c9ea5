//! Cartoon water: foam on hostile passes, distant lines without flicker, and floating bodies at any frame.

use crate::support::{all_bits, evaluate, graph_in, on_passes, sample, settings, under_all_settings, write_exr};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use trochoid::{Buffers, Cache, Plan, ReferenceFrame, Silent};

#[test]
fn waterline_foam_agrees_with_the_reference_on_hostile_passes() {
    let (width, height) = (19, 14);
    let nodes = r#"
        "water": { "type": "ViewFromPasses", "file": "a.exr", "depth": "water.Z", "position": "Pw" },
        "land": { "type": "ViewFromPasses", "file": "a.exr", "depth": "land.Z", "position": "Pl" },
        "x": { "type": "ScreenX" },
        "wild": { "type": "FieldMath", "expression": "(a - 0.4)*1e30", "a": "x" },
        "ramp": { "type": "WaterlineFoam", "view": "water", "behind": "land" },
        "line": { "type": "WaterlineFoam", "view": "water", "behind": "land", "distance": 0.7, "solid": 1 },
        "ragged": { "type": "WaterlineFoam", "view": "water", "behind": "land", "edge": "x", "solid": 0.3 },
        "torn": { "type": "WaterlineFoam", "view": "water", "behind": "land", "edge": "wild" },
        "deep": { "type": "WaterlineFoam", "view": "water", "behind": "land", "edge": -0.5, "measure": "height" }"#;
    let outputs = ["ramp", "line", "ragged", "torn", "deep"];
    let outputs: Vec<String> = outputs.iter().map(|mask| format!(r#""{mask}": {{ "weights": "{mask}" }}"#)).collect();
    for seed in 0..4 {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut plane = |values: &[f32]| -> Vec<f32> {
            (0..width * height).map(|_| values[random.random_range(0..values.len())]).collect()
        };
        let depths = [2.0, 2.0 + 1e-6, 2.4, 2.7, 3.0, 0.0, 1e-20, 9e3, 1e9, f32::INFINITY, 1e30];
        let (water, land) = (plane(&depths), plane(&depths));
        let mut passes = vec![("water.Z", water), ("land.Z", land)];
        for name in ["Pw.X", "Pw.Y", "Pw.Z", "Pl.X", "Pl.Y", "Pl.Z"] {
            passes.push((name, plane(&[0.0, 0.1, -0.3, 0.25, 1e6, -1e30])));
        }
        on_passes([width, height], &passes, nodes, &outputs, |output, pairs| {
            for (at, [found, truth]) in pairs.iter().enumerate() {
                assert!((found - truth).abs() <= 1e-5, "seed {seed}, {output} at {at}: {found}, not {truth}");
            }
            let full = pairs.iter().filter(|[_, truth]| *truth > 0.99).count();
            let none = pairs.iter().filter(|[_, truth]| *truth == 0.0).count();
            assert!(full > 5 && none > 20, "{output} tells nothing: {full}, {none}");
        });
    }
}

/// A net of lines on a flat sea that extends to the horizon.
fn lines(width: u32, time: u32) -> String {
    format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {width}, "height": {}, "samples": 1 }},
            "frames": {{ "first": 1, "last": 100, "fps": {time} }},
            "nodes": {{
                "camera": {{ "type": "Camera", "position": [0, 3, 10], "target": [0, 1.5, 0], "fov": 60 }},
                "sea": {{ "type": "RippleSea", "height": 0 }},
                "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
                "lines": {{ "type": "SurfaceLines", "view": "view", "scale": 2, "width": 0.12 }} }},
            "outputs": {{ "lines": {{ "weights": "lines" }} }} }}"#,
        width / 2
    )
}

/// Returns the mean change from pixel to pixel and from frame to frame in rows of a picture.
fn unrest(width: u32, from_row: f64, to_row: f64) -> (f64, f64) {
    let graph = graph_in(Path::new("."), &lines(width, 24));
    let [now, next] = [30, 31].map(|frame| evaluate(&graph, frame, &Buffers::new(), &settings(|_| ())));
    let (mut space, mut time, mut count) = (0.0, 0.0, 0.0);
    let rows = [from_row, to_row].map(|row| (row * f64::from(width / 2)) as i64);
    for y in rows[0]..rows[1] {
        for x in 0..i64::from(width) - 1 {
            let at = |frame: &trochoid::Frame, x: i64| f64::from(sample(&frame.pictures[0], 0, x, y));
            space += (at(&now, x) - at(&now, x + 1)).abs();
            time += (at(&now, x) - at(&next, x)).abs();
            count += 1.0;
        }
    }
    (space / count, time / count)
}

#[test]
fn lines_do_not_flicker_afar() {
    // Just below the horizon, a pixel covers many meshes of the net, which blend into an even tone.
    let (space, time) = unrest(192, 0.38, 0.40);
    assert!(space < 2e-3 && time < 2e-3, "afar: {space} from pixel to pixel, {time} from frame to frame");
    // Nearby they are lines.
    let (space, _) = unrest(192, 0.8, 1.0);
    assert!(space > 0.02, "near: {space}");
    // Nowhere does a frame differ from the next by more than the lines move.
    for (from, to) in [(0.40, 0.45), (0.45, 0.55), (0.55, 0.7), (0.7, 1.0)] {
        let (space, time) = unrest(192, from, to);
        assert!(time < 0.05 && time < 1.2 * space + 1e-3, "rows {from} to {to}: {time} from frame to frame, {space}");
    }
}

#[test]
fn lines_agree_with_the_reference_from_the_shore_to_the_horizon() {
    for (change, to) in
        [("", ""), ("\"width\": 0.12", "\"width\": 1e6"), ("\"scale\": 2", "\"scale\": 1e-3, \"scroll_z\": 1e6")]
    {
        let text = lines(64, 24).replace(change, to);
        let graph = graph_in(Path::new("."), &text);
        let frame = under_all_settings(&graph, 77, &Buffers::new(), "lines");
        let reference = ReferenceFrame::new(&graph, "lines", 77).unwrap();
        let (mut near, mut all) = (0, 0);
        for (x, y) in (0..32).flat_map(|y| (0..64).map(move |x| (x, y))).filter(|(x, y)| (x + 3 * y) % 5 == 0) {
            let (truth, found) = (reference.pixel(x, y).unwrap()[0], f64::from(sample(&frame.pictures[0], 0, x, y)));
            assert!((0.0..=1.0).contains(&found));
            near += i32::from((found - truth).abs() < 5e-3);
            all += 1;
        }
        // Far away, the rounding of points in f32 is as large as the lines are wide.
        assert!(f64::from(near) > 0.99 * f64::from(all), "{to}: {near} of {all}");
    }
}

#[test]
fn a_tiled_picture_lies_on_the_water_and_scrolls() {
    let folder = tempfile::tempdir().unwrap();
    write_exr(&folder.path().join("tile.exr"), 4, 2, &[("m", &[0.0, 0.5, 1.0, 0.25, 0.75, 0.0, 0.125, 1.0])]);
    let text = lines(48, 24)
        .replace("\"width\": 0.12", "\"scroll_x\": 2, \"scroll_z\": -6")
        .replace(
            "} },\n            \"outputs\"",
            "}, \"tiled\": { \"type\": \"Texture\", \"file\": \"tile.exr\", \"as\": \"field\",
            \"channels\": [\"m\"], \"u\": \"lines.u\", \"v\": \"lines.v\" } },\n            \"outputs\"",
        )
        .replace("\"weights\": \"lines\"", "\"field\": \"tiled\"");
    let graph = graph_in(folder.path(), &text);
    let at = |frame: i64| evaluate(&graph, frame, &Buffers::new(), &settings(|_| ()));
    // In a second the tiles move by one along x and by three along z: to the same picture.
    let [start, between, second] = [1, 9, 25].map(at);
    let (mut moved, mut seen) = (0, 0);
    for (x, y) in (12..24).flat_map(|y| (0..48).map(move |x| (x, y))) {
        let [a, b, c] = [&start, &between, &second].map(|frame| sample(&frame.pictures[0], 0, x, y));
        assert!((a - c).abs() < 1e-4, "({x}, {y}): {a} and {c}");
        moved += i32::from((a - b).abs() > 0.01);
        seen += i32::from(a > 0.0);
    }
    assert!(moved > 300 && seen > 300, "{moved} moved, {seen} seen");
}

const AFLOAT: &str = r##"{ "trochoid": 1, "format": { "width": 32, "height": 18, "samples": 4 },
    "frames": { "first": 1, "last": 80, "fps": 24 },
    "nodes": {
        "camera": { "type": "Camera", "position": [3, 4, 9], "target": [3, 0, 0], "fov": 55 },
        "plate": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-1, 0.1, 0.6] }, { "at": [1, 0.3, 0.6] },
            { "at": [-1, 0.1, -0.6] }, { "at": [1, 0.1, -0.6] }] }] },
        "ground": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-9, -1, 9] }, { "at": [15, -1, 9] },
            { "at": [-9, 1, -9] }, { "at": [15, 1, -9] }] }] },
        "ripples": { "type": "RippleSea", "height": 0.3, "along": 3, "across": 4 },
        "waves": { "type": "GerstnerSea", "count": 20, "wavelength": 5, "height": 0.6, "sharpness": 0.8, "seed": 2 },
        "bursts": { "type": "ToonSea", "columns": 40, "rows": 40, "spacing": 0.3, "x": -3, "z": -6, "preroll": 30,
            "guides": [{ "path": [0, 5, 4, 5, 8, 5, 12, 5], "count": 6, "width": 6, "height": 1.2, "duration": 3 }] },
        "a": { "type": "Float", "model": "plate", "sea": "ripples", "bodies": [{ "x": 0, "heading": 20 }] },
        "b": { "type": "Float", "model": "plate", "sea": "waves", "bodies": [{ "x": 3, "z": 1 }] },
        "c": { "type": "Float", "model": "plate", "sea": "bursts", "tilt": 2, "bodies": [{ "x": 5, "z": -1 },
            { "x": { "keys": [[1, 6], [80, 8]] }, "z": 2, "heading": { "keys": [[1, 0], [80, 360]] }, "lift": 0.2 }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["a", "b", "c"] },
        "behind": { "type": "Render", "camera": "camera", "surfaces": ["a", "b", "c", "ground"] },
        "water": { "type": "Render", "camera": "camera", "surfaces": ["ripples"] },
        "height": { "type": "Height", "view": "view" },
        "rough": { "type": "Noise", "view": "water", "space": "rest", "evolution": { "keys": [[1, 0], [80, 4]] } },
        "foam": { "type": "WaterlineFoam", "view": "water", "behind": "behind", "edge": "rough" },
        "lines": { "type": "SurfaceLines", "view": "water", "thickness": "foam" },
        "lined": { "type": "Mix", "a": "#0072b8", "b": "#ffffff", "weight": "lines" },
        "out": { "type": "Mix", "a": "lined", "b": "#ffffff", "weight": "foam" } },
    "outputs": { "out": { "color": "out" }, "height": { "field": "height" } } }"##;

#[test]
fn frame_60_alone_equals_frame_60_of_a_run() {
    let graph = graph_in(Path::new("."), AFLOAT);
    let mut cache = Cache::new();
    let mut run = |number: i64| {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap()
    };
    let frames: Vec<_> = (1..=60).map(&mut run).collect();
    let alone = evaluate(&graph, 60, &Buffers::new(), &settings(|_| ()));
    assert_eq!(all_bits(&frames[59]), all_bits(&alone));
    assert_eq!(all_bits(&run(17)), all_bits(&frames[16]), "and backward");
    assert!(frames.windows(2).all(|pair| all_bits(&pair[0]) != all_bits(&pair[1])), "every frame differs");
    under_all_settings(&graph, 60, &Buffers::new(), "afloat");
}

#[test]
fn floating_bodies_agree_with_the_reference_on_every_sea() {
    let graph = graph_in(Path::new("."), AFLOAT);
    let frame = evaluate(&graph, 12, &Buffers::new(), &settings(|_| ()));
    let picture = frame.pictures.iter().find(|p| graph.outputs()[p.output].name == "height").unwrap();
    let reference = ReferenceFrame::new(&graph, "height", 12).unwrap();
    let (mut good, mut seen) = (0, 0);
    for (x, y) in (0..18).flat_map(|y| (0..32).map(move |x| (x, y))) {
        let (truth, found) = (reference.pixel(x, y).unwrap()[0], f64::from(sample(picture, 0, x, y)));
        seen += i32::from(truth != 0.0);
        // A tenth of a pixel, which is 0.3 m wide.
        good += i32::from((found - truth).abs() < 0.03);
    }
    assert!(seen > 20 && good >= 18 * 32 - 6, "{good} of {}, {seen} seen", 18 * 32);
}

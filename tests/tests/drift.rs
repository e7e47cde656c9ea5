//! Toon seas and their trails over time: lines move without jumps; frames are independent of each other; nodes without
//! weight cost nothing.

use crate::support::{all_bits, evaluate, graph, graph_in, root, sample, settings, state, under_all_settings};
use serde_json::{Value, json};
use trochoid::{Buffers, Cache, CheckedGraph, Plan, Silent, State};

const WIDTH: i64 = 240;
const HEIGHT: i64 = 135;
/// Side of the tiles in which changes are added up.
const TILE: i64 = 16;
const MASKS: [&str; 3] = ["navy_lines", "wake_lines", "foam_fingers"];

/// Returns the graph of the toon sea with its masks of lines as outputs, on the water alone, at a frame rate.
fn masks(fps: i64) -> CheckedGraph {
    let text = std::fs::read_to_string(root().join("graphs/toon_sea.json")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["format"] = json!({ "width": WIDTH, "height": HEIGHT, "samples": 1 });
    document["frames"] = json!({ "first": 1, "last": 96 * fps / 24, "fps": fps });
    document["nodes"]["view"]["surfaces"] = json!(["waves"]);
    let outputs = MASKS.map(|mask| (mask.to_string(), json!({ "weights": format!("sea/{mask}") })));
    document["outputs"] = Value::Object(outputs.into_iter().collect());
    graph_in(&root().join("graphs"), &document.to_string())
}

/// Returns how much each mask changes from frame to frame in half a second, in pixels: on average over the picture, and
/// at most in a tile.
fn change(fps: i64) -> Vec<[f64; 2]> {
    let graph = masks(fps);
    let mut cache = Cache::new();
    let mut before: Vec<Vec<f64>> = Vec::new();
    let mut changes = vec![[0.0; 2]; MASKS.len()];
    for number in 1..=fps / 2 + 1 {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        let frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
        let all = |y: i64| (0..WIDTH).map(move |x| (x, y));
        let now: Vec<Vec<f64>> = MASKS
            .iter()
            .map(|mask| {
                let picture = frame.pictures.iter().find(|p| graph.outputs()[p.output].name == *mask).unwrap();
                (0..HEIGHT).flat_map(all).map(|(x, y)| f64::from(sample(picture, 0, x, y))).collect()
            })
            .collect();
        for (index, before) in before.iter().enumerate() {
            assert!(before.iter().sum::<f64>() > 20.0, "{} is drawn", MASKS[index]);
            let across = (WIDTH + TILE - 1) / TILE;
            let mut tiles = vec![0.0; (across * ((HEIGHT + TILE - 1) / TILE)) as usize];
            for (at, (a, b)) in before.iter().zip(&now[index]).enumerate() {
                let (x, y) = (at as i64 % WIDTH, at as i64 / WIDTH);
                tiles[(y / TILE * across + x / TILE) as usize] += (a - b).abs();
            }
            let [mean, most] = &mut changes[index];
            *mean += tiles.iter().sum::<f64>() / (fps / 2) as f64;
            *most = tiles.into_iter().fold(*most, f64::max);
        }
        before = now;
    }
    changes
}

#[test]
fn lines_change_by_half_in_half_the_time_everywhere() {
    // At twice the frame rate, a line that moves changes a tile by half as much per frame; one that jumps, by just as
    // much. At these rates, no line moves by its own width per frame.
    let [slow, fast] = [48, 96].map(change);
    for ((mask, slow), fast) in MASKS.iter().zip(&slow).zip(&fast) {
        let [mean, most] = [fast[0] / slow[0], fast[1] / slow[1]];
        assert!(mean < 0.55 && most < 0.6, "{mask}: {mean} on average, {most} at most in a tile");
    }
}

/// A toon sea's height, rift and lines over a plain color, weighted by `weight`.
fn trails(weight: &str) -> CheckedGraph {
    let nodes = format!(
        r##""camera": {{ "type": "Camera", "position": [3, 4, 9], "target": [3, 0, 0], "fov": 55 }},
        "sea": {{ "type": "ToonSea", "columns": 40, "rows": 40, "spacing": 0.3, "x": -3, "z": -6, "preroll": 30,
            "guides": [{{ "path": [0, 5, 4, 5, 8, 5, 12, 5], "count": 6, "width": 6, "height": 1.2, "duration": 3 }}] }},
        "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
        "height": {{ "type": "Height", "view": "view" }},
        "rift": {{ "type": "Rift", "view": "view" }},
        "lines": {{ "type": "DriftLines", "view": "view", "finest": 0.5 }},
        "behind": {{ "type": "DriftLines", "view": "view", "coordinate": "along", "finest": 0.5, "fresh": 0.1 }},
        "high": {{ "type": "Clamp", "field": "height", "min": -0.3, "max": 0.6 }},
        "foam": {{ "type": "Clamp", "field": "rift", "min": 0, "max": 0.5 }},
        "drawn": {{ "type": "Screen", "weights": ["lines", "behind"] }},
        "trails": {{ "type": "Screen", "weights": ["drawn", "foam"] }},
        "left": {{ "type": "Multiply", "weights": ["trails", {weight}] }},
        "water": {{ "type": "Mix", "a": "#123", "b": "#8ac", "weight": "high" }},
        "drawn_on": {{ "type": "Mix", "a": "water", "b": "#fff", "weight": "left" }},
        "seen": {{ "type": "Multiply", "weights": ["view.coverage", {weight}] }},
        "out": {{ "type": "Mix", "a": "#fed", "b": "drawn_on", "weight": "seen" }},
        "bare": {{ "type": "Mix", "a": "#fed", "b": "drawn_on", "weight": "view.coverage" }}"##
    );
    let outputs = r#""out": { "color": "out" }, "bare": { "color": "bare" }, "rift": { "field": "rift" },
        "lines": { "weights": "lines" }, "behind": { "weights": "behind" }, "height": { "field": "height" }"#;
    graph(r#""width": 32, "height": 18"#, &nodes, outputs)
}

#[test]
fn a_frame_of_trails_alone_equals_that_of_a_run() {
    let graph = trails("1");
    let mut cache = Cache::new();
    let mut run = |number: i64| {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        all_bits(&plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap())
    };
    let alone = evaluate(&graph, 60, &Buffers::new(), &settings(|_| ()));
    let frames: Vec<_> = (1..=60).map(&mut run).collect();
    assert_eq!(frames[59], all_bits(&alone));
    assert_eq!(run(20), frames[19], "and backward");
    for (before, after) in frames[58].iter().zip(&frames[59]) {
        assert_ne!(before, after, "every output changes");
    }
    under_all_settings(&graph, 7, &Buffers::new(), "trails");
}

#[test]
fn a_toon_sea_or_trails_without_weight_are_left_out_and_change_no_bit() {
    let only = |weight: &str, output: &str| {
        let graph = trails(weight);
        crate::support::evaluate_some(&graph, &[output], 30, &Buffers::new(), &settings(|_| ()))
    };
    let (without, with) = (only("0", "out"), only("1", "out"));
    let nodes = ["sea", "view", "height", "rift", "lines", "behind"];
    for node in nodes {
        assert!(matches!(state(&without, node), State::LeftOut(_)), "{node}: {:?}", state(&without, node));
        assert_eq!(*state(&with, node), State::Evaluated, "{node}");
    }
    let plain = graph(
        r#""width": 32, "height": 18"#,
        r##""out": { "type": "Mix", "a": "#fed", "b": "#fed", "weight": 0 }"##,
        r#""out": { "color": "out" }"#,
    );
    assert_eq!(all_bits(&without), all_bits(&evaluate(&plain, 30, &Buffers::new(), &settings(|_| ()))));
    assert_ne!(all_bits(&without), all_bits(&with));
    // The water alone, without its trails.
    let (without, with) = (only("0", "bare"), only("1", "bare"));
    for node in ["rift", "lines", "behind"] {
        assert!(matches!(state(&without, node), State::LeftOut(_)), "{node}: {:?}", state(&without, node));
        assert_eq!(*state(&with, node), State::Evaluated, "{node}");
    }
    for node in ["sea", "view", "height"] {
        assert_eq!(*state(&without, node), State::Evaluated, "{node}");
    }
    let text = r##""camera": { "type": "Camera", "position": [3, 4, 9], "target": [3, 0, 0], "fov": 55 },
        "sea": { "type": "ToonSea", "columns": 40, "rows": 40, "spacing": 0.3, "x": -3, "z": -6, "preroll": 30,
            "guides": [{ "path": [0, 5, 4, 5, 8, 5, 12, 5], "count": 6, "width": 6, "height": 1.2, "duration": 3 }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "height": { "type": "Height", "view": "view" },
        "high": { "type": "Clamp", "field": "height", "min": -0.3, "max": 0.6 },
        "water": { "type": "Mix", "a": "#123", "b": "#8ac", "weight": "high" },
        "bare": { "type": "Mix", "a": "#fed", "b": "water", "weight": "view.coverage" }"##;
    let plain = graph(r#""width": 32, "height": 18"#, text, r#""bare": { "color": "bare" }"#);
    assert_eq!(all_bits(&without), all_bits(&evaluate(&plain, 30, &Buffers::new(), &settings(|_| ()))));
    assert_ne!(all_bits(&without), all_bits(&with));
}

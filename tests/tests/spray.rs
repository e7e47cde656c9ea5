//! Spray costs nothing without weight, and its frames are independent of each other.

use crate::support::{all_bits, bits, evaluate, graph, settings, state, under_all_settings};
use trochoid::{Buffers, Cache, CheckedGraph, LeftOut, Plan, Silent, State};

const FORMAT: &str = r#""width": 32, "height": 18"#;

/// A breaking sea with spray, weighted by `weight`.
fn breaking(weight: &str) -> CheckedGraph {
    let nodes = format!(
        r##""camera": {{ "type": "Camera", "position": [0, 4, 16], "target": [0, 1, 0], "fov": 60 }},
        "sun": {{ "type": "Light" }},
        "sea": {{ "type": "GerstnerSea", "count": 12, "wavelength": 8, "height": 1.5, "sharpness": 0.9, "seed": 2 }},
        "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
        "light": {{ "type": "NonSpecular", "view": "view", "lights": ["sun"] }},
        "water": {{ "type": "Mix", "a": "#123", "b": "#8ac", "weight": "light" }},
        "spray": {{ "type": "Spray", "view": "view", "sea": "sea", "size": [24, 24], "threshold": 0.8, "seed": 5,
            "bursts": [{{ "position": [0, 1, 5], "time": 0.1, "count": 60 }}] }},
        "mist": {{ "type": "Mix", "a": "#fff", "b": "#9ab", "weight": "spray.age" }},
        "shown": {{ "type": "Multiply", "weights": ["spray.alpha", {weight}] }},
        "out": {{ "type": "Mix", "a": "water", "b": "mist", "weight": "shown" }}"##
    );
    graph(FORMAT, &nodes, r#""out": { "color": "out" }"#)
}

#[test]
fn spray_without_weight_is_not_simulated() {
    let frame = |weight: &str| evaluate(&breaking(weight), 12, &Buffers::new(), &settings(|_| ()));
    let without = frame("0");
    assert!(matches!(
        state(&without, "spray"),
        State::LeftOut(LeftOut::Weight(_) | LeftOut::Constant(_) | LeftOut::Unneeded)
    ));
    let plain = r##""camera": { "type": "Camera", "position": [0, 4, 16], "target": [0, 1, 0], "fov": 60 },
        "sun": { "type": "Light" },
        "sea": { "type": "GerstnerSea", "count": 12, "wavelength": 8, "height": 1.5, "sharpness": 0.9, "seed": 2 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "light": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
        "out": { "type": "Mix", "a": "#123", "b": "#8ac", "weight": "light" }"##;
    let plain = evaluate(&graph(FORMAT, plain, r#""out": { "color": "out" }"#), 12, &Buffers::new(), &settings(|_| ()));
    assert_eq!(bits(&without.pictures[0]), bits(&plain.pictures[0]));
    let with = frame("1");
    assert_eq!(*state(&with, "spray"), State::Evaluated);
    assert_ne!(bits(&with.pictures[0]), bits(&plain.pictures[0]), "spray is visible");
}

#[test]
fn a_frame_of_spray_alone_equals_that_of_a_run() {
    let graph = breaking("1");
    let mut cache = Cache::new();
    let mut run = |number: i64| {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        all_bits(&plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap())
    };
    let alone = all_bits(&evaluate(&graph, 60, &Buffers::new(), &settings(|_| ())));
    let frames: Vec<_> = (1..=60).map(&mut run).collect();
    assert_eq!(frames[59], alone);
    assert_eq!(run(20), frames[19], "and backward");
    assert_ne!(frames[58], frames[59]);
}

#[test]
fn no_setting_changes_a_bit_of_spray() {
    under_all_settings(&breaking("1"), 7, &Buffers::new(), "spray");
}

//! Equal nodes are computed once, but not if a bound buffer distinguishes them.

use crate::support::{graph, state, under_all_settings};
use trochoid::{Buffers, LeftOut, State};

const FORMAT: &str = r#""width": 4, "height": 2"#;

#[test]
fn twins_with_different_buffers_stay_apart() {
    let nodes = r##"
        "one": { "type": "ScreenX" }, "two": { "type": "ScreenX" },
        "t": { "type": "Clamp", "field": "one", "min": 0.25, "max": 0.75 },
        "u": { "type": "Clamp", "field": "two", "min": 0.25, "max": 0.75 },
        "a": { "type": "Mix", "a": "#000", "b": [4, 2, 1], "weight": "t" },
        "b": { "type": "Mix", "a": "#000", "b": [4, 2, 1], "weight": "u" }"##;
    let graph = graph(FORMAT, nodes, r#""a": { "color": "a" }, "b": { "color": "b" }, "u": { "weights": "u" }"#);
    let (low, high) = ([0.0f32; 8], [1.0f32; 8]);
    let both = Buffers::new().with("one", &[&low]).with("two", &[&high]);
    let frame = under_all_settings(&graph, 1, &both, "both bound");
    assert_eq!(frame.pictures[0].planes[0].samples(), [0.0; 8]);
    assert_eq!(frame.pictures[1].planes[0].samples(), [4.0; 8]);
    assert_eq!(frame.pictures[2].planes[0].samples(), [1.0; 8]);
    let first = Buffers::new().with("one", &[&high]);
    let frame = under_all_settings(&graph, 1, &first, "one bound");
    assert_eq!(frame.pictures[0].planes[0].samples(), [4.0; 8]);
    let ramp = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0f32].map(|x| ((x - 0.25) / 0.5).clamp(0.0, 1.0));
    assert_eq!(frame.pictures[2].planes[0].samples(), [ramp, ramp].concat());
}

#[test]
fn equal_renders_are_one() {
    let nodes = r##"
        "camera": { "type": "Camera" }, "sun": { "type": "Light" },
        "sea": { "type": "GerstnerSea", "count": 4, "seed": 5 }, "twin": { "type": "GerstnerSea", "count": 4, "seed": 5 },
        "first": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "second": { "type": "Render", "camera": "camera", "surfaces": ["twin"] },
        "light": { "type": "NonSpecular", "view": "first", "lights": ["sun"] },
        "again": { "type": "NonSpecular", "view": "second", "lights": ["sun"], "power": 2 },
        "a": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "light" },
        "out": { "type": "Mix", "a": "a", "b": "#876", "weight": "again" }"##;
    let graph = graph(FORMAT, nodes, r#""out": { "color": "out" }"#);
    let frame = under_all_settings(&graph, 1, &Buffers::new(), "twins");
    for (a, b) in [("sea", "twin"), ("first", "second")] {
        // The engine may choose which of them it evaluates.
        let (kept, same) = if *state(&frame, a) == State::Evaluated { (a, b) } else { (b, a) };
        assert_eq!(*state(&frame, same), State::LeftOut(LeftOut::SameAs(kept.into())));
        assert_eq!(*state(&frame, kept), State::Evaluated);
    }
    assert_eq!(*state(&frame, "again"), State::Evaluated, "its power differs");
}

#[test]
fn disabled_nodes_hand_on_their_first_input() {
    let nodes = r##"
        "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "not": { "type": "Invert", "weight": "x", "disabled": true },
        "inner": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "not" },
        "off": { "type": "Mix", "a": "inner", "b": "#f00", "weight": "y", "disabled": true },
        "out": { "type": "Mix", "a": "off", "b": "#00f", "weight": 0.5 },
        "plain": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" },
        "same": { "type": "Mix", "a": "plain", "b": "#00f", "weight": 0.5 }"##;
    let outputs = r#""out": { "color": "out" }, "same": { "color": "same" }, "off": { "color": "off" }"#;
    let graph = graph(FORMAT, nodes, outputs);
    let frame = under_all_settings(&graph, 1, &Buffers::new(), "disabled");
    assert_eq!(frame.pictures[0].planes, frame.pictures[1].planes);
    assert_eq!(frame.pictures[2].planes[0].samples()[..4], [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
    for node in ["not", "off"] {
        assert_eq!(*state(&frame, node), State::LeftOut(LeftOut::Disabled));
    }
    assert_eq!(*state(&frame, "y"), State::LeftOut(LeftOut::Unreachable), "only a disabled node asked for it");
}

#[test]
fn negative_zero_changes_no_bit() {
    let nodes = r##"
        "zero": { "type": "Constant", "color": [-0.0, -0.0, -0.0] }, "x": { "type": "ScreenX" },
        "equal": { "type": "Mix", "a": "zero", "b": [-0.0, 0, -0.0], "weight": "x" },
        "kept": { "type": "Mix", "a": [-0.0, 1, 0], "b": "#fff", "weight": 0 },
        "ramp": { "type": "Ramp", "weight": "x", "stops": [{ "at": -0.0, "color": "equal" }] },
        "blend": { "type": "Blend", "colors": ["ramp", "kept", "#fff"], "weights": [-0.0, 1, 0] }"##;
    let outputs = r#""equal": { "color": "equal" }, "kept": { "color": "kept" }, "ramp": { "color": "ramp" },
        "blend": { "color": "blend" }, "zero": { "color": "zero" }"#;
    let frame = under_all_settings(&graph(FORMAT, nodes, outputs), 1, &Buffers::new(), "−0");
    for picture in &frame.pictures {
        let negative = picture.planes.iter().flat_map(|plane| plane.samples()).any(|v| v.is_sign_negative());
        assert!(!negative, "output {} holds −0", picture.output);
    }
}

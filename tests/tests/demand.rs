//! Unneeded nodes are not computed, and the report gives the reason.

use crate::support::{all_bits, bits, evaluate, evaluate_some, graph, settings, state};
use trochoid::{Buffers, Cache, LeftOut, NodeId, Plan, Silent, State, Switches};

const FORMAT: &str = r#""width": 6, "height": 4"#;

/// A sea, its passes, and a picture that needs them only through a weight.
fn sea(weight: &str) -> String {
    format!(
        r##""camera": {{ "type": "Camera" }}, "sun": {{ "type": "Light" }},
        "sea": {{ "type": "GerstnerSea", "count": 8 }},
        "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
        "light": {{ "type": "NonSpecular", "view": "view", "lights": ["sun"] }},
        "depth": {{ "type": "Depth", "view": "view" }},
        "far": {{ "type": "Clamp", "field": "depth", "max": 100 }},
        "water": {{ "type": "Mix", "a": "#123", "b": "#def", "weight": "light" }},
        "across": {{ "type": "ScreenX" }},
        "sky": {{ "type": "Mix", "a": "#fff", "b": "#88a", "weight": "across" }},
        "out": {{ "type": "Mix", {weight} }}"##
    )
}

const OUTPUTS: &str = r#""out": { "color": "out" }, "far": { "weights": "far" }"#;
const SIMULATOR: [&str; 5] = ["camera", "sun", "sea", "view", "light"];

#[test]
fn a_pass_that_nobody_asks_for_is_not_computed() {
    let graph = graph(FORMAT, &sea(r#""a": "sky", "b": "water", "weight": "light""#), OUTPUTS);
    let frame = evaluate_some(&graph, &["out"], 1, &Buffers::new(), &settings(|_| ()));
    for node in ["depth", "far"] {
        assert_eq!(*state(&frame, node), State::LeftOut(LeftOut::Unreachable), "{node}");
    }
    for node in SIMULATOR {
        assert_eq!(*state(&frame, node), State::Evaluated, "{node}");
    }
    let all = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    assert!(all.nodes.iter().all(|report| report.state == State::Evaluated), "both outputs need everything");
    // The number of samples in the report agrees.
    let depth = |frame: &trochoid::Frame| frame.nodes.iter().find(|report| report.name == "depth").unwrap().pixels;
    assert_eq!((depth(&frame), depth(&all)), (0, 24));
}

#[test]
fn a_weight_of_zero_or_one_removes_the_simulator() {
    let cases = [
        r#""a": "sky", "b": "water", "weight": 0"#,
        r#""a": "water", "b": "sky", "weight": 1"#,
        r#""a": "sky", "b": "water", "weight": { "keys": [[1, 0], [3, 1]] }"#,
    ];
    for mix in cases {
        let graph = graph(FORMAT, &sea(mix), OUTPUTS);
        let frame = evaluate_some(&graph, &["out"], 1, &Buffers::new(), &settings(|_| ()));
        for node in SIMULATOR.iter().chain(&["water"]) {
            let why = LeftOut::Weight("out".into());
            assert_eq!(*state(&frame, node), State::LeftOut(why), "{node} of {mix}");
        }
        for node in ["across", "sky"] {
            assert_eq!(*state(&frame, node), State::Evaluated, "{node} of {mix}");
        }
        // Only the sky's colors bound the picture.
        assert_eq!(frame.pictures[0].control_count, 2, "{mix}");
        assert_eq!(frame.pictures[0].audit.hull_exits, 0);
    }
}

#[test]
fn a_weight_proved_by_interval_removes_the_branch() {
    let mix = r#""a": "sky", "b": "water", "weight": "never""#;
    let never = r#", "never": { "type": "Clamp", "field": "across", "min": 2, "max": 3 }"#;
    let graph = graph(FORMAT, &(sea(mix) + never), OUTPUTS);
    let frame = evaluate_some(&graph, &["out"], 1, &Buffers::new(), &settings(|_| ()));
    let why = LeftOut::Weight("out".into());
    assert_eq!(*state(&frame, "sea"), State::LeftOut(why.clone()));
    assert_eq!(why.to_string(), "its weight at \"out\" is proved 0 everywhere");
}

#[test]
fn blends_leave_out_what_has_no_weight() {
    let nodes = sea(r#""a": "sky", "b": "sky", "weight": 0.5"#)
        + r##", "blend": { "type": "Blend", "colors": ["sky", "water", "#fff"], "weights": [0.5, 0, 0.5] }"##;
    let graph = graph(FORMAT, &nodes, r#""blend": { "color": "blend" }"#);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    for node in SIMULATOR {
        let why = LeftOut::Weight("blend".into());
        assert_eq!(*state(&frame, node), State::LeftOut(why), "{node}");
    }
    assert_eq!(*state(&frame, "out"), State::LeftOut(LeftOut::Unreachable));
}

#[test]
fn masks_that_are_multiplied_by_zero_are_not_needed() {
    let nodes = sea(r##""a": "sky", "b": "#000", "weight": "both""##)
        + r#", "bright": { "type": "Clamp", "field": "light", "min": 0.5 },
               "both": { "type": "Multiply", "weights": ["bright", 0] }"#;
    let graph = graph(FORMAT, &nodes, r#""out": { "color": "out" }"#);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    for node in SIMULATOR.iter().chain(&["bright"]) {
        let why = LeftOut::Constant("both".into());
        assert_eq!(*state(&frame, node), State::LeftOut(why), "{node}");
    }
}

#[test]
fn bound_buffers_stand_in_for_what_feeds_them() {
    let graph = graph(FORMAT, &sea(r#""a": "sky", "b": "water", "weight": 0.5"#), OUTPUTS);
    let light = [0.5f32; 24];
    let buffers = Buffers::new().with("light", &[&light]);
    let frame = evaluate_some(&graph, &["out"], 1, &buffers, &settings(|_| ()));
    for node in SIMULATOR {
        assert_eq!(*state(&frame, node), State::LeftOut(LeftOut::Bound), "{node}");
    }
    for node in ["depth", "far"] {
        assert_eq!(*state(&frame, node), State::LeftOut(LeftOut::Unreachable), "{node} feeds nothing asked for");
    }
    assert_eq!(*state(&frame, "water"), State::Evaluated);
}

#[test]
fn unoptimized_plans_compute_what_is_reachable() {
    let graph = graph(FORMAT, &sea(r#""a": "sky", "b": "water", "weight": 0"#), OUTPUTS);
    let off = settings(|s| s.switches = trochoid::Switches::NONE);
    let frame = evaluate(&graph, 1, &Buffers::new(), &off);
    assert!(frame.nodes.iter().all(|report| report.state == State::Evaluated));
}

#[test]
fn what_does_not_change_is_kept_for_the_next_frame() {
    let nodes = sea(r##""a": "sky", "b": { "keys": [[1, [0, 0, 0]], [3, [1, 1, 1]]] }, "weight": "light""##);
    let graph = graph(FORMAT, &nodes, OUTPUTS);
    let mut cache = Cache::new();
    let mut frame = |number: i64| {
        let plan = Plan::new(&graph, &["out"], number, &[], &settings(|_| ())).unwrap();
        plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap()
    };
    let first = frame(1);
    assert!(first.nodes.iter().all(|report| report.state != State::Cached));
    let second = frame(2);
    for node in ["camera", "sun", "across"] {
        assert_eq!(*state(&second, node), State::Cached, "{node} is static");
    }
    for node in ["sea", "view", "light"] {
        assert_eq!(*state(&second, node), State::Evaluated, "{node} moves");
    }
    let again = frame(2);
    assert!(SIMULATOR.iter().all(|node| *state(&again, node) == State::Cached), "the same frame");
    assert_ne!(first.pictures[0].planes, second.pictures[0].planes);
}

#[test]
fn a_keyed_knob_changes_the_key() {
    let nodes = r##"
        "still": { "type": "Camera" }, "moving": { "type": "Camera", "fov": { "keys": [[1, 40], [3, 60]] } },
        "sea": { "type": "GerstnerSea", "count": 0 },
        "a": { "type": "Render", "camera": "still", "surfaces": ["sea"] }, "b": { "type": "Render", "camera": "moving", "surfaces": ["sea"] }"##;
    let graph = graph(FORMAT, nodes, r#""a": { "weights": "a.coverage" }, "b": { "weights": "b.coverage" }"#);
    let keys = |frame: i64| {
        let settled: Vec<_> = (0..graph.nodes().len()).map(|id| Some(graph.settle(NodeId(id), frame))).collect();
        graph.keys(&settled, &graph.frame_context(frame, 1 << 30))
    };
    let (one, two, late, later) = (keys(1), keys(2), keys(50), keys(60));
    let of = |keys: &[trochoid::Key], name: &str| keys[graph.find(name).unwrap().0];
    assert_eq!(of(&one, "still"), of(&two, "still"));
    assert_ne!(of(&one, "moving"), of(&two, "moving"));
    assert_ne!(of(&one, "b"), of(&two, "b"), "keys hold those of everything upstream");
    assert_eq!(of(&late, "moving"), of(&later, "moving"), "beyond the last key nothing changes");
    assert_ne!(of(&late, "sea"), of(&later, "sea"), "seas depend on time");
}

#[test]
fn a_switch_needs_nothing_but_its_choice() {
    let nodes = sea(r#""a": "sky", "b": "sky", "weight": 0.5"#)
        + r##", "missing": { "type": "Read", "file": "missing.exr", "as": "color" },
        "deep": { "type": "Mix", "a": "missing", "b": "water", "weight": "light" },
        "inner": { "type": "Switch", "inputs": ["missing", "deep"], "which": 1 },
        "pick": { "type": "Switch", "inputs": ["sky", "inner"], "which": { "keys": [[1, 0], [5, 1]] } }"##;
    let graph = graph(FORMAT, &nodes, r#""pick": { "color": "pick" }, "sky": { "color": "sky" }"#);
    for switches in [Switches::ALL, Switches::NONE] {
        let frame = evaluate(&graph, 4, &Buffers::new(), &settings(|s| s.switches = switches));
        assert_eq!(bits(&frame.pictures[0]), bits(&frame.pictures[1]));
        for node in SIMULATOR.iter().chain(&["missing", "deep", "inner", "water"]) {
            let why = LeftOut::Switched("pick".into());
            assert_eq!(*state(&frame, node), State::LeftOut(why), "{node}");
        }
        for node in ["pick", "sky", "across"] {
            assert_eq!(*state(&frame, node), State::Evaluated, "{node}");
        }
    }
    assert_eq!(LeftOut::Switched("pick".into()).to_string(), "not chosen by \"pick\"");
    // The reference reads no other input either.
    let reference = trochoid::ReferenceFrame::new(&graph, "pick", 1).unwrap();
    assert_eq!(reference.pixel(0, 0).unwrap().len(), 3);
    // A file is needed only where its input is chosen.
    let files = |frame: i64| {
        let needed = graph.dependencies([graph.find("pick").unwrap()], frame);
        graph.files(&needed, &graph.frame_context(frame, 1 << 30)).len()
    };
    assert_eq!((files(4), files(5)), (0, 1));
    let missing = trochoid::missing_files(&graph);
    assert_eq!(missing.len(), 1);
    assert!(missing[0].found.contains("at frame 5, nor at 95 more frames"), "{}", missing[0].found);
    let plan = Plan::new(&graph, &["pick"], 5, &[], &settings(|_| ())).unwrap();
    assert!(plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).is_err(), "the file is needed from frame 5 on");
    let plan = Plan::new(&graph, &["pick"], 5, &["missing"], &settings(|_| ())).unwrap();
    let left_out = |name: &str| plan.left_out()[graph.find(name).unwrap().0].clone();
    assert_eq!(left_out("missing"), Some(LeftOut::Bound));
    assert_eq!(left_out("sky"), Some(LeftOut::Switched("pick".into())));
    assert_eq!((left_out("inner"), left_out("sea")), (None, None));
}

#[test]
fn a_branch_that_no_output_needs_changes_nothing() {
    let unneeded: String = (0..100)
        .map(|i| format!(r#", "extra{i}": {{ "type": "Read", "file": "missing{i}.exr", "as": "color" }}"#))
        .collect();
    let lean = graph(FORMAT, &sea(r#""a": "sky", "b": "water", "weight": "light""#), OUTPUTS);
    let full = graph(FORMAT, &(sea(r#""a": "sky", "b": "water", "weight": "light""#) + &unneeded), OUTPUTS);
    let frame = evaluate(&full, 1, &Buffers::new(), &settings(|_| ()));
    assert_eq!(all_bits(&frame), all_bits(&evaluate(&lean, 1, &Buffers::new(), &settings(|_| ()))));
    assert_eq!(*state(&frame, "extra99"), State::LeftOut(LeftOut::Unreachable));
}

#[test]
fn files_missing_at_any_frame_are_reported() {
    let text = r##"{ "trochoid": 1, "format": { "width": 2, "height": 2 }, "frames": { "first": 1, "last": 6 },
        "nodes": {
            "late": { "type": "Read", "file": "late.exr", "as": "color" },
            "pick": { "type": "Switch", "inputs": ["#102030", "late"], "which": { "keys": [[1, 0], [5, 1]] } },
            "here": { "type": "Read", "file": "Cargo.toml", "as": "color" },
            "out": { "type": "Mix", "a": "pick", "b": "here", "weight": 0.5 } },
        "outputs": { "out": { "color": "out" } } }"##;
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let missing = trochoid::missing_files(&trochoid::parse("late", text, here, &[]).unwrap().graph);
    let found: Vec<_> = missing.iter().map(|fault| (fault.node.as_deref(), fault.found.as_str())).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].0, Some("late"));
    assert!(found[0].1.ends_with("late.exr at frame 5, nor at 1 more frame"), "{found:?}");
}

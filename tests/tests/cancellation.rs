//! Long work polls for cancellation between its rows, steps or ribbons, in addition to the engine between tiles.

use crate::support::settings;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid::{Buffers, Cache, EvalError, Monitor, Plan, ReferenceError, ReferenceFrame, parse};

/// Monitor that cancels after a number of questions, and counts the questions that the engine and the nodes ask.
struct Fires {
    after: usize,
    asked: AtomicUsize,
    /// Number of stages that began to prepare.
    stages: AtomicUsize,
    /// Number of questions before the last stage began to prepare.
    before_last: AtomicUsize,
}

impl Fires {
    fn after(after: usize) -> Self {
        let zero = AtomicUsize::default;
        Self { after, asked: zero(), stages: zero(), before_last: zero() }
    }

    /// Returns the number of questions since the last stage began to prepare, without those of the engine, so that only
    /// nodes can have asked them. The engine asks once when all stages are prepared, before the only tile, and before
    /// each stage is filled.
    fn by_nodes(&self) -> usize {
        let [asked, stages, before_last] =
            [&self.asked, &self.stages, &self.before_last].map(|count| count.load(Ordering::Relaxed));
        (asked - before_last).saturating_sub(2 + stages)
    }
}

impl Monitor for Fires {
    fn preparing(&self, _: &str) {
        self.stages.fetch_add(1, Ordering::Relaxed);
        self.before_last.store(self.asked.load(Ordering::Relaxed), Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.after
    }
}

/// Nodes that others need; `out` is the node that is cancelled.
const SCENE: &str = r##""camera": { "type": "Camera", "position": [0, 5, 12] }, "sun": { "type": "Light" },
    "up": { "type": "Camera", "position": [0, 5, 12], "target": [0, 20, -30] },
    "sea": { "type": "GerstnerSea", "count": 40, "sharpness": 2 },
    "toon": { "type": "ToonSea", "columns": 16, "rows": 16, "preroll": 1,
        "bursts": [{ "path": [0, 0, 1, 1, 2, 2, 3, 3] }] },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "x": { "type": "ScreenX" }, "image": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" }"##;

#[test]
fn nodes_that_take_long_ask_whether_to_stop() {
    for (out, output) in [
        (r#""type": "Strokes", "image": "image", "view": "view", "layers": [{}]"#, r#""color": "out""#),
        (r#""type": "Strokes", "image": "image", "layers": [{ "spacing": 2 }]"#, r#""color": "out""#),
        (r#""type": "Hooks", "view": "view", "rows": [{ "from": [-5, 0], "to": [5, 0] }]"#, r#""weights": "out""#),
        (r#""type": "Render", "camera": "camera", "surfaces": ["sea"]"#, r#""weights": "out.coverage""#),
        (r#""type": "Blur", "image": "image", "size": 3"#, r#""color": "out""#),
        (r#""type": "Clouds", "camera": "up", "light": "sun", "steps": 64, "layers": [{}]"#, r#""weights": "out""#),
        (r#""type": "Shadow", "view": "view", "lights": ["sun"]"#, r#""weights": "out""#),
        (r#""type": "FlowField", "view": "view""#, r#""field": "out""#),
        (r#""type": "FlowField", "field": "x", "along": "contour", "smooth": 4"#, r#""field": "out""#),
        (r#""type": "Spray", "view": "view", "sea": "sea""#, r#""weights": "out""#),
        (
            r#""type": "Spray", "view": "view", "bursts": [{ "time": -0.5, "position": [0, 5, 0] }]"#,
            r#""weights": "out""#,
        ),
        (r#""type": "Bake", "sea": "sea", "tolerance": 1e-6"#, r#""field": "out.height""#),
        (r#""type": "Bake", "sea": "sea", "tolerance": 1e-3"#, r#""field": "out.normal""#),
        (r#""type": "Bake", "sea": "toon""#, r#""field": "out.normal""#),
    ] {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 64, "height": 48 }}, "nodes": {{ {SCENE},
                "out": {{ {out} }} }}, "outputs": {{ "out": {{ {output} }} }} }}"#
        );
        let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let plan =
            Plan::new(&loaded.graph, &[], 1, &[], &settings(|s| (s.threads, s.tile) = (1, Some((64, 64))))).unwrap();
        let run = |after: usize| {
            let monitor = Fires::after(after);
            (plan.evaluate(&Buffers::new(), &mut Cache::new(), &monitor), monitor)
        };
        // The node completes if it is not cancelled.
        let (through, counted) = run(usize::MAX);
        assert!(through.is_ok(), "{out}");
        assert!(counted.by_nodes() > 0, "{out}: only the engine asks");
        // It stops at whichever question is the first to be answered with yes.
        let all = counted.asked.load(Ordering::Relaxed);
        for after in (0..all.min(40)).chain([all / 2, all - 1]) {
            let (stopped, _) = run(after);
            assert!(matches!(stopped, Err(EvalError::Cancelled)), "{out}: after {after} of {all} answers");
        }
    }
}

/// Tests that the f64 run of a toon sea stops between its steps, and that a run after that is as if there had been none.
#[test]
fn references_that_take_long_ask_whether_to_stop() {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 8, "height": 6 }}, "nodes": {{ {SCENE},
            "long": {{ "type": "ToonSea", "columns": 12, "rows": 9, "preroll": 400,
                "bursts": [{{ "path": [0, 0, 1, 1, 1, 0, 0, 1] }}] }},
            "out": {{ "type": "Bake", "sea": "long", "width": 1, "depth": 1 }} }},
            "outputs": {{ "out": {{ "field": "out.height" }} }} }}"#
    );
    let graph = parse("test.json", &text, Path::new("."), &[]).unwrap().graph;
    let run = |after: usize, cache: &mut Cache| {
        let monitor = Fires::after(after);
        let reference = ReferenceFrame::prepared(&graph, &["out"], 1, cache, &monitor);
        (reference.map(|frame| frame.pixel(5, 3).unwrap()), monitor.asked.load(Ordering::Relaxed))
    };
    let (through, asked) = run(usize::MAX, &mut Cache::new());
    // One question for each step in f32, and one for each in f64.
    assert!(asked > 800, "{asked}");
    for after in [asked - 300, asked - 2] {
        let mut cache = Cache::new();
        let (stopped, _) = run(after, &mut cache);
        assert!(matches!(stopped, Err(ReferenceError::Eval(EvalError::Cancelled))), "{stopped:?}");
        assert_eq!(run(usize::MAX, &mut cache).0, through);
    }
}

/// Tests that a single pixel stops, since filters of filters read very many points for one.
#[test]
fn a_pixel_of_the_references_asks_whether_to_stop() {
    let text = r##"{ "trochoid": 1, "format": { "width": 32, "height": 24 }, "nodes": {
        "x": { "type": "ScreenX" }, "image": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" },
        "once": { "type": "Blur", "image": "image", "size": 3 },
        "twice": { "type": "Blur", "image": "once", "size": 3 } },
        "outputs": { "out": { "color": "twice" } } }"##;
    let graph = parse("test.json", text, Path::new("."), &[]).unwrap().graph;
    let reference = ReferenceFrame::new(&graph, "out", 1).unwrap();
    let run = |after: usize| {
        let monitor = Fires::after(after);
        (reference.pixels(&[[16, 12]], &monitor), monitor.asked.load(Ordering::Relaxed))
    };
    let (through, asked) = run(usize::MAX);
    assert!(through.is_ok() && asked > 100, "{asked}");
    for after in [0, 1, asked / 2, asked - 1] {
        let (stopped, _) = run(after);
        assert!(matches!(stopped, Err(EvalError::Cancelled)), "after {after} of {asked}: {stopped:?}");
    }
}

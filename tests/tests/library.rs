//! Features for other renderers: regions and cancellation.

use crate::support::{all_bits, evaluate, graph, is_alone, settings};
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, Heap, Monitor, Pictures, Plan, PlanError, Settings, Silent, Window,
};

const WIDTH: usize = 61;
const HEIGHT: usize = 9;
const AREA: usize = WIDTH * HEIGHT;

/// A document with everything that a renderer may bind: masks, a field, weights, colors.
fn shaded() -> CheckedGraph {
    let nodes = r##"
        "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
        "sun": { "type": "Light" }, "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "light": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
        "depth": { "type": "Depth", "view": "view" },
        "far": { "type": "Clamp", "field": "depth", "min": 2, "max": 60, "smooth": true, "power": 2.5 },
        "layers": { "type": "Stack", "weights": ["light", "far"] },
        "paint": { "type": "Constant", "color": "#8b9aa1" },
        "bands": { "type": "Bands", "field": "depth", "thresholds": [0.25, 0.5], "width": 0.125 },
        "banded": { "type": "Blend", "colors": ["#274e53", "paint", "#f4ecc6"], "weights": "bands" },
        "layered": { "type": "Blend", "colors": ["banded", [2, 0.5, 0], "paint"], "weights": "layers" },
        "out": { "type": "Mix", "a": "paint", "b": "layered", "weight": "light" }"##;
    let outputs = r#""out": { "color": "out" }, "paint": { "color": "paint" }, "light": { "weights": "light" },
        "layers": { "weights": "layers" }, "depth": { "field": "depth" }"#;
    graph(&format!(r#""width": {WIDTH}, "height": {HEIGHT}"#), nodes, outputs)
}

/// Returns pseudorandom numbers, including −0 and both ends.
fn noise(seed: u32, scale: f32) -> Vec<f32> {
    let mut state = seed.wrapping_mul(747_796_405).wrapping_add(1);
    (0..AREA)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match state >> 29 {
                0 => -0.0,
                1 => scale,
                _ => (state >> 8) as f32 / 16_777_216.0 * scale,
            }
        })
        .collect()
}

#[test]
fn a_region_is_the_crop_of_the_picture() {
    let light = noise(1, 1.0);
    let buffers = Buffers::new().with("light", &[&light]);
    for samples in [1, 4] {
        let graph = shaded();
        let format = trochoid::Format::new(WIDTH as u32, HEIGHT as u32, samples).unwrap();
        let graph = graph.with_format(format);
        let whole = evaluate(&graph, 1, &buffers, &settings(|_| ()));
        for region in [Window::new(7, 2, 40, 8), Window::new(-5, -5, 3, 1), Window::new(60, 8, 61, 9)] {
            for tile in [(256, 16), (3, 2)] {
                let part =
                    evaluate(&graph, 1, &buffers, &settings(|s| (s.region, s.tile) = (Some(region), Some(tile))));
                let window = region.intersect(format.window());
                assert_eq!(part.window, window);
                for (whole, part) in whole.pictures.iter().zip(&part.pictures) {
                    for (whole, part) in whole.planes.iter().zip(&part.planes) {
                        assert_eq!(part.window(), window);
                        for y in window.y0..window.y1 {
                            let crop = &whole.row(y).unwrap()[window.x0 as usize..window.x1 as usize];
                            let bits = |row: &[f32]| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                            assert_eq!(bits(crop), bits(part.row(y).unwrap()), "row {y} of {region}");
                        }
                    }
                }
            }
        }
        let beyond = settings(|s| s.region = Some(Window::new(WIDTH as i64, 0, 100, 5)));
        assert!(matches!(Plan::new(&graph, &[], 1, &[], &beyond), Err(PlanError::Region { .. })));
    }
}

/// Monitor that cancels after this many questions.
struct Impatient {
    left: AtomicUsize,
}

impl Monitor for Impatient {
    fn cancelled(&self) -> bool {
        self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

#[test]
fn cancelled_evaluations_say_so() {
    let graph = shaded();
    let plan = Plan::new(&graph, &[], 1, &[], &settings(|s| (s.tile, s.threads) = (Some((4, 4)), 2))).unwrap();
    let expected = all_bits(&plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap());
    let mut cache = Cache::new();
    // The number of questions in a run that is not cancelled.
    let counter = Impatient { left: AtomicUsize::new(usize::MAX) };
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &counter).unwrap();
    let all = usize::MAX - counter.left.into_inner();
    for left in [0, 1, all / 8, all / 4, all / 2] {
        let monitor = Impatient { left: AtomicUsize::new(left) };
        let result = plan.evaluate(&Buffers::new(), &mut cache, &monitor);
        assert_eq!(result.err(), Some(EvalError::Cancelled), "after {left} questions");
    }
    // The cache entries of a cancelled run do no harm.
    let frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
    assert_eq!(all_bits(&frame), expected);
}

#[test]
fn pictures_beyond_the_limit_are_refused_before_they_are_allocated() {
    if !is_alone("library::pictures_beyond_the_limit_are_refused_before_they_are_allocated") {
        return;
    }
    // Returns the most memory that was taken at once, in bytes.
    let taken = |run: &mut dyn FnMut()| {
        let before = Heap::taken();
        Heap::forget_peak();
        run();
        Heap::peak() - before
    };
    let nodes = r##""x": { "type": "ScreenX" }, "out": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" }"##;
    let graph = graph(r#""width": 1048576, "height": 2047, "samples": 16"#, nodes, r#""out": { "color": "out" }"#);
    let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap();
    let mut result = None;
    let bytes = taken(&mut || result = Some(plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent)));
    match result.unwrap() {
        Err(error @ EvalError::TooMuchMemory { total, .. }) => {
            assert!(total > (1 << 20) * 2047 * 12);
            assert!(error.to_string().contains("\"width\" and \"height\""), "{error}");
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
    assert!(bytes < 1 << 20, "{bytes} bytes were taken");
    // Handed on row by row, they take the memory of a few rows.
    let one = settings(|s| s.threads = 1);
    let plan = Plan::new(&graph, &[], 1, &[], &one).unwrap();
    assert!(plan.memory(Pictures::Rows).total() < 2 << 30);
    // A part of the same picture fits, and its pixels are counted.
    let part = settings(|s| s.region = Some(Window::new(1_000_000, 1900, 1_001_024, 2000)));
    let bytes = taken(&mut || assert_eq!(evaluate(&graph, 1, &Buffers::new(), &part).pictures[0].audit.hull_exits, 0));
    assert!(bytes >= 1024 * 100 * 12, "{bytes} bytes were taken");
}

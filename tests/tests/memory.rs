//! Memory of frames: estimates agree with measurements, and frames that need too much are refused.

use crate::support::{graph, root, settings};
use trochoid::{Buffers, Cache, EvalError, Format, MemoryConsumer, Pictures, Plan, Settings, Silent};

/// Maximum ratio between estimated and measured memory, in either direction.
const NEAR: f64 = 6.0;
/// Size in bytes up to which differences are ignored.
const SMALL: u64 = 9_000_000;

#[test]
fn the_memory_of_scenes_is_estimated_to_its_order_of_magnitude() {
    for name in ["glow", "spray", "open_sea", "toon_sea", "two_seas", "from_passes", "bake_sea", "stormy_sea_bare"] {
        let graph = trochoid::load(&root().join(format!("graphs/{name}.json")), &[]).unwrap().graph;
        let samples = graph.format().samples();
        let graph = graph.with_format(Format::new(480, 270, samples).unwrap());
        let plan = Plan::new(&graph, &[], graph.frames().0, &[], &Settings::default()).unwrap();
        let account = plan.memory(Pictures::Whole);
        let nodes = account.consumers.iter().filter(|(consumer, ..)| matches!(consumer, MemoryConsumer::Node(_)));
        let reckoned: u64 = nodes.map(|(_, bytes, _)| bytes).sum();
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        let found: u64 = frame.nodes.iter().map(|node| node.bytes as u64).sum();
        let near = |a: u64, b: u64| a <= SMALL || a as f64 <= NEAR * b as f64;
        assert!(near(reckoned, found) && near(found, reckoned), "{name}: estimated {reckoned}, found {found}");
    }
}

#[test]
fn a_frame_beyond_the_limit_is_refused_with_what_takes_most() {
    let nodes = r#""camera": { "type": "Camera" }, "sea": { "type": "RippleSea" },
        "seen": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "depth": { "type": "Depth", "view": "seen" }"#;
    let graph = graph(r#""width": 800, "height": 600"#, nodes, r#""depth": { "field": "depth" }"#);
    let tight = settings(|settings| settings.memory_limit = 20_000_000);
    let plan = Plan::new(&graph, &[], 1, &[], &tight).unwrap();
    match plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent) {
        Err(error @ EvalError::TooMuchMemory { total, limit, .. }) => {
            assert!(total > limit && limit == 20_000_000);
            let text = error.to_string();
            for words in
                ["\"seen\" (Render)", "pictures 1.9 MB", "expected at most 20.0 MB", "\"width\" and \"height\""]
            {
                assert!(text.contains(words), "no {words} in: {text}");
            }
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
    assert!(plan.check_memory(&plan.memory(Pictures::Whole)).is_err());
    let enough = settings(|settings| settings.memory_limit = 100_000_000);
    let plan = Plan::new(&graph, &[], 1, &[], &enough).unwrap();
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
}

#[test]
fn what_nodes_share_counts_once() {
    let both = |more: &str| {
        let nodes = format!(
            r#""camera": {{ "type": "Camera" }}, "sun": {{ "type": "Light" }}, "sea": {{ "type": "RippleSea" }},
            "seen": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
            "a": {{ "type": "Shadow", "view": "seen", "lights": ["sun"] }},
            "b": {{ "type": "Shadow", "view": "seen", "lights": ["sun"], "bias": 3 {more} }},
            "out": {{ "type": "Multiply", "weights": ["a", "b"] }}"#
        );
        let graph = graph(r#""width": 800, "height": 600"#, &nodes, r#""out": { "weights": "out" }"#);
        Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap().memory(Pictures::Rows).total()
    };
    assert!(both("") + 5_000_000 < both(r#", "detail": 1.9"#));
}

#[test]
fn with_little_memory_fewer_threads_make_the_same_picture() {
    let nodes = r##""noise": { "type": "Noise", "scale": 0.3 },
        "mask": { "type": "Clamp", "field": "noise", "min": -1, "max": 1 },
        "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "mask" },
        "soft": { "type": "Blur", "image": "mix", "size": 9 }"##;
    let graph = graph(r#""width": 900, "height": 600"#, nodes, r#""soft": { "color": "soft" }"#);
    let evaluate = |limit: u64| {
        let eight = settings(|settings| (settings.threads, settings.memory_limit) = (8, limit));
        let plan = Plan::new(&graph, &[], 1, &[], &eight).unwrap();
        let account = plan.memory(Pictures::Whole);
        let picture =
            plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).map(|mut frame| frame.pictures.remove(0));
        (account, picture)
    };
    let (all, whole) = evaluate(1 << 30);
    assert_eq!(all.workers(), 8);
    let tiles = all.consumers.iter().find(|(consumer, ..)| *consumer == MemoryConsumer::Tiles).unwrap().1;
    let (few, short) = evaluate(all.total() - tiles + tiles / 2);
    assert_eq!((few.workers(), few.total()), (4, all.total() - tiles / 2));
    assert_eq!(short.unwrap().planes, whole.unwrap().planes);
    let (_, none) = evaluate(all.total() / 20);
    assert!(none.unwrap_err().to_string().contains("tiles of one thread"));
}

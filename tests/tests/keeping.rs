//! Planes that stages filled are cached for the next evaluation: pictures stay bit-identical, an edit fills again only
//! what depends on it, and changed files and buffers are noticed.

use crate::support::{all_bits, evaluate, evaluate_again, graph, graph_in, root, settings, write_exr};
use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid::{Buffers, Cache, CheckedGraph, Format, Frame, Keep, Monitor, Pictures, Plan, Settings, Silent, Window};

/// Two blurred passes, of which one depends on a color, and a program behind both.
fn painting(dark: &str, size: f64) -> CheckedGraph {
    let nodes = format!(
        r##""x": {{ "type": "ScreenX" }},
        "tooth": {{ "type": "Noise", "scale": 0.3 }},
        "soft": {{ "type": "Blur", "image": "tooth", "size": 1.5 }},
        "t": {{ "type": "Clamp", "field": "soft", "min": 0.2, "max": 0.8 }},
        "paint": {{ "type": "Mix", "a": "{dark}", "b": "#f0e0a0", "weight": "x" }},
        "smear": {{ "type": "Blur", "image": "paint", "size": {size} }},
        "out": {{ "type": "Mix", "a": "smear", "b": "#804020", "weight": "t" }}"##
    );
    graph(r#""width": 40, "height": 24"#, &nodes, r#""out": { "color": "out" }"#)
}

fn keeping() -> Settings {
    settings(|s| (s.keep, s.threads, s.tile) = (Keep::ForEdits, 2, Some((16, 4))))
}

/// Returns the number of samples that a node computed.
fn computed(frame: &Frame, node: &str) -> u64 {
    frame.nodes.iter().find(|report| report.name == node).unwrap().pixels
}

fn again(graph: &CheckedGraph, settings: &Settings, cache: &mut Cache) -> Frame {
    let frame = evaluate_again(graph, 1, &Buffers::new(), settings, cache);
    let plain = evaluate(graph, 1, &Buffers::new(), &self::settings(|_| ()));
    assert!(all_bits(&frame) == all_bits(&plain), "the bits differ from those without a cache");
    frame
}

#[test]
fn an_edit_fills_again_only_what_depends_on_it() {
    let mut cache = Cache::new();
    let area = 40 * 24;
    let frame = again(&painting("#102030", 2.0), &keeping(), &mut cache);
    assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [area; 3]);
    let frame = again(&painting("#304050", 2.0), &keeping(), &mut cache);
    assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [0, 0, area]);
    // The earlier color is still in the cache, but not with another filter.
    let frame = again(&painting("#102030", 2.0), &keeping(), &mut cache);
    assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [0; 3]);
    let frame = again(&painting("#102030", 2.25), &keeping(), &mut cache);
    assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [0, 0, area]);
    // At another size nothing can be reused.
    let smaller = painting("#102030", 2.25).with_format(Format::new(20, 12, 1).unwrap());
    let frame = again(&smaller, &keeping(), &mut cache);
    assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [area / 4; 3]);
}

/// Samples may share the results of the pixel's first one, which must be told apart where planes are known.
#[test]
fn whole_pictures_of_several_samples_keep_what_an_edit_leaves() {
    let edits = [
        ("stormy_sea", "beauty.amount=0.1", &["painted/painted", "spray/spray", "view"][..]),
        ("stormy_sea", "palette.sun=#ffd080", &["spray/spray", "view", "passes/veins"]),
        ("stormy_sea", "painted.lost=0.5", &["view", "painted/flow"]),
        ("toon_teapot", "beauty.ink=#402030", &["beauty/contour", "view"]),
        ("toon_sea", "beauty.paper=#e0e0e0", &["drawn/contour", "sea/grain", "view"]),
        ("cartoon_bay", "haze.max=300", &["things", "inked/contour"]),
        ("from_passes", "palette.lit_far_right=#204060", &["view"]),
    ];
    for (scene, edit, kept) in edits {
        let path = root().join(format!("graphs/{scene}.json"));
        let scene = |set: &[String]| {
            let graph = trochoid::load(&path, set).unwrap_or_else(|error| panic!("{error}")).graph;
            let shading = graph.format().shading();
            graph.with_scaled_format(Format::new(96, 54, 4).unwrap().with_shading(shading))
        };
        let mut cache = Cache::new();
        let settings = settings(|s| (s.keep, s.threads, s.tile) = (Keep::ForEdits, 2, Some((40, 20))));
        let before = again(&scene(&[]), &settings, &mut cache);
        // The same picture once more takes nothing, and the edited one only what depends on the edit.
        let same = again(&scene(&[]), &settings, &mut cache);
        let edited = again(&scene(&[edit.into()]), &settings, &mut cache);
        for node in kept.iter().filter(|node| before.nodes.iter().any(|known| known.name == **node && known.pixels > 0))
        {
            assert_eq!((computed(&same, node), computed(&edited, node)), (0, 0), "{edit}: {node}");
        }
        assert!(all_bits(&same) != all_bits(&edited), "{edit}");
    }
}

#[test]
fn parts_and_buffers_are_never_kept() {
    let mut cache = Cache::new();
    let graph = painting("#102030", 2.0);
    again(&graph, &keeping(), &mut cache);
    let part = settings(|s| (s.keep, s.region) = (Keep::ForEdits, Some(Window::new(3, 3, 9, 9))));
    assert_eq!(computed(&evaluate_again(&graph, 1, &Buffers::new(), &part, &mut cache), "soft"), 36);
    let several = graph.clone().with_format(Format::new(40, 24, 4).unwrap());
    let soft = [(); 2].map(|()| computed(&again(&several, &keeping(), &mut cache), "soft"));
    assert_eq!(soft, [4 * 40 * 24, 0]);
    let held = cache.bytes();
    for level in [0.25_f32, 0.5] {
        let plane = vec![level; 40 * 24];
        let buffers = Buffers::new().with("x", &[&plane]);
        let frame = evaluate_again(&graph, 1, &buffers, &keeping(), &mut cache);
        assert!(all_bits(&frame) == all_bits(&evaluate(&graph, 1, &buffers, &settings(|_| ()))), "x of {level}");
    }
    assert_eq!(cache.bytes(), held, "what depends on the caller's buffers is not kept");
}

/// Colors average the samples of pixels, and fields are taken at the middle of pixels: neither has the planes of the other.
#[test]
fn fields_and_colors_of_a_node_keep_their_own_samples() {
    let nodes = r##""x": { "type": "ScreenX" },
        "tooth": { "type": "Noise", "scale": 0.1 },
        "soft": { "type": "Blur", "image": "tooth", "size": 1.5 },
        "t": { "type": "Clamp", "field": "soft", "min": 0.2, "max": 0.8 },
        "out": { "type": "Mix", "a": "#102030", "b": "#804020", "weight": "t" }"##;
    let format = r#""width": 40, "height": 24, "samples": 4"#;
    let color = graph(format, nodes, r#""out": { "color": "out" }"#);
    let field = graph(format, nodes, r#""out": { "field": "soft" }"#);
    let mut cache = Cache::new();
    for graph in [&color, &field, &color, &field] {
        again(graph, &keeping(), &mut cache);
    }
}

#[test]
fn a_changed_file_is_read_again_by_the_same_plan() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let text = r##"{ "trochoid": 1, "format": { "width": 6, "height": 2 },
        "nodes": { "read": { "type": "Read", "file": "a.exr", "as": "weights", "channels": ["m"] },
            "soft": { "type": "Blur", "image": "read", "size": 1 },
            "out": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "soft" } },
        "outputs": { "out": { "color": "out" } } }"##;
    let mut cache = Cache::new();
    write_exr(&path, 6, 2, &[("m", &[0.25; 12])]);
    let graph = graph_in(folder.path(), text);
    let plan = trochoid::Plan::new(&graph, &[], 1, &[], &keeping()).unwrap();
    let mut level = || {
        let frame = plan.evaluate(&Buffers::new(), &mut cache, &trochoid::Silent).unwrap();
        frame.pictures[0].planes[0].samples()[0]
    };
    let before = level();
    assert_eq!(level().to_bits(), before.to_bits());
    // Another length shows that the file has changed, even if the clock is coarse.
    write_exr(&path, 6, 2, &[("m", &[0.75; 12]), ("n", &[0.5; 12])]);
    assert!(level() > 2.0 * before);
}

#[test]
fn nothing_is_kept_beyond_the_limit() {
    let graph = painting("#102030", 2.0);
    let mut cache = Cache::with_limit(5000);
    for _ in 0..3 {
        again(&graph, &keeping(), &mut cache);
        assert!(cache.bytes() <= 5000);
    }
}

/// Where there is no room for all planes, what stands before those that are known is not filled again.
#[test]
fn what_only_known_planes_read_is_not_filled() {
    let graph = painting("#102030", 2.0);
    let plane = 40 * 24 * 4;
    // The soft noise, but not the noise before it, nor the smeared color.
    let mut cache = Cache::new();
    again(&graph, &settings(|_| ()), &mut cache);
    let mut cache = Cache::with_limit(cache.bytes() + plane + plane / 2);
    again(&graph, &keeping(), &mut cache);
    for color in ["#102030", "#304050"] {
        let frame = again(&painting(color, 2.0), &keeping(), &mut cache);
        assert_eq!(["tooth", "soft", "smear"].map(|node| computed(&frame, node)), [0, 0, 40 * 24], "{color}");
    }
}

/// During playback, planes are kept that are the same at the next frame, and only those.
#[test]
fn what_does_not_move_is_kept_over_frames() {
    let graph = graph(
        r#""width": 40, "height": 24"#,
        r##""tooth": { "type": "Noise", "scale": 0.3 }, "soft": { "type": "Blur", "image": "tooth", "size": 1.5 },
            "drift": { "type": "Noise", "scale": 0.2, "offset": { "keys": [[1, [0, 0, 0]], [9, [1, 0, 0]]] } },
            "t": { "type": "Clamp", "field": "soft", "min": 0.2, "max": 0.8 },
            "u": { "type": "Clamp", "field": "drift", "min": 0.2, "max": 0.8 },
            "paint": { "type": "Mix", "a": "#102030", "b": "#f0e0a0", "weight": "u" },
            "out": { "type": "Mix", "a": "paint", "b": "#804020", "weight": "t" }"##,
        r#""out": { "color": "out" }"#,
    );
    let mut cache = Cache::new();
    let settings = settings(|s| (s.keep, s.threads, s.tile) = (Keep::ForFrames, 2, Some((16, 4))));
    let plane = 40 * 24 * 4;
    for frame in 1..6 {
        let found = evaluate_again(&graph, frame, &Buffers::new(), &settings, &mut cache);
        let plain = evaluate(&graph, frame, &Buffers::new(), &self::settings(|_| ()));
        assert!(all_bits(&found) == all_bits(&plain), "frame {frame}");
        let still = if frame == 1 { 40 * 24 } else { 0 };
        assert_eq!(["soft", "drift"].map(|node| computed(&found, node)), [still, 40 * 24], "frame {frame}");
        cache.forget_unused();
        assert!(cache.bytes() < 4 * plane, "what moves is not kept: {} bytes", cache.bytes());
    }
}

/// Where something moves before a camera at rest, what does not move is seen as in the frame before: in any order of frames,
/// after a change and back, and in playback, which keeps planes too.
#[test]
fn still_surfaces_of_a_view_are_prepared_once() {
    let scene = |rise: f64| {
        let patch = |[x, y, z]: [f64; 3]| {
            let corners = [[-9.0, 2.0], [3.0, 2.0], [-9.0, -6.0], [3.0, -6.0]];
            let corners = corners.map(|[dx, dz]| format!(r#"{{ "at": [{}, {y}, {}] }}"#, x + dx, z + dz));
            format!(r#""type": "BezierModel", "patches": [{{ "points": [{}] }}]"#, corners.join(", "))
        };
        let nodes = format!(
            r#""camera": {{ "type": "Camera", "position": [0, 4, 12] }},
            "table": {{ {} }}, "shelf": {{ {} }},
            "lid": {{ {}, "rotate": {{ "keys": [[1, [0, 0, 0]], [9, [0, 90, 40]]] }} }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["table", "lid", "shelf"] }},
            "height": {{ "type": "Height", "view": "view" }}, "object": {{ "type": "ObjectMask", "view": "view", "surfaces": ["shelf"] }}"#,
            patch([0.0, 0.0, 0.0]),
            patch([1.0, rise, -3.0]),
            patch([2.0, 1.0, 1.0]),
        );
        graph(
            r#""width": 48, "height": 32"#,
            &nodes,
            r#""height": { "field": "height" }, "object": { "weights": "object" }"#,
        )
    };
    let kept = |frame: &Frame| frame.nodes.iter().find(|node| node.name == "view").unwrap().kept;
    for keep in [Keep::Nothing, Keep::ForFrames] {
        let settings = settings(|s| (s.keep, s.threads, s.tile) = (keep, 2, Some((16, 8))));
        let mut cache = Cache::new();
        let mut held = Vec::new();
        // Frame, height of the shelf, and surfaces that are as in the frame before.
        for (frame, rise, expected) in
            [(1, 2.0, 0), (2, 2.0, 2), (5, 2.0, 2), (3, 2.0, 2), (4, 2.5, 1), (3, 2.5, 2), (2, 2.0, 1), (6, 2.0, 2)]
        {
            let graph = scene(rise);
            let found = evaluate_again(&graph, frame, &Buffers::new(), &settings, &mut cache);
            let off = self::settings(|s| s.switches = trochoid::Switches::NONE);
            let plain = evaluate(&graph, frame, &Buffers::new(), &off);
            assert!(all_bits(&found) == all_bits(&plain), "frame {frame}");
            assert_eq!((kept(&found), kept(&plain)), (expected, 0), "frame {frame}, {keep:?}");
            cache.forget_unused();
            held.push(cache.bytes());
        }
        // What only earlier frames needed is dropped.
        assert!(held.iter().all(|bytes| *bytes < 2 * held[0]), "{held:?}");
    }
}

/// Counts the tiles of all steps.
#[derive(Default)]
struct Tiles(AtomicUsize);

impl Monitor for Tiles {
    fn progress(&self, done: usize, total: usize) {
        assert!(done <= total, "{done} of {total} tiles");
        self.0.fetch_max(total, Ordering::Relaxed);
    }
}

/// Filters that read far around a tile are filled in steps, one after the other, each over the whole picture.
#[test]
fn filters_of_filters_are_filled_in_steps() {
    // The mask is read by the last filter, and nearby by the first one; the drawing by a program too.
    let nodes = r##""x": { "type": "ScreenX" },
        "tooth": { "type": "Noise", "scale": 0.3 },
        "mask": { "type": "Clamp", "field": "tooth", "min": 0.2, "max": 0.8 },
        "paint": { "type": "Mix", "a": "#102030", "b": "#f0e0a0", "weight": "mask" },
        "once": { "type": "Blur", "image": "paint", "size": 11 },
        "drawn": { "type": "Mix", "a": "once", "b": "#804020", "weight": "x" },
        "twice": { "type": "Blur", "image": "drawn", "size": 9 },
        "far": { "type": "Blur", "image": "mask", "size": 13 },
        "both": { "type": "Mix", "a": "twice", "b": "once", "weight": "far" },
        "near": { "type": "Blur", "image": "both", "size": 0.5 },
        "out": { "type": "Mix", "a": "near", "b": "drawn", "weight": "mask" }"##;
    for (samples, keep) in [(1, Keep::ForEdits), (4, Keep::ForEdits), (1, Keep::ForFrames), (4, Keep::ForFrames)] {
        let format = format!(r#""width": 90, "height": 70, "samples": {samples}"#);
        let graph = graph(&format, nodes, r#""out": { "color": "out" }"#);
        let plain = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
        for limit in [0, 90 * 70 * 4 * 3 * samples + 1000, 1 << 24] {
            let settings = settings(|s| (s.keep, s.threads, s.tile) = (keep, 2, Some((32, 16))));
            let plan = Plan::new(&graph, &[], 1, &[], &settings).unwrap();
            let mut cache = Cache::with_limit(limit);
            let tiles = Tiles::default();
            let frame = plan.evaluate(&Buffers::new(), &mut cache, &tiles).unwrap();
            assert!(all_bits(&frame) == all_bits(&plain), "{samples} samples, {keep:?}, {limit} bytes");
            // Four steps of 3 × 5 tiles; or three, where memory is too short to hold what programs compute before filters.
            assert!(tiles.0.into_inner() >= 3 * 3 * 5, "{samples} samples, {keep:?}, {limit} bytes");
            assert!(cache.bytes() <= limit);
            let edited = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
            assert!(all_bits(&edited) == all_bits(&plain), "{samples} samples, {keep:?}, {limit} bytes, again");
        }
        // Whole planes are not made beyond the limit of memory.
        let mut settings = settings(|s| (s.threads, s.tile) = (2, Some((32, 16))));
        let memory = |settings: &Settings| Plan::new(&graph, &[], 1, &[], settings).unwrap().memory(Pictures::Whole);
        let (all, mut steps) = (memory(&settings).total(), HashSet::new());
        for share in 1..=32 {
            settings.memory_limit = all * share / 32;
            let (account, plan) = (memory(&settings), Plan::new(&graph, &[], 1, &[], &settings).unwrap());
            let tiles = Tiles::default();
            let Ok(frame) = plan.evaluate(&Buffers::new(), &mut Cache::with_limit(0), &tiles) else {
                assert!(account.total() > settings.memory_limit, "{samples} samples, {share}/32 of the memory");
                continue;
            };
            assert!(all_bits(&frame) == all_bits(&plain), "{samples} samples, {share}/32 of the memory");
            assert!(account.total() <= settings.memory_limit);
            steps.insert(tiles.0.into_inner() / (3 * 5));
        }
        assert!(steps.len() > 1, "{samples} samples: always {steps:?} steps");
    }
}

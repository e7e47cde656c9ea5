//! A frame is a pure function of document and frame number, independent of earlier evaluations.

use crate::support::{all_bits, evaluate, folder, graph_in, settings, write_exr};
use trochoid::{Buffers, Cache, CheckedGraph, Plan, Silent};

const NODES: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 14, "samples": 4 },
    "frames": { "first": 1, "last": 12, "fps": 24 },
    "nodes": {
        "camera": { "type": "Camera", "position": { "keys": [[1, [0, 3, 12]], [9, [2, 4, 9]]], "interpolation": "monotone" } },
        "sun": { "type": "Light", "direction": [0.3, 0.5, -1] },
        "sea": { "type": "GerstnerSea", "count": 60, "wavelength": 6, "height": 0.8, "seed": 3 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "light": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
        "still": { "type": "Read", "file": "read.exr", "as": "color", "fit": "nearest" },
        "moving": { "type": "Read", "file": "moving.####.exr", "as": "weights", "fit": "bilinear" },
        "sky": { "type": "Mix", "a": "still", "b": "#88a", "weight": "moving" },
        "water": { "type": "Mix", "a": "#123", "b": { "keys": [[1, [0, 0.5, 1]], [8, [1, 1, 0.5]]] }, "weight": "light" },
        "out": { "type": "Mix", "a": "sky", "b": "water", "weight": "view.coverage" },
        "height": { "type": "Height", "view": "view" } },
    "outputs": { "out": { "color": "out" }, "height": { "field": "height" } } }"##;

fn document() -> (tempfile::TempDir, CheckedGraph) {
    let folder = folder();
    for frame in 1..=12 {
        let mask: Vec<f32> = (0..12).map(|i| ((i * frame) % 12) as f32 / 12.0).collect();
        write_exr(&folder.path().join(format!("moving.{frame:04}.exr")), 4, 3, &[("m", &mask)]);
    }
    let graph = graph_in(folder.path(), NODES);
    (folder, graph)
}

#[test]
fn a_frame_alone_equals_the_frame_of_a_run() {
    let (_folder, graph) = document();
    let mut cache = Cache::new();
    let mut run = |number: i64| {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap()
    };
    let frames: Vec<_> = (1..=7).map(&mut run).collect();
    let alone = evaluate(&graph, 7, &Buffers::new(), &settings(|_| ()));
    assert_eq!(all_bits(&frames[6]), all_bits(&alone));
    // Going backward, with a cache of later frames.
    assert_eq!(all_bits(&run(3)), all_bits(&frames[2]));
    assert!(frames.windows(2).all(|pair| all_bits(&pair[0]) != all_bits(&pair[1])), "every frame differs");
    for frame in &frames {
        assert_eq!(frame.pictures[0].audit.hull_exits, 0);
    }
}

#[test]
fn outputs_alone_equal_outputs_together() {
    let (_folder, graph) = document();
    let together = evaluate(&graph, 5, &Buffers::new(), &settings(|_| ()));
    for (index, output) in graph.outputs().iter().enumerate() {
        let plan = Plan::new(&graph, &[&output.name], 5, &[], &settings(|_| ())).unwrap();
        let alone = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        assert_eq!(all_bits(&alone)[0], all_bits(&together)[index], "{}", output.name);
    }
}

#[test]
fn fields_are_taken_at_pixel_centers_whatever_the_samples() {
    let (_folder, graph) = document();
    let format = trochoid::Format::new(24, 14, 1).unwrap();
    let field = |graph: &CheckedGraph| all_bits(&evaluate(graph, 4, &Buffers::new(), &settings(|_| ())))[1].clone();
    assert_eq!(field(&graph), field(&graph.clone().with_format(format)));
}

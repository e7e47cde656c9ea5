//! Planes that are filled over the whole picture before tiles read them; the pictures stay bit-identical.

use crate::support::{all_bits, evaluate, graph, settings, under_all_settings};
use trochoid::{Buffers, Cache, CheckedGraph, HeldPlanes, Plan, Settings, Silent};

/// Several noises, mixed, moved far, and drawn over with one of them; and a picture that is softened only a little.
const NODES: &str = r##""camera": { "type": "Camera", "position": [0, 3, 12], "target": [0, 1, 0], "fov": 50 },
    "waves": { "type": "GerstnerSea", "wavelength": 6, "spread": 1, "height": 1.5, "count": 8, "seed": 3 },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["waves"] },
    "lace": { "type": "Noise", "view": "view", "space": "world", "scale": 0.7 },
    "one": { "type": "Noise", "scale": 0.1 }, "veins": { "type": "Clamp", "field": "one", "min": -0.2, "max": 0.3 },
    "other": { "type": "Noise", "scale": 0.2, "seed": 4 }, "spots": { "type": "Clamp", "field": "other", "min": 0, "max": 0.1 },
    "foam": { "type": "Clamp", "field": "lace", "min": 0, "max": 0.3 },
    "marble": { "type": "Mix", "a": "#234", "b": "#fed", "weight": "veins" },
    "spotted": { "type": "Mix", "a": "marble", "b": "#ff8", "weight": "spots" },
    "water": { "type": "Mix", "a": "spotted", "b": "#fff", "weight": "foam" },
    "swaying": { "type": "Warp", "image": "water", "dx": "shift", "reach": 9 },
    "shift": { "type": "FieldMath", "expression": "8 * a", "a": "one" },
    "drawn": { "type": "Mix", "a": "swaying", "b": "#a41", "weight": "foam" },
    "soft": { "type": "Blur", "image": "water", "size": 0.3 },
    "seen": { "type": "Mix", "a": "soft", "b": "#a41", "weight": "spots" }"##;

fn scene(samples: u32, shading: &str, out: &str) -> CheckedGraph {
    scene_of([60, 40], samples, shading, out)
}

fn scene_of([width, height]: [u32; 2], samples: u32, shading: &str, out: &str) -> CheckedGraph {
    let format = format!(r#""width": {width}, "height": {height}, "samples": {samples}, "shading": "{shading}""#);
    graph(&format, NODES, &format!(r#""out": {{ "color": "{out}" }}"#))
}

fn tiles() -> Settings {
    settings(|s| (s.threads, s.tile) = (2, Some((32, 16))))
}

/// Returns the planes that an evaluation holds, with the names of nodes.
fn held(graph: &CheckedGraph, settings: &Settings) -> Vec<(String, HeldPlanes)> {
    let plan = Plan::new(graph, &[], 1, &[], settings).unwrap();
    let held = plan.held(&mut Cache::new(), &Silent).unwrap();
    held.into_iter().map(|held| (graph.node(held.node).name.clone(), held)).collect()
}

#[test]
fn what_a_program_computes_before_a_filter_is_held() {
    for (samples, shading) in [(1, "sample"), (4, "sample"), (4, "pixel")] {
        let graph = scene(samples, shading, "swaying");
        let all = held(&graph, &tiles());
        let before = all.iter().find(|(name, held)| name == "swaying" && held.before);
        let (_, planes) = before.unwrap_or_else(|| panic!("{samples} samples, {shading}: {all:?}"));
        assert_eq!((planes.channels, planes.bytes), (3, 3 * 60 * 40 * 4 * samples as usize), "{samples} samples");
        under_all_settings(&graph, 1, &Buffers::new(), &format!("{samples} samples, {shading}"));
        let plain = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
        let again = settings(|s| (s.threads, s.tile, s.switches.hold) = (2, Some((32, 16)), false));
        for settings in [tiles(), again] {
            let frame = evaluate(&graph, 1, &Buffers::new(), &settings);
            assert!(all_bits(&frame) == all_bits(&plain), "{samples} samples, {shading}");
        }
    }
}

#[test]
fn what_is_read_before_and_after_a_filter_is_filled_once_or_again() {
    let graph = scene(4, "sample", "drawn");
    let names: Vec<String> = held(&graph, &tiles()).into_iter().map(|(name, _)| name).collect();
    assert!(names.iter().any(|name| name == "lace") && names.iter().any(|name| name == "swaying"), "{names:?}");
    under_all_settings(&graph, 1, &Buffers::new(), "drawn");
}

#[test]
fn nothing_is_held_that_does_not_pay() {
    let near = scene_of([90, 60], 4, "sample", "seen");
    assert_eq!(held(&near, &settings(|s| s.tile = Some((45, 60)))), [], "a filter that reads nearby");
    let far = scene(4, "sample", "swaying");
    assert_eq!(held(&far, &settings(|s| (s.tile, s.switches.hold) = (Some((32, 16)), false))), [], "switched off");
    assert_eq!(held(&far, &settings(|s| s.tile = Some((60, 40)))), [], "a single tile");
}

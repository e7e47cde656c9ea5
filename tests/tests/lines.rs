//! Filters of a view, on passes full of edges, holes and values that no surface has: they agree with their references
//! at every pixel.

use crate::support::on_passes;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SIZE: (u32, u32) = (19, 14);

/// Passes of random plateaus and slopes.
fn passes(random: &mut Pcg64Mcg) -> Vec<(&'static str, Vec<f32>)> {
    let count = (SIZE.0 * SIZE.1) as usize;
    let mut plane = |values: &[f32]| -> Vec<f32> {
        let mut last = values[0];
        let pixels = (0..count).map(|_| {
            if random.random_bool(0.3) {
                last = values[random.random_range(0..values.len())];
            }
            if random.random_bool(0.7) { last } else { last * (1.0 + 0.05 * random.random::<f32>()) }
        });
        pixels.collect()
    };
    let depth = plane(&[2.0, 2.05, 4.0, 40.0, 1e9, 0.0, 9e3, 1e-20]);
    let coverage: Vec<f32> = plane(&[1.0, 1.0, 1.0, 0.0]).into_iter().map(|c| c.min(1.0)).collect();
    let mut passes = vec![("depth.Z", depth), ("A", coverage)];
    for name in ["N.X", "N.Y", "N.Z"] {
        passes.push((name, plane(&[0.0, 0.3, -0.7, 1.0, 0.01])));
    }
    for name in ["P.X", "P.Y", "P.Z"] {
        passes.push((name, plane(&[0.0, 1.0, -2.0, 1e6, 0.5])));
    }
    passes
}

#[test]
fn filters_of_views_agree_with_the_reference_on_hostile_passes() {
    let (width, height) = SIZE;
    let nodes = r#"
        "view": { "type": "ViewFromPasses", "file": "a.exr", "depth": "depth.Z", "coverage": "A", "normal": "N",
            "position": "P", "camera": "camera" },
        "camera": { "type": "Camera", "position": [3, 2, 5] }, "x": { "type": "ScreenX" },
        "near": { "type": "Outline", "view": "view", "width": 1.5 },
        "far": { "type": "Outline", "view": "view", "width": 2.3, "owner": "far", "thickness": "x" },
        "both": { "type": "Outline", "view": "view", "width": 0.6, "owner": "both", "depth_step": 0.5 },
        "last": { "type": "Outline", "view": "view", "width": 3, "owner": "last", "objects": false },
        "cut": { "type": "Silhouette", "view": "view", "cutoff": 0.3, "ramp": 0.4 },
        "line": { "type": "Silhouette", "view": "view", "width": 2 },
        "bend": { "type": "Curvature", "view": "view" },
        "wide": { "type": "Curvature", "view": "view", "reach": 5 },
        "bent": { "type": "FieldMath", "expression": "a/(1 + abs(a))", "a": "bend" },
        "sky": { "type": "Sky", "view": "view", "from": -90 },
        "noise": { "type": "Noise", "view": "view", "space": "world", "kind": "edges", "scale": 0.3 }"#;
    let masks = ["near", "far", "both", "last", "cut", "line", "cut.edge", "sky", "sky.reflected"];
    let mut outputs: Vec<String> =
        masks.iter().map(|mask| format!(r#""{}": {{ "weights": "{mask}" }}"#, mask.replace('.', "_"))).collect();
    outputs.extend(["wide", "bent", "noise"].map(|field| format!(r#""{field}": {{ "field": "{field}" }}"#)));
    for seed in 0..3 {
        let passes = passes(&mut Pcg64Mcg::seed_from_u64(seed));
        on_passes([width, height], &passes, nodes, &outputs, |output, pairs| {
            for (at, [found, truth]) in pairs.iter().enumerate() {
                let near = found == truth || (found - truth).abs() <= 1e-5 * truth.abs().max(1.0);
                assert!(near, "seed {seed}, {output} at {at}: {found}, expected {truth}");
            }
            assert!(pairs.iter().filter(|[_, truth]| *truth != 0.0).count() > 10, "{output} tells nothing");
        });
    }
}

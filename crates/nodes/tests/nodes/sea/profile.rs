//! Tests of profiles, and of what simulated seas reach.

use crate::testing::graph;
use std::path::Path;
use trochoid_graph::{CheckedGraph, FrameTimes, Profile, ProfileLine, Reached};
use trochoid_sea::toon::{Basin, Behavior, Boundary, Burst, Combine, Motion, Rift, ToonSea, TrailFields};

fn sea(knobs: &str) -> CheckedGraph {
    let nodes = format!(
        r#""s": {{ {knobs} }}, "baked": {{ "type": "Bake", "sea": "s" }},
        "out": {{ "type": "FieldMath", "expression": "a", "a": "baked.height" }}"#
    );
    graph("field", &nodes, Path::new(".")).unwrap()
}

fn profile(graph: &CheckedGraph, line: &ProfileLine, time: f64) -> Option<Profile> {
    graph.settle(graph.find("s").unwrap(), 1).node().dynamics().unwrap().profile(line, time)
}

const LINE: ProfileLine = ProfileLine { through: None, direction: 0.0, length: None, points: 101 };

#[test]
fn a_wave_is_the_trochoid_of_the_manual() {
    const WAVE: &str = r#""type": "GerstnerSea", "count": 0, "waves": [{ "wavelength": 8, "amplitude": 0.7,
        "direction": 30, "sharpness": 1.5, "phase": 40, "speed": 2 }]"#;
    let line = ProfileLine { through: Some([3.0, -2.0]), direction: 75.0, length: Some(16.0), points: 101 };
    let found = profile(&sea(WAVE), &line, 1.25).unwrap();
    assert_eq!((found.through, found.length, found.points.len()), ([3.0, -2.0], 16.0, 101));
    let (wave, along) = (30_f64.to_radians(), 75_f64.to_radians());
    let (k, q) = (std::f64::consts::TAU / 8.0, 1.5);
    let mut folded = 0;
    for (index, point) in found.points.iter().enumerate() {
        let rest = 16.0 * (index as f64 / 100.0 - 0.5);
        let (x, z) = (3.0 + rest * along.cos(), -2.0 + rest * along.sin());
        let theta = k * (wave.cos() * x + wave.sin() * z) - k * 2.0 * 1.25 + 40_f64.to_radians();
        let moved = -q / k * theta.sin() * (along - wave).cos();
        assert!((point.along - rest - moved).abs() < 1e-5, "{index}: {point:?}");
        assert!((point.height - 0.7 * theta.cos()).abs() < 1e-5, "{index}: {point:?}");
        // det J = 1 − q·cos θ.
        assert_eq!(point.folded, q * theta.cos() > 1.0, "{index}: {point:?}");
        folded += usize::from(point.folded);
    }
    assert!((10..50).contains(&folded), "{folded}");
}

#[test]
fn a_line_without_a_place_shows_some_of_the_waves_that_carry_the_sea() {
    let two = r#""type": "GerstnerSea", "count": 0, "waves": [{ "wavelength": 30, "amplitude": 2 },
        { "wavelength": 5, "amplitude": 1 }]"#;
    let found = profile(&sea(two), &LINE, 0.0).unwrap();
    assert_eq!(found.through, [0.0, 0.0]);
    assert!((found.length - 3.0 * (4.0 * 30.0 + 5.0) / 5.0).abs() < 1e-9, "{}", found.length);
    // A flat sea has a profile, too.
    let flat = profile(&sea(r#""type": "GerstnerSea", "count": 0"#), &LINE, 0.0).unwrap();
    assert!(flat.points.iter().all(|point| point.height == 0.0 && !point.folded));
    let ripples = profile(&sea(r#""type": "RippleSea", "height": 0.5"#), &LINE, 0.0).unwrap();
    assert!(ripples.points.iter().any(|point| point.height > 0.4));
}

const TOON: &str = r#""type": "ToonSea", "columns": 24, "rows": 16, "spacing": 0.5, "x": 10, "z": 20, "preroll": 6,
    "bursts": [{ "path": [1, 1, 3, 3, 6, 5, 9, 6], "duration": 2, "height": 3, "along": 1.5, "across": 1.5 }]"#;

/// The sea of [`TOON`], made without its node.
fn toon() -> ToonSea {
    let basin = Basin { columns: 24, rows: 16, spacing: 0.5, boundary: Boundary::Replicate };
    let rift = Rift { distance: 1.5, gain: 0.02, decay: 0.01, combine: Combine::Sum };
    let behavior = Behavior { preroll: 6, oriented: true, rift, ..Behavior::default() };
    let path = Burst::along([[1.0, 1.0], [3.0, 3.0], [6.0, 5.0], [9.0, 6.0]]);
    let burst = Burst { duration: 2.0, height: 3.0, influence: [1.5; 2], ..path };
    ToonSea::new(basin, Motion::default(), behavior, vec![burst]).unwrap()
}

#[test]
fn a_toon_sea_has_the_heights_of_its_cells() {
    let graph = sea(TOON);
    // Row 4 of the grid, from the first cell to the last and beyond both.
    let line = ProfileLine { through: Some([10.0 + 5.75, 22.0]), length: Some(11.5 + 2.0), points: 28, ..LINE };
    let found = profile(&graph, &line, 0.4).unwrap();
    let mut simulation = toon().simulate(TrailFields::default());
    let heights = simulation.at(0.4).height[4 * 24..5 * 24].to_vec();
    assert_eq!(found.points.len(), 24, "nothing is beyond the grid");
    for (point, height) in found.points.iter().zip(heights) {
        assert!((point.height - f64::from(height)).abs() < 1e-5, "{point:?}: {height}");
    }
    assert!(found.points.iter().any(|point| point.height.abs() > 0.05));
    // By itself, the line crosses the whole grid in the middle.
    let whole = profile(&graph, &ProfileLine { direction: 90.0, ..LINE }, 0.4).unwrap();
    assert_eq!(whole.through, [15.75, 23.75]);
    assert!((whole.length - 7.5).abs() < 1e-12, "{}", whole.length);
}

#[test]
fn what_a_toon_sea_reaches_is_told_over_all_frames() {
    let graph = sea(TOON);
    let settled = graph.settle(graph.find("s").unwrap(), 1);
    let times = FrameTimes { count: 30, fps: 24.0 };
    let found = settled.node().dynamics().unwrap().reached(times, &|| false).unwrap();
    let mut simulation = toon().simulate(TrailFields { rift: true, drift: false });
    let mut expected = Reached { until: 29.0 / 24.0, heights: [0.0; 2], rift: 0.0 };
    for frame in 0..30 {
        let frame = simulation.at(f64::from(frame) / 24.0);
        for height in frame.height.iter().copied().map(f64::from) {
            expected.heights = [expected.heights[0].min(height), expected.heights[1].max(height)];
        }
        expected.rift = frame.rift.iter().copied().map(f64::from).fold(expected.rift, f64::max);
    }
    assert_eq!(found, expected);
    assert!(found.heights[1] > 0.5 && found.rift > 0.0, "{found:?}");
    let notes = settled.node().notes(times);
    assert!(notes[1].starts_with("over all frames, 1.21 s: heights from"), "{notes:?}");
    // One that is no longer needed ends.
    assert_eq!(settled.node().dynamics().unwrap().reached(times, &|| true), None);
}

#[test]
fn printed_bursts_sink_the_sea_to_the_level_of_the_warning() {
    let sea =
        sea(r#""type": "ToonSea", "columns": 48, "rows": 48, "spacing": 0.5, "mode": "literal", "burst": "literal",
        "preroll": 1200, "bursts": [{ "path": [2, 2, 2, 2, 2, 2, 2, 2], "height": 2, "along": 1, "across": 1 }]"#);
    // −cos 1 · ΣH/(1 − c1 − c2), which the warning in `tests/warnings/seas` states, in the corner far from the burst.
    let line = ProfileLine { through: Some([22.0, 22.0]), length: Some(2.0), ..LINE };
    let found = profile(&sea, &line, 0.0).unwrap();
    for point in found.points {
        assert!((point.height + 21.61).abs() < 0.2, "{point:?}");
    }
}

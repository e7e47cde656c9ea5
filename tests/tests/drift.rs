//! Drift lines over time: they move, and nowhere jump.

use crate::support::{graph_in, root, sample, settings};
use serde_json::{Value, json};
use trochoid::{Buffers, Cache, CheckedGraph, Plan, Silent};

const WIDTH: i64 = 240;
const HEIGHT: i64 = 135;
/// Side of the tiles in which changes are added up.
const TILE: i64 = 16;
const MASKS: [&str; 2] = ["navy_lines", "foam_fingers"];

/// The masks of lines of the toon sea's picture, its water alone, at a frame rate.
fn masks(fps: i64) -> CheckedGraph {
    let text = std::fs::read_to_string(root().join("graphs/toon_sea.json")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["format"] = json!({ "width": WIDTH, "height": HEIGHT, "samples": 1 });
    document["frames"] = json!({ "first": 1, "last": 96 * fps / 24, "fps": fps });
    document["nodes"]["view"]["surfaces"] = json!(["waves"]);
    let outputs = MASKS.map(|mask| (mask.to_string(), json!({ "weights": mask })));
    document["outputs"] = Value::Object(outputs.into_iter().collect());
    graph_in(&root().join("graphs"), &document.to_string())
}

/// How much masks change from frame to frame in half a second, in pixels: on average over the picture, and most in a
/// tile.
fn change(fps: i64) -> Vec<[f64; 2]> {
    let graph = masks(fps);
    let mut cache = Cache::new();
    let mut before: Vec<Vec<f64>> = Vec::new();
    let mut changes = vec![[0.0; 2]; MASKS.len()];
    for number in 1..=fps / 2 + 1 {
        let plan = Plan::new(&graph, &[], number, &[], &settings(|s| s.threads = 2)).unwrap();
        let frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
        let all = |y: i64| (0..WIDTH).map(move |x| (x, y));
        let now: Vec<Vec<f64>> = MASKS
            .iter()
            .map(|mask| {
                let picture = frame.pictures.iter().find(|p| graph.outputs()[p.output].name == *mask).unwrap();
                (0..HEIGHT).flat_map(all).map(|(x, y)| f64::from(sample(picture, 0, x, y))).collect()
            })
            .collect();
        for (index, before) in before.iter().enumerate() {
            assert!(before.iter().sum::<f64>() > 20.0, "{} is drawn", MASKS[index]);
            let across = (WIDTH + TILE - 1) / TILE;
            let mut tiles = vec![0.0; (across * ((HEIGHT + TILE - 1) / TILE)) as usize];
            for (at, (a, b)) in before.iter().zip(&now[index]).enumerate() {
                let (x, y) = (at as i64 % WIDTH, at as i64 / WIDTH);
                tiles[(y / TILE * across + x / TILE) as usize] += (a - b).abs();
            }
            let [mean, most] = &mut changes[index];
            *mean += tiles.iter().sum::<f64>() / (fps / 2) as f64;
            *most = tiles.into_iter().fold(*most, f64::max);
        }
        before = now;
    }
    changes
}

#[test]
fn lines_change_by_half_in_half_the_time_everywhere() {
    // A line that jumps changes a tile by as much however short the time; one that moves, by half.
    let [slow, fast] = [24, 48].map(change);
    for ((mask, slow), fast) in MASKS.iter().zip(&slow).zip(&fast) {
        let ratios = [fast[0] / slow[0], fast[1] / slow[1]];
        assert!(ratios.into_iter().all(|ratio| ratio < 0.65), "{mask}: {ratios:?} on average and at most in a tile");
    }
}

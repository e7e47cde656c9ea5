//! Tests of Bake.

use crate::testing::{Frame, graph, refused};
use std::path::Path;
use trochoid_graph::{MemoryContext, MemoryUse, NodeError, NodeId, Pool, Prepare, Reference};
use trochoid_image::Format;
use trochoid_sea::{ExplicitWave, Sea, Wave};

fn baked(nodes: &str, width: u32, height: u32) -> Result<Frame, NodeError> {
    let graph = graph("field", &format!("{nodes}, {PICKED}"), Path::new(".")).unwrap();
    Frame::new(graph.with_format(Format::new(width, height, 1).unwrap()))
}

const PICKED: &str = r#""out": { "type": "FieldMath", "expression": "a", "a": "b.height" }"#;

/// Returns a generator of numbers from 0 to 1, determined by a seed.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Returns random waves, as JSON and as a sea.
fn waves(count: usize, shortest: f64, random: &mut impl FnMut() -> f64) -> (String, Sea) {
    let mut list = Vec::new();
    let mut sea = Vec::new();
    for _ in 0..count {
        let wave = ExplicitWave {
            wavelength: shortest * libm::exp(4.0 * random()),
            amplitude: random() - 0.3,
            direction: (360.0 * random()).round().to_radians(),
            sharpness: 2.0 * random() / count as f64,
            phase: (360.0 * random()).round().to_radians(),
            speed: None,
        };
        list.push(format!(
            r#"{{ "wavelength": {:?}, "amplitude": {:?}, "direction": {}, "sharpness": {:?}, "phase": {} }}"#,
            wave.wavelength,
            wave.amplitude,
            wave.direction.to_degrees().round(),
            wave.sharpness,
            wave.phase.to_degrees().round(),
        ));
        sea.push(Wave::try_from(wave).unwrap());
    }
    (format!(r#""sea": {{ "type": "GerstnerSea", "count": 0, "waves": [{}] }}"#, list.join(", ")), Sea::new(sea))
}

/// Returns the largest distance of each image from the f64 sum, relative to the given scale of its values.
fn distances(frame: &Frame, scales: [f64; 4]) -> [f64; 4] {
    let id = frame.graph.find("b").unwrap();
    let (width, height) = (frame.context.format.width(), frame.context.format.height());
    let mut worst = [0.0f64; 4];
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let at = [f64::from(x) + 0.25, f64::from(y) + 0.75];
        for output in 0..4 {
            let Reference::Field(truth) = frame.reference(id, output, at) else { unreachable!() };
            for (channel, truth) in truth.into_iter().enumerate() {
                let found = f64::from(frame.filled(id, output, channel, at));
                assert!(found.is_finite());
                worst[output] = worst[output].max((found - truth).abs() / scales[output]);
            }
        }
    }
    worst
}

#[test]
fn images_are_within_the_tolerance_of_the_f64_sum() {
    let mut random = random(3);
    for (count, tolerance) in [(0, 1e-4f64), (1, 1e-4), (7, 1e-6), (60, 1e-4), (300, 1e-3), (300, 1e-6)] {
        for (x, width, depth, shortest) in [(-20.0, 64.0, 30.0, 1.0), (1e7, 0.5, 9.0, 0.05), (3.0, 4e5, 1.0, 2e3)] {
            let (sea, truth) = waves(count, shortest, &mut random);
            let bake = format!(
                r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "x": {x}, "z": -7, "width": {width},
                    "depth": {depth}, "footprint": {}, "tolerance": {tolerance:?} }}"#,
                shortest * random()
            );
            let frame = baked(&bake, 37, 21).unwrap();
            // Normals and Jacobians depend on slopes and strains, whose products grow with their size.
            let steep = truth.derivative_rms(1, 0.0);
            let strain: f64 = truth.waves().iter().map(|wave| wave.compression().powi(2) / 2.0).sum();
            let bend = (1.0 + steep + strain.sqrt()).powi(2);
            let move_rms = truth.height_rms().max(truth.horizontal_rms()).max(1e-3);
            let worst = distances(&frame, [truth.height_rms().max(1e-3), bend, move_rms, bend]);
            let exact = tolerance.max(2e-6) + 2e-7;
            for (output, worst) in worst.into_iter().enumerate() {
                // A normal is a direction: near a fold, a small error turns it far.
                let limit = if output == 1 { 40.0 * exact } else { 4.0 * exact };
                assert!(worst <= limit, "{count} waves, {tolerance}, {width} m, output {output}: {worst}");
            }
        }
    }
}

#[test]
fn the_axis_that_points_up_turns_vectors() {
    let (sea, _) = waves(5, 3.0, &mut random(8));
    let nodes = |up: &str| format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "up": "{up}" }}"#);
    let [y, z] = ["y", "z"].map(|up| baked(&nodes(up), 6, 5).unwrap());
    let id = y.graph.find("b").unwrap();
    for output in [1, 2] {
        let [y, z] = [&y, &z].map(|frame| [0, 1, 2].map(|c| frame.filled(id, output, c, [3.5, 1.5])));
        assert_eq!([y[0], -y[2], y[1]], z);
    }
}

#[test]
fn a_toon_sea_is_baked_and_rests_where_it_ends() {
    let sea = r#""sea": { "type": "ToonSea", "columns": 32, "rows": 24, "spacing": 0.5, "preroll": 40,
        "bursts": [{ "path": [4, 4, 6, 6, 8, 6, 12, 8], "height": 3, "along": 3, "across": 2 }] }"#;
    let bake = format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "x": -4, "z": -4, "width": 24, "depth": 20 }}"#);
    let frame = baked(&bake, 30, 25).unwrap();
    let worst = distances(&frame, [1.0; 4]);
    assert!(worst.iter().all(|worst| *worst < 2e-5), "{worst:?}");
    let id = frame.graph.find("b").unwrap();
    assert_eq!(frame.filled(id, 0, 0, [0.5, 0.5]), 0.0);
    let highest = (0..25).map(|y| frame.filled(id, 0, 0, [14.5, f64::from(y) + 0.5])).fold(0.0, f32::max);
    assert!(highest > 0.02, "{highest}");
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let model = r#""sea": { "type": "BezierModel", "patches": [{ "points": [{ "at": [0, 0, 0] },
        { "at": [1, 0, 0] }, { "at": [0, 0, 1] }, { "at": [1, 0, 1] }] }] },
        "b": { "type": "Bake", "sea": "sea" }"#;
    let faults = refused("field", &format!("{model}, {PICKED}"));
    assert!(faults.contains("which has no water level") && faults.contains("GerstnerSea"), "{faults}");
}

#[test]
fn what_is_held_is_reckoned_before_it_is_taken() {
    let sea = r#""sea": { "type": "GerstnerSea", "count": 3 }, "b": { "type": "Bake", "sea": "sea" }"#;
    let frame = baked(sea, 16, 9).unwrap();
    let node = frame.graph.settle(frame.graph.find("b").unwrap(), 1);
    let (bake, of) = (node.stage().unwrap(), |_| MemoryUse::default());
    let taken = |wanted: [bool; 4]| {
        let channels = [1, 3, 3, 1].into_iter().zip(wanted).map(|(count, wanted)| vec![wanted; count]);
        let channels: Vec<Vec<bool>> = channels.collect();
        let taken = bake.memory(&MemoryContext::new(&frame.context, &channels, &of));
        [taken.held, taken.working].map(|bytes| bytes / (16 * 9 * 4))
    };
    assert_eq!(taken([true, false, false, false]), [1, 3]);
    assert_eq!(taken([true; 4]), [8, 8]);
    assert_eq!(taken([false; 4]), [0, 0]);
}

#[test]
fn only_the_images_that_are_wanted_are_held() {
    let (sea, _) = waves(3, 3.0, &mut random(1));
    let frame = baked(&format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea" }}"#), 4, 3).unwrap();
    let id = frame.graph.find("b").unwrap();
    let settled = frame.graph.settle(id, 1);
    let bake = settled.stage().unwrap();
    let handles = |id: NodeId| frame.prepared[id.0].as_ref().and_then(|prepared| prepared.handle());
    let wanted = [vec![true], vec![false; 3], vec![false; 3], vec![false]];
    let pool = Pool::new();
    let kinds = &frame.graph.node(id).kinds;
    let prepare = Prepare::new(&frame.context, kinds, &wanted, &handles, &|| false, &pool);
    assert_eq!(bake.prepare(&prepare).unwrap().bytes(), 4 * 3 * size_of::<f32>());
    let stopped = Prepare::new(&frame.context, kinds, &wanted, &handles, &|| true, &pool);
    assert_eq!(bake.prepare(&stopped).err().unwrap().to_string(), "cancelled");
}

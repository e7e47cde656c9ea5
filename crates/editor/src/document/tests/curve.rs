use crate::document::curve::{Curve, Pick, Shift};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use trochoid::Interpolation;

fn curve(value: Value) -> Curve {
    Curve::read(&value).unwrap()
}

#[test]
fn curves_are_written_as_they_are_read() {
    for value in [
        json!({ "keys": [[1.0, 0.5]] }),
        json!({ "keys": [[1.0, [0.5, 2.0]], [4.0, [1.0, 0.0], { "in": [-2.0, [0.5, 0.0]], "interpolation": "hold" }]], "interpolation": "monotone" }),
        json!({ "keys": [[1.0, "#fff", { "out": [2.0, [0.0, 0.0, -0.25]] }], [9.0, "palette.ink"]] }),
    ] {
        assert_eq!(curve(value.clone()).write(), value);
    }
    for value in [json!(3), json!({ "keys": [[1]] }), json!({ "keys": [[1, 2, { "in": 4 }]] })] {
        assert_eq!(Curve::read(&value), None, "{value}");
    }
}

/// Keys as a plain list of frames and values does what curves do.
#[test]
fn no_key_is_lost_or_out_of_order_whatever_is_done() {
    let mut random = Pcg64Mcg::seed_from_u64(262);
    let (mut moved, mut stopped) = (0, 0);
    for _ in 0..300 {
        let mut curve = curve(json!({ "keys": [[1, 0.5], [5, 1.5], [9, 0.25]] }));
        let mut model: BTreeMap<i64, f64> = [(1, 0.5), (5, 1.5), (9, 0.25)].into();
        for _ in 0..30 {
            let frames: Vec<i64> = model.keys().copied().collect();
            let picked: Vec<i64> = frames.iter().copied().filter(|_| random.random_bool(0.4)).collect();
            let as_frames: Vec<f64> = picked.iter().map(|frame| *frame as f64).collect();
            match random.random_range(0..8) {
                0 | 1 => {
                    let (by, lift) = (random.random_range(-6..=6_i64), random.random_range(-2..=2) as f64);
                    let picks: Vec<Pick> = as_frames.iter().map(|frame| Pick { frame: *frame, component: 0 }).collect();
                    let mut after = BTreeMap::new();
                    for (frame, value) in &model {
                        let is_picked = picked.contains(frame);
                        let place = if is_picked { frame + by } else { *frame };
                        after.insert(place, if is_picked { value + lift } else { *value });
                    }
                    let is_free = after.len() == model.len();
                    match curve.moved(&picks, &Shift::by(by as f64, lift)) {
                        Some(new) => {
                            assert!(is_free);
                            (curve, model) = (new, after);
                            moved += 1;
                        }
                        None => {
                            assert!(!is_free);
                            stopped += 1;
                        }
                    }
                }
                2 => {
                    let frame = random.random_range(-5..20);
                    let before = curve.clone();
                    curve = curve.inserted(frame as f64);
                    model.entry(frame).or_insert_with(|| before.at(frame as f64).as_f64().unwrap());
                }
                3 if picked.len() < model.len() => {
                    curve = curve.without(&as_frames).unwrap();
                    model.retain(|frame, _| !picked.contains(frame));
                }
                4 => {
                    let word = *[Interpolation::Linear, Interpolation::Hold, Interpolation::Monotone]
                        .choose(&mut random)
                        .unwrap();
                    curve = curve.interpolated(&as_frames, word);
                }
                5 => curve = curve.smoothed(&as_frames, random.random()),
                6 => {
                    let (frame, value) = (random.random_range(-5..20), random.random_range(-4..=4) as f64);
                    curve = curve.keyed(frame as f64, &json!(value));
                    model.insert(frame, value);
                }
                _ => {
                    let Some(frame) = as_frames.first() else { continue };
                    let end = [random.random_range(-9.0..9.0), random.random_range(-1.0..1.0)];
                    let pick = Pick { frame: *frame, component: 0 };
                    curve = curve.turned(pick, random.random_range(0..2), end, random.random());
                }
            }
            let keys: Vec<(f64, Value)> = curve.keys.iter().map(|key| (key.frame, key.value.clone())).collect();
            assert!(keys.windows(2).all(|pair| pair[0].0 < pair[1].0), "{keys:?}");
            assert_eq!(keys.len(), model.len());
            for ((frame, value), (known, number)) in keys.iter().zip(&model) {
                assert_eq!(*frame, *known as f64);
                assert!((value.as_f64().unwrap() - number).abs() < 1e-5, "{value} for {number}");
            }
            // What is written can be read, and names a curve that a document accepts.
            assert_eq!(Curve::read(&curve.write()), Some(curve.clone()));
            accepted(&curve);
        }
    }
    assert!(moved > 500 && stopped > 100, "{moved} moved, {stopped} stopped");
}

#[track_caller]
fn accepted(curve: &Curve) {
    accepted_in(curve, &json!({ "type": "FieldMath", "expression": "a + b", "a": "x", "b": curve.write() }));
}

#[track_caller]
fn accepted_vector(curve: &Curve) {
    let shapes = json!([{ "form": "disc", "center": curve.write(), "radius": 1 }]);
    accepted_in(curve, &json!({ "type": "Shape", "shapes": shapes }));
}

#[track_caller]
fn accepted_in(curve: &Curve, node: &Value) {
    let text = json!({
        "trochoid": 1, "format": { "width": 4, "height": 4 },
        "nodes": { "x": { "type": "ScreenX" }, "f": node },
        "outputs": { "out": { "field": "f" } }
    });
    let checked = trochoid::parse("a.json", &text.to_string(), std::path::Path::new("."), &[]);
    assert!(checked.is_ok(), "{}: {checked:?}", curve.write());
}

#[test]
fn a_key_between_others_changes_no_shape() {
    let bent = curve(json!({ "keys": [[1, 0, { "out": [10, 4] }], [21, 1, { "in": [-3, 0.5] }], [30, 0]] }));
    let (before, after) = (bent.animated().unwrap(), bent.inserted(8.0).animated().unwrap());
    for frame in 0..=32 {
        let [a, b] = [&before, &after].map(|curve| curve.at(f64::from(frame))[0]);
        assert!((a - b).abs() < 1e-4, "{a} and {b} at {frame}");
    }
    assert_eq!(bent.inserted(21.0), bent, "there is a key already");
}

#[test]
fn a_key_that_is_set_makes_no_corner_in_a_smooth_curve() {
    let smooth = json!({ "keys": [[1, [0, 2], { "out": [4, [0, 1]] }], [21, [1, 2], { "in": [-5, [0.5, -1]] }]] });
    for frame in [-9.0, 5.0, 14.0, 30.0] {
        let (old, value) = (curve(smooth.clone()), json!([3, -2]));
        let new = old.keyed(frame, &value);
        assert_eq!(new.at(frame), value);
        accepted_vector(&new);
        // On both sides of each key, the curve has one slope.
        let animated = new.animated().unwrap();
        for key in &new.keys[1..new.keys.len() - 1] {
            let [before, at, after] = [-1e-3, 0.0, 1e-3].map(|by| animated.at(key.frame + by));
            for component in 0..2 {
                let [back, on] = [at[component] - before[component], after[component] - at[component]];
                assert!((back - on).abs() < 1e-5, "key {} of {}: {back} and {on}", key.frame, new.write());
            }
        }
    }
    // Without handles, keys stay plain; one that is there only changes its value.
    let plain = curve(json!({ "keys": [[1, 0], [9, 8]] }));
    assert_eq!(plain.keyed(12.0, &json!(5)).write(), json!({ "keys": [[1.0, 0], [9.0, 8], [12.0, 5]] }));
    assert_eq!(plain.keyed(9.0, &json!(5)).write(), json!({ "keys": [[1.0, 0], [9.0, 5]] }));
}

#[test]
fn handles_turn_together_until_they_form_a_corner() {
    let plain = curve(json!({ "keys": [[0, 0], [10, 1], [20, 0]] }));
    let pick = Pick { frame: 10.0, component: 0 };
    let smooth = plain.turned(pick, 1, [4.0, 2.0], false);
    let key = smooth.write()["keys"][1].clone();
    assert_eq!(key[2]["out"], json!([4.0, 2.0]));
    let back = key[2]["in"].as_array().unwrap();
    let slope = back[1].as_f64().unwrap() / back[0].as_f64().unwrap();
    assert!((slope - 0.5).abs() < 1e-4, "{key}");
    let corner = smooth.turned(pick, 1, [4.0, -2.0], true);
    assert_eq!(corner.keys[1].handles[0], smooth.keys[1].handles[0], "moved alone");
    let more = corner.turned(pick, 1, [4.0, -3.0], false);
    assert_eq!(more.keys[1].handles[0], smooth.keys[1].handles[0], "a corner stays one");
    assert!(more.smoothed(&[10.0], false).keys[1].is_smooth());
    assert_eq!(more.bare(&[10.0]), plain);
}

#[test]
fn what_holds_has_no_handles() {
    let bent =
        curve(json!({ "keys": [[0, 0, { "out": [2, 1] }], [10, 1, { "in": [-2, 0], "out": [2, 0] }], [20, 0]] }));
    let held = bent.interpolated(&[0.0], Interpolation::Hold);
    assert_eq!(
        held.write(),
        json!({ "keys": [[0.0, 0, { "interpolation": "hold" }], [10.0, 1, { "out": [2.0, 0.0] }], [20.0, 0]] })
    );
    let all = bent.interpolated(&[0.0, 10.0, 20.0], Interpolation::Hold);
    assert_eq!(all.write(), json!({ "keys": [[0.0, 0], [10.0, 1], [20.0, 0]], "interpolation": "hold" }));
}

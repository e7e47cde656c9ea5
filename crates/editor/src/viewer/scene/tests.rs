//! Tests of handles and of the camera by mouse, driven by simulated drags.

mod camera;

use super::super::tests::{WINDOW, act, button, click, drag, hover, open, picture, press, settle};
use crate::actions::Action;
use crate::document::Path;
use crate::testing::{Window, editor};
use egui::{Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use serde_json::Value;

/// A boat of a group, a model, and lights on a sea.
const SCENE: &str = r##"{
  "trochoid": 1, "format": { "width": 64, "height": 36 }, "frames": { "first": 1, "last": 9, "fps": 24 },
  "knobs": { "far": 2 },
  "groups": {
    "Boat": {
      "inputs": { "sea": "Surface" }, "knobs": { "x": 0, "z": 0, "heading": 0 },
      "nodes": {
        "hull": { "type": "BezierModel", "rails": [
          { "points": [{ "at": [-1, 0, -1] }, { "at": [1, 0, -1] }] }, { "points": [{ "at": [-1, 0, 1] }, { "at": [1, 0, 1] }] } ] },
        "boat": { "type": "Float", "model": "hull", "sea": "sea",
                  "bodies": [{ "x": "= knobs.x", "z": "= knobs.z", "heading": "= knobs.heading" }] }
      },
      "outputs": { "boat": "boat" }
    },
    "Eyes": {
      "inputs": { "sea": "Surface" }, "knobs": { "from": [0, 6, 14] },
      "nodes": {
        "camera": { "type": "Camera", "position": "= knobs.from", "target": [0, 0, 0] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] }
      },
      "outputs": { "view": "view" }
    }
  },
  "nodes": {
    "camera": { "type": "Camera", "position": [0, 6, 14] },
    "other": { "type": "Camera", "position": [-3, 2, 2], "target": [-1, 0, 0] },
    "sea": { "type": "RippleSea", "height": 0.05 },
    "front": { "type": "Boat", "sea": "sea", "x": 1.5 },
    "model": { "type": "BezierModel", "translate": [-2, 1, 0], "rails": [
      { "points": [{ "at": [-1, 0, -1] }, { "at": [1, 0, -1] }] }, { "points": [{ "at": [-1, 0, 1] }, { "at": [1, 0, 1] }] } ] },
    "sun": { "type": "Light", "direction": [0.2, 0.3, -1] },
    "lamp": { "type": "Light", "kind": "spot", "position": [1, 2, 1] },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea", "front", "model"] },
    "eyes": { "type": "Eyes", "sea": "sea", "from": [0, 5, 10] },
    "color": { "type": "Mix", "a": "#102030", "b": "#e0e0d0", "weight": "view.coverage" }
  },
  "outputs": { "beauty": { "color": "color" } }
}"##;

fn select(window: &mut Window, names: &[&str]) {
    act(window, Action::Select(names.iter().map(|name| (*name).to_string()).collect()));
}

fn selected(text: &str, name: &str) -> Window {
    let mut window = open(text, WINDOW);
    select(&mut window, &[name]);
    window
}

fn spot(window: &Window, label: &str) -> Pos2 {
    window.get_by_label(label).rect().center()
}

fn value(window: &Window, path: &str) -> Value {
    let path = path.split('.').fold(Path::default(), |path, step| match step.parse::<usize>() {
        Ok(index) => path.to(index),
        Err(_) => path.to(step),
    });
    path.find(&editor(window).state().session.sheet().value).cloned().unwrap_or_default()
}

fn numbers(window: &Window, path: &str) -> Vec<f64> {
    value(window, path).as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn vector(window: &Window, path: &str) -> DVec3 {
    DVec3::from_slice(&numbers(window, path))
}

fn text(window: &Window) -> &str {
    editor(window).state().session.text()
}

fn undoes(window: &Window) -> Option<&str> {
    editor(window).state().session.history().undoes()
}

/// Whether a notice says something.
fn told(window: &Window, part: &str) -> bool {
    editor(window).notices.texts().iter().any(|told| told.contains(part))
}

/// Drags a handle, and asserts that what it belongs to comes with the pointer.
fn carried(window: &mut Window, label: &str, by: Vec2) {
    let from = spot(window, label);
    // What is raised stays on its vertical, which is not quite one in the picture.
    let (point, along) = match label.strip_suffix("height") {
        Some(title) => (format!("{title}move"), vec2(0.1, 1.0)),
        None => (label.to_string(), vec2(1.0, 1.0)),
    };
    let before = spot(window, &point);
    drag(window, from, from + by, Modifiers::NONE);
    let off = (spot(window, &point) - before - by) * along;
    assert!(off.length() < 1.0, "{label}: dragged by {by:?}, off by {off:?}");
}

/// Asserts that all changes are one step of undo, with this label.
fn is_one_step(window: &mut Window, before: &str, label: &str) {
    assert_ne!(text(window), before);
    assert_eq!(undoes(window), Some(label));
    act(window, Action::Undo);
    assert_eq!(text(window), before);
    assert_eq!(undoes(window), None);
}

#[test]
fn a_use_of_a_group_is_moved_by_the_knobs_that_place_something_inside() {
    let mut window = selected(SCENE, "front");
    for (part, is_there) in [("move", true), ("turn", true), ("height", false), ("scale", false)] {
        assert_eq!(window.query_by_label(&format!("front: {part}")).is_some(), is_there, "{part}");
    }
    carried(&mut window, "front: move", vec2(40.0, 25.0));
    let [x, z] = ["x", "z"].map(|name| value(&window, &format!("nodes.front.{name}")).as_f64().unwrap());
    assert!(x > 1.6 && z > 0.1, "{x} {z}");
    assert_eq!(value(&window, "groups.Boat.knobs.x"), 0, "the group stays");
    is_one_step(&mut window, SCENE, "Move front");
    // The same handle belongs to the node inside, seen from there.
    act(&mut window, Action::Enter(vec!["front".into()]));
    select(&mut window, &["boat"]);
    carried(&mut window, "boat.bodies[0]: move", vec2(-30.0, 10.0));
    assert!(value(&window, "nodes.front.x").as_f64().unwrap() < 1.4);
}

#[test]
fn a_model_is_moved_raised_turned_and_scaled() {
    let mut window = selected(SCENE, "model");
    carried(&mut window, "model: move", vec2(50.0, 15.0));
    let moved = vector(&window, "nodes.model.translate");
    assert!(moved.x > -1.9 && moved.y == 1.0 && moved.z > 0.1, "{moved}");
    is_one_step(&mut window, SCENE, "Move model");
    carried(&mut window, "model: height", vec2(0.0, -30.0));
    let raised = vector(&window, "nodes.model.translate");
    assert!(raised.y > 1.2 && [raised.x, raised.z] == [-2.0, 0.0], "{raised}");
    is_one_step(&mut window, SCENE, "Raise model");
    // Twice as far from the middle is twice as large.
    let (middle, corner) = (spot(&window, "model: move"), spot(&window, "model: scale"));
    drag(&mut window, corner, corner + (corner - middle), Modifiers::NONE);
    assert_eq!(value(&window, "nodes.model.scale"), serde_json::json!([2, 2, 2]));
    is_one_step(&mut window, SCENE, "Scale model");
    // The handle turns to where the pointer is.
    let grip = spot(&window, "model: turn");
    let to = middle + vec2(-30.0, 25.0);
    drag(&mut window, grip, to, Modifiers::NONE);
    let [now, wanted] = [spot(&window, "model: turn") - middle, to - middle].map(Vec2::normalized);
    assert!((now - wanted).length() < 0.02, "{now:?} {wanted:?}");
    let turned = vector(&window, "nodes.model.rotate");
    assert!(turned.x == 0.0 && turned.z == 0.0 && (180.0..270.0).contains(&turned.y.rem_euclid(360.0)), "{turned}");
    is_one_step(&mut window, SCENE, "Turn model");
}

#[test]
fn shift_drags_finely() {
    let mut window = selected(SCENE, "model");
    let from = spot(&window, "model: move");
    drag(&mut window, from, from + vec2(60.0, 0.0), Modifiers::SHIFT);
    let by = spot(&window, "model: move") - from;
    assert!((by - vec2(6.0, 0.0)).length() < 1.0, "{by:?}");
    assert_eq!(editor(&window).state().look.region, None);
}

#[test]
fn lights_are_aimed_where_they_are() {
    // The sun is in the picture of a level camera.
    let level = SCENE.replace(r#""position": [0, 6, 14]"#, r#""position": [0, 2, 14], "target": [0, 2, 0]"#);
    let mut window = selected(&level, "sun");
    carried(&mut window, "sun.direction: direction", vec2(-60.0, 20.0));
    let direction = vector(&window, "nodes.sun.direction");
    assert!((direction.length() - DVec3::new(0.2, 0.3, -1.0).length()).abs() < 1e-3, "{direction}");
    is_one_step(&mut window, &level, "Aim sun.direction");
    // Elsewhere it is at the tip of an arrow.
    let mut window = selected(SCENE, "sun");
    carried(&mut window, "sun.direction: direction", vec2(25.0, -15.0));
    is_one_step(&mut window, SCENE, "Aim sun.direction");
    select(&mut window, &["lamp"]);
    carried(&mut window, "lamp: move", vec2(25.0, -5.0));
    carried(&mut window, "lamp.target: move", vec2(-25.0, 5.0));
    assert!(window.query_by_label("lamp.direction: direction").is_none(), "a spot has none");
}

#[test]
fn a_camera_has_handles_unless_one_looks_through_it() {
    let mut window = selected(SCENE, "other");
    carried(&mut window, "other: move", vec2(15.0, 5.0));
    carried(&mut window, "other.target: height", vec2(0.0, -15.0));
    select(&mut window, &["camera"]);
    assert!(window.query_by_label("camera: move").is_none());
    assert!(window.query_by_label("camera.target: move").is_some());
}

#[test]
fn what_is_behind_the_camera_has_no_handle() {
    let text = SCENE.replace("[-2, 1, 0]", "[-2, 1, 40]");
    let window = selected(&text, "model");
    for part in ["move", "height", "turn", "scale"] {
        assert!(window.query_by_label(&format!("model: {part}")).is_none(), "{part}");
    }
}

#[test]
fn a_keyed_place_changes_at_its_key() {
    let keyed = SCENE.replace("[-2, 1, 0]", r#"{ "keys": [[1, [-2, 1, 0]], [9, [2, 1, 0]]] }"#);
    let mut window = selected(&keyed, "model");
    carried(&mut window, "model: move", vec2(30.0, 0.0));
    assert!(value(&window, "nodes.model.translate.keys.0.1.0").as_f64().unwrap() > -1.9);
    assert_eq!(value(&window, "nodes.model.translate.keys.1"), serde_json::json!([9, [2, 1, 0]]));
    act(&mut window, Action::Undo);
    act(&mut window, Action::Frame(5));
    carried(&mut window, "model: move", vec2(30.0, 0.0));
    let keys = value(&window, "nodes.model.translate.keys");
    assert_eq!(keys.as_array().unwrap().len(), 3, "{keys}");
    assert_eq!((&keys[0][1][0], &keys[1][0], &keys[2][1][0]), (&Value::from(-2), &Value::from(5), &Value::from(2)));
    is_one_step(&mut window, &keyed, "Move model");
}

#[test]
fn what_follows_a_formula_says_so() {
    let linked = SCENE.replace("[-2, 1, 0]", r#"["= knobs.far", 1, 0]"#);
    let mut window = selected(&linked, "model");
    let grip = spot(&window, "model: move");
    drag(&mut window, grip, grip + vec2(30.0, 12.0), Modifiers::NONE);
    assert!(told(&window, "model.translate follows \"= knobs.far\""));
    // What is free moves.
    let place = value(&window, "nodes.model.translate");
    assert!(place[0] == "= knobs.far" && place[1] == 1 && place[2].as_f64().unwrap() > 0.01, "{place}");
    is_one_step(&mut window, &linked, "Move model");
    // Its height is free.
    carried(&mut window, "model: height", vec2(0.0, -20.0));
    assert_eq!(value(&window, "nodes.model.translate.0"), "= knobs.far");
}

#[test]
fn a_use_whose_knobs_are_all_linked_says_so() {
    let all = r#""x": "= knobs.far", "z": "= model.translate.x", "heading": "= 10 * knobs.far""#;
    let linked = SCENE.replacen(r#""x": 1.5"#, all, 1);
    let mut window = selected(&linked, "front");
    for part in ["move", "turn"] {
        let grip = spot(&window, &format!("front: {part}"));
        drag(&mut window, grip, grip + vec2(30.0, 5.0), Modifiers::NONE);
        assert_eq!(text(&window), linked);
    }
    assert!(told(&window, "x follows \"= knobs.far\""));
    assert!(told(&window, "heading follows \"= 10 * knobs.far\""));
    // What the group itself computes is none of the use's handles.
    let inner =
        SCENE.replacen(r#""x": "= knobs.x", "z": "= knobs.z""#, r#""x": "= knobs.x + 1", "z": "= knobs.z + 1""#, 1);
    let window = selected(&inner, "front");
    assert!(window.query_by_label("front: move").is_none() && window.query_by_label("front: turn").is_some());
}

#[test]
fn a_boat_has_its_handles_where_it_floats() {
    // Long and high waves, of which only the boat is seen.
    let high = SCENE
        .replacen(r#""height": 0.05"#, r#""height": 2.5, "along": 40, "across": 1e5, "phase": 60"#, 1)
        .replacen(r#""surfaces": ["sea", "front", "model"]"#, r#""surfaces": ["front"]"#, 1);
    let mut window = selected(&high, "front");
    let at_rest = spot(&selected(SCENE, "front"), "front: move");
    for frame in [1, 9] {
        act(&mut window, Action::Frame(frame));
        let handle = spot(&window, "front: move");
        let result = editor(&window).state().evaluated.result.clone().unwrap();
        let red = &result.picture.planes[0];
        let [mut sum, mut count] = [Vec2::ZERO, Vec2::ZERO];
        for (x, y) in (0..64).flat_map(|x| (0..36).map(move |y| (x, y))) {
            if red.nearest(x, y) > 0.3 {
                sum += vec2(x as f32 + 0.5, y as f32 + 0.5);
                count += Vec2::splat(1.0);
            }
        }
        let middle = sum / count / vec2(64.0, 36.0);
        // The picture is fitted into its panel.
        let panel = picture(&window);
        let pixel = (panel.width() / 64.0).min(panel.height() / 36.0);
        let seen = panel.center() + (middle - Vec2::splat(0.5)) * vec2(64.0, 36.0) * pixel;
        assert!((handle - seen).length() < 1.5 * pixel, "{handle:?} {seen:?} at {frame}, a pixel is {pixel}");
        assert!((handle - at_rest).length() > 3.0 * pixel, "{handle:?} {at_rest:?} at {frame}");
    }
}

#[test]
fn escape_puts_a_dragged_handle_back() {
    let mut window = selected(SCENE, "model");
    let grip = spot(&window, "model: move");
    hover(&mut window, grip);
    button(&mut window, grip, true, Modifiers::NONE);
    for step in 1..=3 {
        hover(&mut window, grip + vec2(10.0 * step as f32, 0.0));
    }
    assert_ne!(text(&window), SCENE);
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert_eq!(text(&window), SCENE);
    hover(&mut window, grip + vec2(60.0, 0.0));
    button(&mut window, grip + vec2(60.0, 0.0), false, Modifiers::NONE);
    settle(&mut window);
    assert_eq!(text(&window), SCENE);
    assert_eq!(undoes(&window), None);
}

#[test]
fn looking_clicking_and_dragging_to_the_same_place_write_nothing() {
    let mut window = open(SCENE, WINDOW);
    act(&mut window, Action::SelectAll);
    let revision = editor(&window).state().session.revision();
    for label in ["model: move", "model: turn", "front: move", "other.target: height", "sun.direction: direction"] {
        let grip = spot(&window, label);
        click(&mut window, grip);
        assert_eq!(editor(&window).state().session.revision(), revision, "{label}");
    }
    let grip = spot(&window, "model: move");
    hover(&mut window, grip);
    button(&mut window, grip, true, Modifiers::NONE);
    for by in [20.0, 40.0, 0.0] {
        hover(&mut window, grip + vec2(by, 0.0));
    }
    button(&mut window, grip, false, Modifiers::NONE);
    settle(&mut window);
    assert_eq!((text(&window), undoes(&window)), (SCENE, None));
    let at = picture(&window).center();
    hover(&mut window, at);
    press(&mut window, Key::C);
    click(&mut window, at);
    assert_eq!((text(&window), undoes(&window)), (SCENE, None));
    assert_eq!(editor(&window).state().look.pick, None, "a click in this mode picks nothing");
}

#[test]
fn a_surface_is_shown_by_a_camera_of_the_document_or_one_that_cannot_be_moved() {
    let mut window = selected(SCENE, "model");
    act(&mut window, Action::Look("model".into(), 0));
    carried(&mut window, "model: move", vec2(30.0, 10.0));
    act(&mut window, Action::Undo);
    let at = picture(&window).center();
    hover(&mut window, at);
    press(&mut window, Key::C);
    drag(&mut window, at, at + vec2(60.0, 0.0), Modifiers::NONE);
    is_one_step(&mut window, SCENE, "Orbit camera");
    let bare = r##"{ "trochoid": 1, "format": { "width": 64, "height": 36 },
      "nodes": { "sea": { "type": "RippleSea" }, "flat": { "type": "Mix", "a": "#102030", "b": "#f0e0d0", "weight": 0.5 } },
      "outputs": { "beauty": { "color": "flat" } } }"##;
    let mut window = open(bare, WINDOW);
    act(&mut window, Action::Look("sea".into(), 0));
    let at = picture(&window).center();
    hover(&mut window, at);
    press(&mut window, Key::C);
    drag(&mut window, at, at + vec2(60.0, 0.0), Modifiers::NONE);
    assert_eq!((text(&window), undoes(&window)), (bare, None));
    assert!(told(&window, "a camera for this picture is not in the document: add it there first"));
}

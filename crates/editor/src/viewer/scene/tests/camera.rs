//! Tests of the camera by mouse.

use super::super::super::tests::{WINDOW, act, button, drag, hover, open, picture, press, settle};
use super::super::HELP;
use super::{SCENE, carried, is_one_step, numbers, select, spot, text, told, undoes, value, vector};
use crate::actions::{Action, Switch};
use crate::testing::{Window, editor, until};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, TouchPhase, vec2};
use egui_kittest::kittest::Queryable;
use glam::DVec3;

/// Opens a scene in whose picture drags move the camera; returns the middle of the picture, too.
fn steered(text: &str) -> (Window, Pos2) {
    let mut window = open(text, WINDOW);
    let at = picture(&window).center();
    hover(&mut window, at);
    press(&mut window, Key::C);
    assert!(window.query_by_label(HELP).is_some());
    (window, at)
}

/// A model in the middle of the picture, high above the sea.
fn raised() -> String {
    SCENE.replacen(r#""translate": [-2, 1, 0]"#, r#""translate": [0, 3, 7]"#, 1)
}

#[test]
fn the_camera_orbits_about_the_model_in_the_middle_of_the_picture() {
    let (mut window, at) = steered(&raised());
    let model = DVec3::new(0.0, 3.0, 7.0);
    drag(&mut window, at, at + vec2(120.0, 0.0), Modifiers::NONE);
    let position = vector(&window, "nodes.camera.position");
    assert!((position.distance(model) - DVec3::new(0.0, 6.0, 14.0).distance(model)).abs() < 0.01, "{position}");
    assert!(position.x < -1.0, "{position}");
    // Beside the model, the sea is nearer to what the pointer is at.
    act(&mut window, Action::Undo);
    let from = numbers(&window, "nodes.camera.position");
    hover(&mut window, at + vec2(250.0, 90.0));
    wheel(&mut window, 40.0);
    let by = vector(&window, "nodes.camera.position") - DVec3::from_slice(&from);
    assert!(by.x > 0.05 && by.y < -0.3, "{by}");
}

#[test]
fn the_camera_orbits_about_a_boat_and_not_about_the_sea_behind() {
    // The middle of the picture is a little above the boat.
    let looks = r#""position": [0, 6, 14], "target": [0, 0.8, 5]"#;
    let text = SCENE.replacen(r#""position": [0, 6, 14]"#, looks, 1).replacen(r#""x": 1.5 }"#, r#""z": 5 }"#, 1);
    let (mut window, at) = steered(&text);
    drag(&mut window, at, at + vec2(120.0, 0.0), Modifiers::NONE);
    let (boat, position) = (DVec3::new(0.0, 0.0, 5.0), vector(&window, "nodes.camera.position"));
    let away = position.with_y(0.0).distance(boat);
    assert!(position.x < -3.0 && (away - 9.0).abs() < 0.15, "{position} {away}");
}

#[test]
fn a_motion_in_the_frame_of_the_press_counts() {
    let (mut window, at) = steered(SCENE);
    let press = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    hover(&mut window, at);
    window.event(press(at, true));
    window.event(Event::PointerMoved(at + vec2(60.0, 0.0)));
    window.step();
    window.event(Event::PointerMoved(at + vec2(90.0, 0.0)));
    window.event(press(at + vec2(90.0, 0.0), false));
    window.step();
    settle(&mut window);
    let quick = vector(&window, "nodes.camera.position");
    is_one_step(&mut window, SCENE, "Orbit camera");
    drag(&mut window, at, at + vec2(90.0, 0.0), Modifiers::NONE);
    assert_eq!(vector(&window, "nodes.camera.position"), quick);
}

#[test]
fn a_notch_of_the_wheel_comes_nearer_by_a_tenth() {
    let (mut window, at) = steered(SCENE);
    hover(&mut window, at);
    let (unit, phase) = (MouseWheelUnit::Line, TouchPhase::Move);
    window.event(Event::MouseWheel { unit, delta: vec2(0.0, 1.0), phase, modifiers: Modifiers::NONE });
    window.run_steps(40);
    let share = vector(&window, "nodes.camera.position").length() / DVec3::new(0.0, 6.0, 14.0).length();
    assert!((share - 0.9).abs() < 0.01, "{share}");
}

#[test]
fn the_hull_ends_the_mode_and_the_mode_closes_the_hull() {
    let (mut window, at) = steered(SCENE);
    act(&mut window, Action::Viewer(Switch::Hull));
    assert!(window.query_by_label(HELP).is_none());
    act(&mut window, Action::Viewer(Switch::Hull));
    assert!(window.query_by_label(HELP).is_none(), "it does not come back by itself");
    hover(&mut window, at);
    press(&mut window, Key::H);
    press(&mut window, Key::C);
    assert!(window.query_by_label(HELP).is_some());
}

fn wheel(window: &mut Window, by: f32) {
    let delta = vec2(0.0, by);
    let (unit, phase) = (MouseWheelUnit::Point, TouchPhase::Move);
    window.event(Event::MouseWheel { unit, delta, phase, modifiers: Modifiers::NONE });
    window.run_steps(10);
}

#[test]
fn the_camera_orbits_about_what_is_selected_or_in_the_middle() {
    let (mut window, at) = steered(SCENE);
    let aside = at + vec2(-120.0, 60.0);
    drag(&mut window, aside, aside + vec2(90.0, -30.0), Modifiers::NONE);
    let (position, old) = (vector(&window, "nodes.camera.position"), DVec3::new(0.0, 6.0, 14.0));
    assert!((position.length() - old.length()).abs() < 0.01, "{position}");
    // To the right, the scene turns to the right; up, one looks from lower.
    assert!(position.x < -1.0 && position.y < 5.0, "{position}");
    assert!(value(&window, "nodes.camera.target").is_null(), "it turns about its target, which stays");
    is_one_step(&mut window, SCENE, "Orbit camera");
    // What is selected stays where it is; a handle there does not hold the camera up.
    select(&mut window, &["front"]);
    let boat = spot(&window, "front: move");
    drag(&mut window, boat, boat + vec2(-80.0, 20.0), Modifiers::NONE);
    let seen = spot(&window, "front: move");
    assert!((seen - boat).length() < 1.0, "{seen:?} {boat:?}");
    assert_eq!(undoes(&window), Some("Orbit camera"));
    assert_eq!(editor(&window).state().look.pick, None);
}

#[test]
fn the_camera_pans_with_the_point_under_the_pointer() {
    let (mut window, at) = steered(SCENE);
    select(&mut window, &["front"]);
    let boat = spot(&window, "front: move");
    drag(&mut window, at, at + vec2(40.0, 20.0), Modifiers::SHIFT);
    let by = spot(&window, "front: move") - boat;
    // The boat is a little nearer or farther than the middle.
    assert!((by - vec2(40.0, 20.0)).length() < 4.0, "{by:?}");
    assert_eq!(editor(&window).state().look.region, None);
    let between = vector(&window, "nodes.camera.target") - vector(&window, "nodes.camera.position");
    assert!(between.distance(DVec3::new(0.0, -6.0, -14.0)) < 0.01, "{between}");
    is_one_step(&mut window, SCENE, "Pan camera");
}

#[test]
fn the_camera_dollies_by_the_wheel_and_never_passes() {
    let (mut window, at) = steered(SCENE);
    hover(&mut window, at);
    let before = picture(&window);
    wheel(&mut window, 120.0);
    let near = vector(&window, "nodes.camera.position");
    assert!(near.length() < 12.0 && near.normalize().distance(DVec3::new(0.0, 6.0, 14.0).normalize()) < 1e-3, "{near}");
    for _ in 0..20 {
        wheel(&mut window, 400.0);
    }
    let nearest = vector(&window, "nodes.camera.position");
    assert!(nearest.z > 0.0 && nearest.y > 0.0, "{nearest}");
    assert_eq!(picture(&window), before, "the picture itself keeps its size");
    // The wheel runs on for a moment.
    window.run_steps(20);
    is_one_step(&mut window, SCENE, "Dolly camera");
    // After a pause, the wheel begins another step.
    settle(&mut window);
    hover(&mut window, at);
    wheel(&mut window, 60.0);
    window.run_steps(60);
    wheel(&mut window, 60.0);
    act(&mut window, Action::Undo);
    assert_ne!(text(&window), SCENE);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), SCENE);
}

#[test]
fn an_orthographic_camera_dollies_by_its_height() {
    let parallel = r#""position": [0, 6, 14], "target": [0, 0, 0], "projection": "orthographic""#;
    let parallel = SCENE.replacen(r#""position": [0, 6, 14]"#, parallel, 1);
    let (mut window, at) = steered(&parallel);
    drag(&mut window, at, at + vec2(0.0, -40.0), Modifiers::COMMAND);
    assert!(value(&window, "nodes.camera.height").as_f64().unwrap() < 9.0);
    // The middle of the picture is up to half a pixel away from where the pointer was.
    assert!(vector(&window, "nodes.camera.position").distance(DVec3::new(0.0, 6.0, 14.0)) < 0.01);
    is_one_step(&mut window, &parallel, "Dolly camera");
    hover(&mut window, at);
    press(&mut window, Key::C);
    select(&mut window, &["model"]);
    for part in ["move", "height"] {
        carried(&mut window, &format!("model: {part}"), vec2(0.0, -20.0));
    }
}

#[test]
fn escape_ends_the_drag_first_and_then_the_mode() {
    let (mut window, at) = steered(SCENE);
    button(&mut window, at, true, Modifiers::NONE);
    for step in 1..=4 {
        hover(&mut window, at + vec2(20.0 * step as f32, 0.0));
    }
    assert_ne!(text(&window), SCENE);
    window.key_press(Key::Escape);
    window.run_steps(2);
    hover(&mut window, at + vec2(120.0, 0.0));
    button(&mut window, at + vec2(120.0, 0.0), false, Modifiers::NONE);
    settle(&mut window);
    assert_eq!((text(&window), undoes(&window)), (SCENE, None));
    assert!(window.query_by_label(HELP).is_some());
    // Wherever the pointer is.
    hover(&mut window, Pos2::new(4.0, 4.0));
    press(&mut window, Key::Escape);
    assert!(window.query_by_label(HELP).is_none());
    // Now drags pick pixels again.
    drag(&mut window, at, at + vec2(20.0, 0.0), Modifiers::NONE);
    assert_eq!(text(&window), SCENE);
    assert!(editor(&window).state().look.pick.is_some());
}

#[test]
fn the_middle_button_pans_the_camera_in_the_mode_and_the_picture_outside() {
    let (mut window, at) = steered(SCENE);
    let middle = |window: &mut Window| {
        for (pos, pressed) in [(at, true), (at + vec2(30.0, 0.0), false)] {
            hover(window, pos);
            let (button, modifiers) = (PointerButton::Middle, Modifiers::NONE);
            window.event(Event::PointerButton { pos, button, pressed, modifiers });
            window.step();
            if pressed {
                hover(window, at + vec2(15.0, 0.0));
            }
        }
        settle(window);
    };
    middle(&mut window);
    is_one_step(&mut window, SCENE, "Pan camera");
    hover(&mut window, at);
    press(&mut window, Key::C);
    middle(&mut window);
    assert_eq!(text(&window), SCENE);
}

#[test]
fn the_camera_of_a_group_moves_where_it_is_written() {
    let inside = SCENE.replace(r#""weight": "view.coverage""#, r#""weight": "mask""#).replace(
        r#""color": { "type": "Mix""#,
        r#""mask": { "type": "Clamp", "field": "up" }, "up": { "type": "Height", "view": "eyes" },
    "color": { "type": "Mix""#,
    );
    let (mut window, at) = steered(&inside);
    drag(&mut window, at, at + vec2(60.0, 0.0), Modifiers::NONE);
    assert!(vector(&window, "nodes.eyes.from").x < -0.5, "the use hands it in");
    assert!(vector(&window, "groups.Eyes.nodes.camera.target").length() < 0.01, "the group has it");
    assert_eq!(value(&window, "groups.Eyes.nodes.camera.position"), "= knobs.from");
    assert_eq!(value(&window, "nodes.camera.position"), serde_json::json!([0, 6, 14]), "another camera");
    is_one_step(&mut window, &inside, "Orbit camera");
}

#[test]
fn a_camera_that_follows_a_formula_says_so() {
    let linked = SCENE.replacen(
        r#""position": [0, 6, 14]"#,
        r#""position": [0, 6, 14], "target": ["= front.x", 0, "= front.z"]"#,
        1,
    );
    let (mut window, at) = steered(&linked);
    drag(&mut window, at, at + vec2(60.0, 0.0), Modifiers::NONE);
    wheel(&mut window, 60.0);
    assert_eq!((text(&window), undoes(&window)), (linked.as_str(), None));
    assert!(told(&window, "camera.target follows \"= front.x\""));
}

#[test]
fn a_keyed_camera_changes_at_its_key() {
    let keyed =
        SCENE.replacen(r#""position": [0, 6, 14]"#, r#""position": { "keys": [[1, [0, 6, 14]], [9, [0, 6, 20]]] }"#, 1);
    let (mut window, at) = steered(&keyed);
    drag(&mut window, at, at + vec2(60.0, 0.0), Modifiers::NONE);
    assert!(value(&window, "nodes.camera.position.keys.0.1.0").as_f64().unwrap() < -0.5);
    assert_eq!(value(&window, "nodes.camera.position.keys.1"), serde_json::json!([9, [0, 6, 20]]));
    is_one_step(&mut window, &keyed, "Orbit camera");
}

#[test]
fn the_picture_follows_while_the_camera_is_dragged() {
    let (mut window, at) = steered(SCENE);
    let before = editor(&window).state().evaluated.result.clone().unwrap();
    button(&mut window, at, true, Modifiers::NONE);
    for step in 1..=4 {
        hover(&mut window, at + vec2(25.0 * step as f32, -10.0));
    }
    let revision = editor(&window).state().session.revision();
    until(&mut window, "the picture of the dragged camera", |editor| {
        editor.state().evaluated.result.as_ref().is_some_and(|result| result.subject.revision == revision)
    });
    let now = editor(&window).state().evaluated.result.clone().unwrap();
    assert_ne!(before.lens.text, now.lens.text);
    button(&mut window, at + vec2(100.0, -10.0), false, Modifiers::NONE);
}

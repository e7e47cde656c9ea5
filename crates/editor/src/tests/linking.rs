//! Links made by dragging the name of a knob onto another knob, or onto a node of the graph.

use super::typing::fields;
use crate::actions::Action;
use crate::document::Session;
use crate::testing::{Window, act, choose, editor, text, unseen_in, value};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use serde_json::json;

const SHADE: &str = r##"{
  "trochoid": 1, "format": { "width": 64, "height": 36 }, "working_space": "srgb",
  "frames": { "first": 1, "last": 5, "fps": 24 },
  "nodes": {
    "eye": { "type": "Camera", "position": [1, 4, 20], "fov": 30 },
    "noise": { "type": "Noise", "octaves": 4 },
    "range": { "type": "Clamp", "field": "noise", "min": 0.25, "max": 0.75 },
    "other": { "type": "Clamp", "field": "noise", "min": "= range.max", "max": 1 },
    "sky": { "type": "Mix", "a": "#2d3f52", "b": "#102030", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "sky" } },
  "ui": { "positions": { "eye": [0, 0], "noise": [200, 0], "range": [400, 0], "other": [600, 0], "sky": [800, 0] } }
}"##;

fn open(node: &str) -> Window {
    let mut window = unseen_in(Session::new(SHADE.into(), None), [1600.0, 1400.0]);
    assert!(editor(&window).state().session.meaning().graph.is_some());
    choose(&mut window, node);
    act(&mut window, Action::Frames);
    window
}

/// A use of a group whose knobs follow others; a group inside hands one of them on.
const BOATS: &str = r##"{
  "trochoid": 1, "format": { "width": 64, "height": 36 },
  "groups": {
    "Eye": { "knobs": { "at": 0, "fov": 30, "from": [0, 1, 2] },
             "nodes": { "eye": { "type": "Camera", "position": [0, "= knobs.at", 20], "fov": "= 2 * knobs.fov", "target": "= knobs.from" } },
             "outputs": { "eye": "eye" } },
    "Pair": { "knobs": { "high": 1 },
              "nodes": { "left": { "type": "Eye", "at": "= knobs.high" } }, "outputs": { "eye": "left" } }
  },
  "nodes": {
    "lead": { "type": "Camera", "position": [1.25, 4, 20] },
    "one": { "type": "Eye", "at": "= lead.position.x + 0.5", "fov": "= lead.fov", "from": "= lead.position" },
    "two": { "type": "Pair", "high": "= 2 * one.at" },
    "sky": { "type": "Mix", "a": "#2d3f52", "b": "#102030", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "sky" } }
}"##;

#[test]
fn a_linked_knob_of_a_use_shows_what_it_is_now() {
    let mut window = unseen_in(Session::new(BOATS.into(), None), [1600.0, 1400.0]);
    let faults = &editor(&window).state().session.meaning().diagnostics;
    assert!(editor(&window).state().session.meaning().graph.is_some(), "{faults:?}");
    choose(&mut window, "one");
    assert!(window.query_by_label("1.75").is_some(), "one component inside follows it");
    assert!(window.query_by_label("1.25, 4, 20").is_some());
    choose(&mut window, "two");
    assert!(window.query_by_label("3.5").is_some(), "the group inside hands it on");
}

/// Returns the place of a knob's name in Properties.
fn name(window: &Window, knob: &str) -> Pos2 {
    window.query_all_by_label(knob).last().unwrap().rect().left_center() + vec2(8.0, 0.0)
}

fn press(window: &mut Window, pos: Pos2, pressed: bool) {
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    window.event(Event::PointerButton { pos, button, pressed, modifiers });
    window.step();
}

/// Takes what is at a place, and goes with it to another one.
fn carry(window: &mut Window, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.step();
    press(window, from, true);
    for share in [0.3, 0.7, 1.0] {
        window.hover_at(from.lerp(to, share));
        window.step();
    }
    window.step();
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    carry(window, from, to);
    press(window, to, false);
    window.run_steps(3);
}

#[test]
fn a_name_dropped_on_another_knob_links_it_in_one_step_of_undo() {
    let mut window = open("range");
    let (from, to) = (name(&window, "min"), name(&window, "max"));
    carry(&mut window, from, to);
    window.get_by_label("= range.min");
    assert_eq!(text(&window), SHADE, "nothing is changed before it is dropped");
    press(&mut window, to, false);
    window.run_steps(3);
    assert_eq!(value(&window, "range", "max"), Some(json!("= range.min")));
    window.get_by_label("Link of range.max");
    assert!(window.query_by_label("= range.min").is_none(), "it is no longer held");
    assert_eq!(editor(&window).state().session.history().undoes(), Some("Link range.max"));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), SHADE);
    // On the field of the other knob, too.
    let (from, to) = (name(&window, "max"), fields(&window, "min")[0].center());
    drag(&mut window, from, to);
    assert_eq!(value(&window, "range", "min"), Some(json!("= range.max")));
}

#[test]
fn a_drag_of_a_field_changes_its_number() {
    let mut window = open("range");
    let (from, to) = (fields(&window, "max")[0].center(), name(&window, "min"));
    drag(&mut window, from, to);
    let max = value(&window, "range", "max").unwrap();
    assert!(max.is_number(), "{max}");
    assert_ne!(max, json!(0.75));
    assert_eq!(value(&window, "range", "min"), Some(json!(0.25)));
}

#[test]
fn esc_lets_go_of_a_name() {
    let mut window = open("range");
    let (from, to) = (name(&window, "min"), name(&window, "max"));
    carry(&mut window, from, to);
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_label("= range.min").is_none());
    press(&mut window, to, false);
    window.run_steps(3);
    assert_eq!(text(&window), SHADE);
    // Where nothing takes it, nothing happens either.
    let nowhere = window.get_by_label("No errors").rect().center();
    drag(&mut window, from, nowhere);
    assert_eq!(text(&window), SHADE);
}

#[test]
fn what_does_not_fit_or_leads_back_is_refused_with_the_reason() {
    let mut window = open("eye");
    let (from, to) = (name(&window, "position"), name(&window, "fov"));
    drag(&mut window, from, to);
    assert_eq!(text(&window), SHADE);
    window.get_by_label_contains("expected a number from");
    // Esc ends the message.
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_label_contains("expected a number from").is_none());
    // `other.min` follows `range.max` already.
    choose(&mut window, "other");
    let (from, to) = (name(&window, "min"), window.get_by_label("Node range, Clamp").rect().center());
    drag(&mut window, from, to);
    window.get_by_label("range follows other.min");
    window.get_by_role_and_label(Role::Button, "max").click();
    window.run_steps(3);
    window.get_by_label("range.max cannot follow other.min");
    window.get_by_label_contains("a value that leads back to itself: ");
    assert_eq!(text(&window), SHADE);
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert!(window.query_by_label("range.max cannot follow other.min").is_none());
}

#[test]
fn a_name_dropped_on_a_node_lists_what_can_follow_it() {
    let mut window = open("range");
    let node = |window: &Window, label: &str| window.get_by_label(label).rect().center();
    let (from, to) = (name(&window, "min"), node(&window, "Node eye, Camera"));
    drag(&mut window, from, to);
    window.get_by_label("eye follows range.min");
    // A number, and the components of a vector; no other vectors as a whole.
    assert!(window.query_by_label("target").is_none());
    window.get_by_label("position[2]").click();
    window.run_steps(3);
    assert_eq!(value(&window, "eye", "position"), Some(json!([1, 4, "= range.min"])));
    assert_eq!(editor(&window).state().session.history().undoes(), Some("Link eye.position[2]"));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), SHADE);
    // A color finds the colors of a node.
    choose(&mut window, "sky");
    let (from, to) = (name(&window, "b"), node(&window, "Node noise, Noise"));
    drag(&mut window, from, to);
    window.get_by_label("None of its knobs takes such a value.");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(text(&window), SHADE);
}

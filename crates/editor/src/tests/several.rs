//! Tests of the properties of several nodes.

use super::typing::{click, enter, fields};
use crate::actions::Action;
use crate::document::Session;
use crate::testing::{Window, act, editor, text, unseen_in, value};
use egui::accesskit::{Role, Toggled};
use egui::{Event, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::json;

const GRAIN: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 }, "working_space": "srgb",
  "frames": { "first": 1, "last": 9 },
  "nodes": {
    "camera": { "type": "Camera", "position": [0, 2, 30] },
    "fine": { "type": "Noise", "octaves": 6, "seed": 3 },
    "mid": { "type": "Noise", "octaves": 6 },
    "coarse": { "type": "Noise", "octaves": 2, "disabled": true },
    "range": { "type": "Clamp", "field": "fine", "min": 0.25, "max": 0.5 },
    "wide": { "type": "Clamp", "field": "mid", "min": { "keys": [[1, 0.1], [9, 0.2]] }, "max": 0.75 },
    "a": { "type": "Mix", "a": "#2d3f52", "b": "#f0cf8e", "weight": "range" },
    "b": { "type": "Mix", "a": "a", "b": "#f0cf8e", "weight": 0.5 },
    "c": { "type": "Mix", "a": "b", "b": "#104050", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "c" } }
}"##;

fn open(nodes: &[&str]) -> Window {
    let mut window = unseen_in(Session::new(GRAIN.into(), None), [1280.0, 1400.0]);
    assert!(editor(&window).state().session.meaning().graph.is_some());
    act(&mut window, Action::Select(nodes.iter().map(|name| (*name).to_string()).collect()));
    window
}

/// Types into a field that says that values are mixed.
fn type_mixed(window: &mut Window, label: &str, typed: &str) {
    let field = window.get_by_label(label).rect();
    click(window, field.center());
    // A refused text stays, to be corrected.
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    window.event(Event::Text(typed.into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn a_knob_that_all_have_alike_is_set_in_all_by_one_step() {
    let mut window = open(&["fine", "mid"]);
    window.get_by_label("2 × Noise");
    let octaves = fields(&window, "octaves")[0];
    enter(&mut window, octaves, "5");
    assert_eq!(["fine", "mid"].map(|node| value(&window, node, "octaves")), [Some(json!(5)), Some(json!(5))]);
    assert_eq!(value(&window, "coarse", "octaves"), Some(json!(2)), "only what is selected");
    assert_eq!(editor(&window).state().session.history().undoes(), Some("Set octaves of 2 nodes"));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), GRAIN);
}

#[test]
fn a_mixed_value_says_so_and_is_the_same_after_an_edit() {
    let mut window = open(&["coarse", "fine", "mid"]);
    assert!(fields(&window, "octaves").is_empty(), "a mixed value is no number");
    type_mixed(&mut window, "octaves, mixed", "2*2");
    for node in ["coarse", "fine", "mid"] {
        assert_eq!(value(&window, node, "octaves"), Some(json!(4)), "{node}");
    }
    assert_eq!(fields(&window, "octaves").len(), 1);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), GRAIN);
    // What is nonsense is refused in place, and nothing changes.
    type_mixed(&mut window, "octaves, mixed", "many");
    window.get_by_label_contains("found \"many\"; expected a whole number from 1 to");
    assert_eq!(text(&window), GRAIN);
}

#[test]
fn a_value_that_one_of_the_nodes_refuses_changes_none() {
    let mut window = open(&["range", "wide"]);
    type_mixed(&mut window, "max, mixed", "0.15");
    window.get_by_label_contains("found min 0.25 above max 0.15; expected min ≤ max");
    assert_eq!(text(&window), GRAIN);
    type_mixed(&mut window, "max, mixed", "0.875");
    assert_eq!(["range", "wide"].map(|node| value(&window, node, "max")), [Some(json!(0.875)), Some(json!(0.875))]);
}

#[test]
fn keyed_values_get_a_key_and_others_the_value() {
    let mut window = open(&["range", "wide"]);
    act(&mut window, Action::Frame(5));
    type_mixed(&mut window, "min, mixed", "0.125");
    assert_eq!(value(&window, "range", "min"), Some(json!(0.125)));
    assert_eq!(value(&window, "wide", "min"), Some(json!({ "keys": [[1, 0.1], [5, 0.125], [9, 0.2]] })));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), GRAIN);
}

#[test]
fn nodes_of_other_types_share_what_has_the_same_name_and_kind() {
    let mut window = open(&["fine", "camera"]);
    window.get_by_label("These nodes have no knob in common.");
    // Of ports, those are shared that nothing is connected to.
    act(&mut window, Action::Select(["b".to_string(), "c".to_string()].into()));
    assert!(window.query_by_label("a, mixed").is_none());
    type_mixed(&mut window, "weight, mixed", "3/4");
    type_mixed(&mut window, "b, mixed", "804020");
    for node in ["b", "c"] {
        assert_eq!(value(&window, node, "weight"), Some(json!(0.75)));
        assert_eq!(value(&window, node, "b"), Some(json!("#804020")));
    }
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), GRAIN);
    act(&mut window, Action::Select(["a".to_string(), "b".to_string()].into()));
    let color = window.query_all_by_value("#f0cf8e").last().unwrap().rect();
    click(&mut window, color.center());
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    window.event(Event::Text("#102030".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(["a", "b"].map(|node| value(&window, node, "b")), [Some(json!("#102030")), Some(json!("#102030"))]);
    assert_eq!(value(&window, "c", "b"), Some(json!("#104050")));
}

#[test]
fn all_are_disabled_and_enabled_together() {
    let mut window = open(&["coarse", "fine"]);
    let switch = |window: &Window| window.get_by_role_and_label(Role::CheckBox, "Disable").accesskit_node().toggled();
    assert_eq!(switch(&window), Some(Toggled::Mixed));
    let click = |window: &mut Window| {
        window.get_by_role_and_label(Role::CheckBox, "Disable").click();
        window.run_steps(3);
    };
    let off = |window: &Window| ["coarse", "fine"].map(|node| value(window, node, "disabled"));
    click(&mut window);
    assert_eq!((off(&window), switch(&window)), ([Some(json!(true)), Some(json!(true))], Some(Toggled::True)));
    click(&mut window);
    assert_eq!((off(&window), switch(&window)), ([None, None], Some(Toggled::False)));
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), GRAIN);
}

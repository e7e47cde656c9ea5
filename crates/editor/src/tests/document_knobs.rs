//! Knobs of the document.

use super::DUSK;
use crate::actions::Action;
use crate::document::{Path, Session};
use crate::testing::{Window, act, editor, unseen};
use egui::accesskit::Role;
use egui::{Event, Key, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};

/// A storm that a knob of the document makes, with all types of values.
fn storm() -> String {
    let text = DUSK.replace(r#""weight": 0.25"#, r#""weight": "= knobs.storm / 4""#);
    text.replace(
        r#""nodes": {"#,
        r##""knobs": { "storm": { "value": 1, "min": 0, "max": 2, "help": "Strength of the storm." }, "ink": "#14262e", "on": true },
  "nodes": {"##,
    )
}

fn open() -> Window {
    unseen(Session::new(storm(), None))
}

fn knob(window: &Window, name: &str) -> Option<Value> {
    editor(window).state().session.sheet().get(&Path::default().to("knobs").to(name)).cloned()
}

fn type_into(window: &mut Window, label: &str, text: &str) {
    window.get_by_label(label).focus();
    window.run_steps(2);
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    window.event(Event::Text(text.into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(4);
}

fn menu(window: &mut Window, name: &str) {
    window.get_by_label(&format!("Menu of {name}")).click();
    window.run_steps(4);
}

#[test]
fn they_are_set_when_nothing_is_selected() {
    let mut window = open();
    for name in ["storm", "ink", "on"] {
        assert!(window.query_all_by_label(name).next().is_some(), "{name} is shown");
    }
    let is_storm = |field: &egui_kittest::Node<'_>| field.accesskit_node().numeric_value() == Some(1.0);
    let fields: Vec<_> = window.get_all_by_role(Role::SpinButton).filter(is_storm).collect();
    // First frame is 1, too.
    fields.last().unwrap().focus();
    window.run_steps(2);
    window.event(Event::Text("1.5".into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(knob(&window, "storm").unwrap()["value"], json!(1.5));
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), storm());
}

#[test]
fn a_new_name_is_followed_by_links() {
    let mut window = open();
    menu(&mut window, "storm");
    type_into(&mut window, "Name of the knob storm", "gale");
    let state = editor(&window).state();
    assert_eq!(state.sheet().get(&Path::node("dusk").to("weight")), Some(&json!("= knobs.gale / 4")));
    assert!(knob(&window, "gale").is_some() && knob(&window, "storm").is_none());
    assert_eq!(state.session.meaning().errors().count(), 0);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), storm(), "in one step");
}

#[test]
fn a_knob_that_is_followed_says_who_does_and_stays() {
    let mut window = open();
    menu(&mut window, "storm");
    window.get_by_label_contains("dusk.weight follows it");
    window.get_by_label("Delete").click();
    window.run_steps(3);
    assert!(knob(&window, "storm").is_some());
    window.key_press(Key::Escape);
    window.run_steps(3);
    menu(&mut window, "on");
    window.get_by_label("Delete").click();
    window.run_steps(3);
    assert_eq!(knob(&window, "on"), None);
}

#[test]
fn knobs_are_added_and_described() {
    let mut window = open();
    window.get_by_label("Add knob").click();
    window.run_steps(4);
    assert_eq!(knob(&window, "knob"), Some(json!({ "value": 0, "min": 0, "max": 1 })));
    menu(&mut window, "knob");
    type_into(&mut window, "help of the knob knob", "How far.");
    assert_eq!(knob(&window, "knob").unwrap()["help"], json!("How far."));
    type_into(&mut window, "max of the knob knob", "5");
    assert_eq!(knob(&window, "knob").unwrap()["max"].as_f64(), Some(5.0));
    // A value without a description gets one.
    window.key_press(Key::Escape);
    window.run_steps(3);
    menu(&mut window, "ink");
    type_into(&mut window, "help of the knob ink", "Color of the lines.");
    assert_eq!(knob(&window, "ink"), Some(json!({ "value": "#14262e", "help": "Color of the lines." })));
    assert_eq!(editor(&window).state().session.meaning().errors().count(), 0);
}

#[test]
fn a_knob_of_a_node_becomes_one_of_the_document() {
    let mut window = unseen(Session::new(DUSK.into(), None));
    act(&mut window, Action::Select(["dusk".to_string()].into()));
    let at = window.get_all_by_label("weight").next().unwrap().rect().center();
    window.hover_at(at);
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Secondary, egui::Modifiers::NONE);
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        window.step();
    }
    window.run_steps(3);
    window.get_by_label("Make it a knob of the document").click();
    window.run_steps(4);
    let state = editor(&window).state();
    assert_eq!(state.sheet().get(&Path::node("dusk").to("weight")), Some(&json!("= knobs.weight")));
    assert_eq!(knob(&window, "weight").unwrap()["value"], json!(0.25));
    assert_eq!(state.session.meaning().errors().count(), 0);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

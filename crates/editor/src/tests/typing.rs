//! Numbers, colors and names as they are typed: entered, refused in words, or left alone.

use super::DUSK;
use crate::actions::Action;
use crate::document::{Path, Session};
use crate::testing::{Window, editor, unseen};
use egui::accesskit::Role;
use egui::{Event, Key, Rect};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};

const NOISE: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 },
  "nodes": {
    "camera": { "type": "Camera", "position": [0.123456789, 2, 30] },
    "noise": { "type": "Noise" },
    "sky": { "type": "Mix", "a": "#2d3f52", "b": "#f0cf8e", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "sky" } }
}"##;

fn open(text: &str, node: &str) -> Window {
    let mut window = unseen(Session::new(text.into(), None));
    choose(&mut window, node);
    window
}

fn act(window: &mut Window, action: Action) {
    let context = window.ctx.clone();
    window.state_mut().as_mut().unwrap().act(action, &context);
    window.run_steps(2);
}

fn choose(window: &mut Window, node: &str) {
    act(window, Action::Select([node.to_string()].into()));
}

fn value(window: &Window, node: &str, knob: &str) -> Option<Value> {
    editor(window).state().sheet().get(&Path::node(node).to(knob)).cloned()
}

/// The fields of numbers that stand in the row of a name.
pub(super) fn fields(window: &Window, name: &str) -> Vec<Rect> {
    let row = window.query_all_by_label(name).last().unwrap().rect();
    let all = window.query_all_by_role(Role::SpinButton).map(|field| field.rect());
    all.filter(|field| field.left() > row.left() && (field.center().y - row.center().y).abs() < 8.0).collect()
}

fn click(window: &mut Window, at: egui::Pos2) {
    window.hover_at(at);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    window.run_steps(2);
}

/// Writes a text over what a field holds, and enters it.
fn enter(window: &mut Window, field: Rect, text: &str) {
    click(window, field.center());
    window.event(Event::Text(text.into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn a_whole_number_that_is_not_set_shows_its_default_and_is_set_by_typing_alone() {
    let mut window = open(NOISE, "noise");
    let field = fields(&window, "octaves")[0];
    let shown = window.query_all_by_role(Role::SpinButton).find(|node| node.rect() == field).unwrap();
    assert_eq!(shown.accesskit_node().numeric_value(), Some(4.0));
    enter(&mut window, field, "6");
    assert_eq!(value(&window, "noise", "octaves"), Some(json!(6)));
    assert!(editor(&window).state().session.text().contains("\"octaves\": 6"));
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), NOISE);
}

#[test]
fn what_is_no_such_number_is_refused_in_words_and_changes_nothing() {
    for (node, knob, typed, message) in [
        ("noise", "octaves", "2.5", "found \"2.5\"; expected a whole number from 1 to"),
        ("noise", "octaves", "999", "found \"999\"; expected a whole number from 1 to"),
        ("noise", "octaves", "many", "found \"many\"; expected a whole number from 1 to"),
        ("sky", "weight", "1.5", "found \"1.5\"; expected a number from 0 to 1"),
        ("sky", "weight", "1/2", "found \"1/2\"; expected a number from 0 to 1"),
    ] {
        let mut window = open(NOISE, node);
        let before: Vec<Rect> = fields(&window, knob);
        enter(&mut window, before[0], typed);
        assert_eq!(editor(&window).state().session.text(), NOISE, "{typed}");
        assert!(editor(&window).state().session.history().undoes().is_none());
        window.get_by_label_contains(message);
        assert_eq!(fields(&window, knob), before, "the message moves nothing");
        // Another try.
        let right = if node == "sky" { "0.75" } else { "3" };
        enter(&mut window, before[0], right);
        assert!(window.query_by_label_contains("found \"").is_none());
        assert_eq!(value(&window, node, knob).and_then(|value| value.as_f64()), right.parse().ok());
    }
}

#[test]
fn a_field_that_is_entered_and_left_keeps_every_digit() {
    let mut window = open(NOISE, "camera");
    let field = fields(&window, "position")[0];
    click(&mut window, field.center());
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.text(), NOISE);
}

#[test]
fn a_drag_stays_within_the_range() {
    let mut window = open(NOISE, "noise");
    let field = fields(&window, "octaves")[0];
    let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
    for (to, most) in [(4000.0, true), (-4000.0, false)] {
        let at = field.center();
        window.hover_at(at);
        window.event(Event::PointerButton { pos: at, button, pressed: true, modifiers });
        window.step();
        for step in 1..=4 {
            window.event(Event::PointerMoved(at + egui::vec2(to * step as f32 / 4.0, 0.0)));
            window.step();
        }
        window.event(Event::PointerButton { pos: at + egui::vec2(to, 0.0), button, pressed: false, modifiers });
        window.run_steps(3);
        let found = value(&window, "noise", "octaves").and_then(|value| value.as_i64()).unwrap();
        assert!(if most { found > 4 } else { found == 1 }, "{found}");
        assert!(editor(&window).state().session.meaning().graph.is_some(), "{found} is legal");
    }
}

#[test]
fn a_color_that_is_none_stays_to_be_mended() {
    let mut window = open(NOISE, "sky");
    let field = window.query_all_by_value("#2d3f52").last().unwrap().rect();
    let all = |window: &mut Window, text: &str| {
        click(window, field.center());
        window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        window.event(Event::Text(text.into()));
        window.key_press(Key::Enter);
        window.run_steps(3);
    };
    all(&mut window, "#2d3fzz");
    assert_eq!(editor(&window).state().session.text(), NOISE);
    window.get_by_label_contains("found \"#2d3fzz\"; expected a color as #rrggbb");
    assert!(window.query_all_by_value("#2d3fzz").next().is_some(), "it stays to be mended");
    all(&mut window, "804020");
    assert_eq!(value(&window, "sky", "a"), Some(json!("#804020")));
    assert!(window.query_by_label_contains("found \"").is_none());
}

#[test]
fn a_name_that_is_none_stays_to_be_mended_and_esc_gives_back_what_was_there() {
    let mut window = unseen(Session::new(DUSK.into(), None));
    choose(&mut window, "sky");
    let field = window.query_all_by_value("sky").next().unwrap().rect();
    click(&mut window, field.center());
    window.event(Event::Text("!".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    window.get_by_label_contains("expected a name of letters, digits and _");
    assert_eq!(editor(&window).state().session.text(), DUSK);
    click(&mut window, field.center());
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_all_by_value("sky").next().is_some());
    assert!(window.query_by_label_contains("expected a name").is_none());
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

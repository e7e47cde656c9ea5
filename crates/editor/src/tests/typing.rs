//! Tests of typed numbers, colors, and names: accepted, refused with a message, or left unchanged.

use super::DUSK;
use crate::actions::{Action, After};
use crate::document::{Path, Session};
use crate::testing::{Window, act, choose, editor, unseen, unseen_in, value};
use egui::accesskit::Role;
use egui::{Event, Key, Rect};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::json;

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
    let mut window = unseen_in(Session::new(text.into(), None), [1280.0, 1400.0]);
    choose(&mut window, node);
    window
}

/// Returns the number fields in the row of a label.
pub(super) fn fields(window: &Window, name: &str) -> Vec<Rect> {
    let row = window.query_all_by_label(name).last().unwrap().rect();
    let all = window.query_all_by_role(Role::SpinButton).map(|field| field.rect());
    all.filter(|field| field.left() > row.left() && (field.center().y - row.center().y).abs() < 8.0).collect()
}

pub(super) fn click(window: &mut Window, at: egui::Pos2) {
    window.hover_at(at);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    window.run_steps(2);
}

/// Replaces the text of a field, and presses Enter.
pub(super) fn enter(window: &mut Window, field: Rect, text: &str) {
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
fn an_invalid_number_is_refused_with_a_message_and_changes_nothing() {
    for (node, knob, typed, message) in [
        ("noise", "octaves", "2.5", "found \"2.5\"; expected a whole number from 1 to"),
        ("noise", "octaves", "999", "found \"999\"; expected a whole number from 1 to"),
        ("noise", "octaves", "many", "found \"many\"; expected a whole number from 1 to"),
        ("sky", "weight", "1.5", "found \"1.5\"; expected a number from 0 to 1"),
        ("sky", "weight", "3/2", "found 1.5, the value of \"3/2\"; expected a number from 0 to 1"),
        ("sky", "weight", "2*(3", "found the end at column 5 of \"2*(3\"; expected ')'"),
    ] {
        let mut window = open(NOISE, node);
        let before: Vec<Rect> = fields(&window, knob);
        enter(&mut window, before[0], typed);
        assert_eq!(editor(&window).state().session.text(), NOISE, "{typed}");
        assert!(editor(&window).state().session.history().undoes().is_none());
        window.get_by_label_contains(message);
        assert_eq!(fields(&window, knob), before, "the message moves nothing");
        // A legal value removes the message.
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
fn esc_gives_up_what_was_typed() {
    for typed in ["7", "999", "many"] {
        let mut window = open(NOISE, "noise");
        let field = fields(&window, "octaves")[0];
        click(&mut window, field.center());
        window.event(Event::Text(typed.into()));
        window.run_steps(2);
        window.key_press(Key::Escape);
        window.run_steps(4);
        assert_eq!(editor(&window).state().session.text(), NOISE, "{typed}");
        assert!(refusals(&window).is_empty(), "{typed}");
        // Esc ends only the current input.
        enter(&mut window, field, "5");
        assert_eq!(value(&window, "noise", "octaves"), Some(json!(5)), "{typed}");
    }
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
fn an_invalid_color_stays_to_be_corrected() {
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
    assert!(window.query_all_by_value("#2d3fzz").next().is_some(), "the text stays, to be corrected");
    all(&mut window, "804020");
    assert_eq!(value(&window, "sky", "a"), Some(json!("#804020")));
    assert!(window.query_by_label_contains("found \"").is_none());
}

#[test]
fn an_invalid_name_stays_to_be_corrected_and_esc_restores_the_old_one() {
    let mut window = unseen(Session::new(DUSK.into(), None));
    choose(&mut window, "sky");
    let field = window.query_all_by_value("sky").next().unwrap().rect();
    click(&mut window, field.center());
    window.event(Event::Text("!".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    window.get_by_label_contains("expected a name of a–z, A–Z, 0–9 and _");
    assert_eq!(editor(&window).state().session.text(), DUSK);
    click(&mut window, field.center());
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_all_by_value("sky").next().is_some());
    assert!(window.query_by_label_contains("expected a name").is_none());
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

/// Returns the places of messages about refused values.
fn refusals(window: &Window) -> Vec<Rect> {
    window.query_all_by_label_contains("found \"").map(|said| said.rect()).collect()
}

#[test]
fn a_refusal_goes_with_what_was_typed() {
    let refused = || {
        let mut window = open(NOISE, "noise");
        let fields = |name: &str| fields(&window, name)[0];
        let (octaves, lacunarity) = (fields("octaves"), fields("lacunarity"));
        enter(&mut window, lacunarity, "3");
        enter(&mut window, octaves, "999");
        assert_eq!(refusals(&window).len(), 1);
        window
    };
    let other = |window: &mut Window| {
        let field = fields(window, "gain")[0];
        enter(window, field, "0.25");
    };
    let again = |window: &mut Window| {
        let field = fields(window, "octaves")[0];
        click(window, field.center());
    };
    let escape = |window: &mut Window| {
        window.key_press(Key::Escape);
        window.run_steps(2);
    };
    let ways: [&dyn Fn(&mut Window); 7] = [
        &other,
        &again,
        &escape,
        &|window| act(window, Action::Undo),
        &|window| choose(window, "sky"),
        &|window| act(window, Action::Output(Some("beauty".into()))),
        &|window| {
            let context = window.ctx.clone();
            window.state_mut().as_mut().unwrap().go(After::New, &context);
        },
    ];
    for (index, way) in ways.into_iter().enumerate() {
        let mut window = refused();
        way(&mut window);
        window.run_steps(2);
        assert!(refusals(&window).is_empty(), "way {index}");
        // The message does not return with its field.
        if index == 4 {
            choose(&mut window, "noise");
            assert!(refusals(&window).is_empty());
        }
    }
}

#[test]
fn one_refusal_is_said_at_a_time_below_its_field_within_the_panel() {
    let mut window = open(NOISE, "noise");
    let named = |window: &Window, name: &str| window.query_all_by_label(name).last().unwrap().rect();
    for name in ["octaves", "gain"] {
        let (field, row) = (fields(&window, name)[0], named(&window, name));
        enter(&mut window, field, "many words that are no number, and more than a line of them");
        let said = refusals(&window);
        assert_eq!(said.len(), 1, "{name}");
        assert!(said[0].top() >= field.bottom() && said[0].top() < field.bottom() + 20.0, "{:?} {field:?}", said[0]);
        assert!(said[0].left() >= row.left() - 8.0 && said[0].right() <= 1280.0, "{:?} {row:?}", said[0]);
        assert!(said[0].height() > 20.0, "the text is wrapped");
    }
}

#[test]
fn refused_text_leaves_its_field_with_the_message() {
    let mut window = open(NOISE, "sky");
    let field = window.query_all_by_value("#2d3f52").last().unwrap().rect();
    click(&mut window, field.center());
    window.event(Event::Text("zz".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(refusals(&window).len(), 1);
    let weight = fields(&window, "weight")[0];
    enter(&mut window, weight, "0.5");
    assert!(refusals(&window).is_empty());
    assert!(window.query_all_by_value("#2d3f52").next().is_some(), "the field shows what the document says");
}

pub(super) const LISTS: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 }, "working_space": "srgb",
  "nodes": {
    "down": { "type": "ScreenY" },
    "marks": { "type": "Shape", "shapes": [
      { "form": "disc" }, { "form": "box", "size": [0.2, 0.1] }
    ] },
    "steps": { "type": "Bands", "field": "down", "thresholds": [0.25, 0.5] },
    "range": { "type": "Clamp", "field": "down", "min": 0.25, "max": 0.75 },
    "sky": { "type": "Ramp", "weight": "range", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.5, "color": "#804020" }, { "at": 1, "color": "#f0cf8e" }
    ] }
  },
  "outputs": { "beauty": { "color": "sky" } }
}"##;

#[test]
fn a_value_that_validation_refuses_gets_a_message_and_changes_nothing() {
    let window = open(LISTS, "sky");
    assert!(editor(&window).state().session.meaning().graph.is_some());
    for (node, knob, typed, message) in [
        ("marks", "size", "-5", "found a negative size of shapes[1]; expected width and height ≥ 0"),
        ("marks", "size", "1e99", "found 1e99; expected a"),
        ("range", "min", "0.9", "found min 0.9 above max 0.75; expected min ≤ max"),
        ("sky", "at", "0.25", "found a stop at 0.25 after one at 0.5; expected stops in ascending order"),
    ] {
        let mut window = open(LISTS, node);
        let before = fields(&window, knob);
        enter(&mut window, *before.last().unwrap(), typed);
        assert_eq!(editor(&window).state().session.text(), LISTS, "{typed}");
        assert!(editor(&window).state().session.history().undoes().is_none());
        window.get_by_label_contains(message);
        assert_eq!(fields(&window, knob), before, "the message moves nothing");
        enter(&mut window, *before.last().unwrap(), "0.625");
        assert!(window.query_by_label_contains(message).is_none());
        assert_ne!(editor(&window).state().session.text(), LISTS);
    }
}

#[test]
fn a_list_out_of_order_is_refused_and_stays_to_be_corrected() {
    let mut window = open(LISTS, "steps");
    let all = |window: &mut Window, shown: &str, text: &str| {
        let field = window.query_all_by_value(shown).last().unwrap().rect();
        click(window, field.center());
        window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        window.event(Event::Text(text.into()));
        window.key_press(Key::Enter);
        window.run_steps(3);
    };
    all(&mut window, "[0.25, 0.5]", "[0.5, 0.25]");
    assert_eq!(editor(&window).state().session.text(), LISTS);
    window.get_by_label_contains("found 0.25 after 0.5; expected ascending thresholds");
    all(&mut window, "[0.5, 0.25]", "[0.5, 0.75]");
    assert_eq!(value(&window, "steps", "thresholds"), Some(json!([0.5, 0.75])));
    assert!(window.query_by_label_contains("found 0.25").is_none());
}

#[test]
fn intermediate_steps_are_not_refused() {
    // The node already had a fault before the edit.
    let mut window = open(&LISTS.replace("[0.2, 0.1]", "[-0.2, -0.1]"), "marks");
    assert!(editor(&window).state().session.meaning().graph.is_none());
    let size = fields(&window, "size");
    enter(&mut window, size[size.len() - 2], "0.5");
    assert!(editor(&window).state().session.text().contains("[0.5, -0.1]"));
    // A fault elsewhere does not block the edit.
    let mut window = open(&LISTS.replace("\"weight\": \"range\"", "\"weight\": \"rang\""), "range");
    let text = editor(&window).state().session.text().to_string();
    let min = fields(&window, "min")[0];
    enter(&mut window, min, "0.5");
    assert_eq!(editor(&window).state().session.text(), text.replace("\"min\": 0.25", "\"min\": 0.5"));
    // A polygon also needs points, so the choice alone is incomplete.
    let mut window = open(LISTS, "marks");
    window.get_all_by_role(Role::ComboBox).last().unwrap().click();
    window.run_steps(3);
    window.get_all_by_label("polygon").last().unwrap().click();
    window.run_steps(3);
    assert!(editor(&window).state().session.text().contains("\"polygon\""));
}

#[test]
fn a_drag_stops_at_the_last_value_that_the_document_accepts() {
    let mut window = open(LISTS, "marks");
    let field = *fields(&window, "size").last().unwrap();
    let (button, modifiers, at) = (egui::PointerButton::Primary, egui::Modifiers::NONE, field.center());
    window.hover_at(at);
    window.event(Event::PointerButton { pos: at, button, pressed: true, modifiers });
    window.step();
    for step in 1..=20 {
        window.event(Event::PointerMoved(at - egui::vec2(4.0 * step as f32, 0.0)));
        window.step();
    }
    window.event(Event::PointerButton { pos: at - egui::vec2(80.0, 0.0), button, pressed: false, modifiers });
    window.run_steps(3);
    let size = value(&window, "marks", "shapes").unwrap()[1]["size"][1].as_f64().unwrap();
    assert!((0.0..0.1).contains(&size), "{size}");
    assert!(editor(&window).state().session.meaning().graph.is_some());
    window.get_by_label_contains("expected width and height ≥ 0");
}

#[test]
fn a_very_large_number_is_short_until_it_is_edited() {
    let mut window = open(&LISTS.replace("\"min\": 0.25", "\"min\": -123456789012345678900"), "range");
    let field = fields(&window, "min")[0];
    assert!(field.width() < 110.0, "{field:?}");
    click(&mut window, field.center());
    assert!(window.query_all_by_value("-123456789012345680000").next().is_some());
    window.key_press(Key::Tab);
    window.run_steps(3);
    assert!(editor(&window).state().session.history().undoes().is_none(), "all its digits stay");
}

#[test]
fn what_is_not_set_can_be_added_and_taken_away_again() {
    let text = LISTS.replace("{ \"form\": \"box\", ", "{ \"form\": \"box\", \"points\": [0, 0, 1, 0, 0, 1], ");
    let mut window = open(&text, "marks");
    window.get_by_label("Add points").click();
    window.run_steps(3);
    let points =
        |window: &Window, shape: usize| value(window, "marks", "shapes").unwrap()[shape].get("points").cloned();
    assert!(points(&window, 0).is_some());
    assert!(editor(&window).state().session.meaning().graph.is_some());
    window.get_all_by_label("×").last().unwrap().click();
    window.run_steps(3);
    assert_eq!(points(&window, 1), None);
    window.get_by_label("Add points");
}

#[test]
fn a_stop_that_is_added_is_legal() {
    let mut window = open(LISTS, "sky");
    window.get_by_label("Add").click();
    window.run_steps(3);
    let stops = value(&window, "sky", "stops").unwrap();
    assert_eq!(stops[3]["at"], json!(1));
    assert!(editor(&window).state().session.meaning().graph.is_some());
}

/// What stands beside fields, such as names and diamonds, takes no focus.
#[test]
fn tab_goes_from_number_to_number() {
    let mut window = open(NOISE, "camera");
    let position = fields(&window, "position");
    click(&mut window, position[2].center());
    window.event(Event::Text("31".into()));
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.event(Event::Text("7".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(value(&window, "camera", "position").unwrap()[2], 31);
    let camera = editor(&window).state().sheet().get(&Path::node("camera")).cloned().unwrap();
    assert_eq!(camera["target"][0], 7, "{camera}");
}

//! Tests of typed formulas and links.

use super::typing::{click, enter, fields};
use crate::actions::{Action, Pane};
use crate::document::{Session, edit};
use crate::testing::{Window, act, choose, editor, finished, text, unseen_in, value, window};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use serde_json::json;

const SHADE: &str = r##"{
  "trochoid": 1, "format": { "width": 1280, "height": 720 }, "working_space": "srgb",
  "frames": { "first": 1, "last": 5, "fps": 24 },
  "knobs": { "storm": 0.5, "ink": "#102030", "word": "cellular" },
  "nodes": {
    "camera": { "type": "Camera", "position": [0, 2, 30] },
    "eye": { "type": "Camera", "position": ["= camera.position.x", 4, 20] },
    "noise": { "type": "Noise", "octaves": 4 },
    "range": { "type": "Clamp", "field": "noise", "min": 0.25, "max": "= range.min + knobs.storm/2" },
    "sky": { "type": "Mix", "a": "#2d3f52", "b": "= knobs.ink", "weight": "range" }
  },
  "outputs": { "beauty": { "color": "sky" } }
}"##;

fn open(node: &str) -> Window {
    let mut window = unseen_in(Session::new(SHADE.into(), None), [1280.0, 1400.0]);
    let faults = &editor(&window).state().session.meaning().diagnostics;
    assert!(editor(&window).state().session.meaning().graph.is_some(), "{faults:?}");
    choose(&mut window, node);
    window
}

/// Replaces the text of a link's field.
fn relink(window: &mut Window, label: &str, typed: &str) {
    let field = window.get_by_label(label).rect();
    click(window, field.center());
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(Event::Text(typed.into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn a_formula_of_numbers_becomes_its_value() {
    let mut window = open("range");
    let min = fields(&window, "min")[0];
    enter(&mut window, min, "1/8");
    assert_eq!(value(&window, "range", "min"), Some(json!(0.125)));
    choose(&mut window, "camera");
    let position = fields(&window, "position");
    enter(&mut window, position[1], "1280/2");
    assert_eq!(value(&window, "camera", "position"), Some(json!([0, 640, 30])));
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), SHADE);
    // The document's format takes formulas, too, but no links.
    act(&mut window, Action::Select(Default::default()));
    let width = fields(&window, "Width")[0];
    enter(&mut window, width, "1920/2");
    assert_eq!(editor(&window).state().sheet().format, [960, 720]);
    enter(&mut window, width, "= knobs.storm");
    window.get_by_label_contains("found \"= knobs.storm\"; expected a whole number from 1 to 65536");
}

#[test]
fn a_typed_link_follows_another_knob_and_is_shown_with_its_value() {
    let mut window = open("range");
    let min = fields(&window, "min")[0];
    enter(&mut window, min, "=knobs.storm/4");
    assert_eq!(value(&window, "range", "min"), Some(json!("= knobs.storm/4")));
    assert!(fields(&window, "min").is_empty(), "a link is no number");
    window.get_by_label("Link of range.min");
    window.get_by_label("0.125");
    window.get_by_label("0.375");
    // It is edited in place.
    relink(&mut window, "Link of range.min", "= knobs.storm/2");
    assert_eq!(value(&window, "range", "min"), Some(json!("= knobs.storm/2")));
    // A value that is typed ends it.
    relink(&mut window, "Link of range.min", "1/16");
    assert_eq!(value(&window, "range", "min"), Some(json!(0.0625)));
    assert_eq!(fields(&window, "min").len(), 1);
    for _ in 0..3 {
        act(&mut window, Action::Undo);
    }
    assert_eq!(text(&window), SHADE);
}

#[test]
fn a_link_to_what_is_not_there_is_refused_with_what_was_meant() {
    let mut window = open("range");
    let min = fields(&window, "min")[0];
    for (typed, message) in [
        (
            "= nois.gain",
            "found a link to \"nois\", which is not a node; expected the name of a node; did you mean \"noise\"?",
        ),
        (
            "= noise.gian",
            "found a link to \"gian\" of \"noise\"; expected one of its knobs; did you mean \"noise.gain\"?",
        ),
        ("= range.max", "range"),
        ("= 1 +", "found the end"),
    ] {
        enter(&mut window, min, typed);
        assert_eq!(text(&window), SHADE, "{typed}");
        assert!(window.query_all_by_label_contains(message).next().is_some(), "{typed}");
        assert_eq!(fields(&window, "min"), [min], "the field stays");
    }
    relink(&mut window, "Link of range.max", "= knobs.strom");
    assert_eq!(text(&window), SHADE);
    window.get_by_label_contains("did you mean \"knobs.storm\"?");
}

#[test]
fn a_removed_link_leaves_the_value_that_it_had() {
    let mut window = open("range");
    window.get_by_label("Unlink range.max").click();
    window.run_steps(3);
    assert_eq!(value(&window, "range", "max"), Some(json!(0.5)));
    act(&mut window, Action::Undo);
    choose(&mut window, "sky");
    window.get_by_label("Link of sky.b");
    window.get_by_label("Unlink sky.b").click();
    window.run_steps(3);
    let color = value(&window, "sky", "b").unwrap();
    let near = |index: usize, byte: f64| (color[index].as_f64().unwrap() - byte / 255.0).abs() < 1e-6;
    assert!(near(0, 16.0) && near(1, 32.0) && near(2, 48.0), "{color}");
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), SHADE);
}

#[test]
fn components_colors_and_words_are_linked() {
    let mut window = open("eye");
    relink(&mut window, "Link of eye.position[0]", "= camera.position.z/2");
    assert_eq!(value(&window, "eye", "position"), Some(json!(["= camera.position.z/2", 4, 20])));
    let position = fields(&window, "position");
    assert_eq!(position.len(), 2, "the others are numbers");
    enter(&mut window, position[0], "= camera.position.y");
    assert_eq!(value(&window, "eye", "position"), Some(json!(["= camera.position.z/2", "= camera.position.y", 20])));
    relink(&mut window, "Link of eye.position[1]", "7");
    assert_eq!(value(&window, "eye", "position"), Some(json!(["= camera.position.z/2", 7, 20])));
    choose(&mut window, "sky");
    let color = window.query_all_by_value("#2d3f52").last().unwrap().rect();
    click(&mut window, color.center());
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(Event::Text("= knobs.ink".into()));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(value(&window, "sky", "a"), Some(json!("= knobs.ink")));
    // What is not typed is linked by its menu.
    choose(&mut window, "noise");
    let before = text(&window).to_string();
    window.query_all_by_label("kind").last().unwrap().click_secondary();
    window.run_steps(3);
    window.get_by_label("Link …").click();
    window.run_steps(4);
    window.get_by_label("Link of noise.kind");
    window.event(Event::Text("= knobs.word".into()));
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert_eq!(value(&window, "noise", "kind"), Some(json!("= knobs.word")));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before);
    // A link that was begun is given up by Esc.
    window.query_all_by_label("kind").last().unwrap().click_secondary();
    window.run_steps(3);
    window.get_by_label("Link …").click();
    window.run_steps(4);
    window.key_press(Key::Escape);
    window.run_steps(4);
    assert!(window.query_by_label("Link of noise.kind").is_none());
    assert_eq!(text(&window), before);
}

#[test]
fn links_follow_renamed_and_copied_nodes() {
    let mut window = open("range");
    let rename = edit::renamed(editor(&window).state().sheet(), "range", "band");
    act(&mut window, Action::Edit(rename));
    assert_eq!(value(&window, "band", "max"), Some(json!("= band.min + knobs.storm/2")));
    let rename = edit::renamed(editor(&window).state().sheet(), "camera", "ship");
    act(&mut window, Action::Edit(rename));
    assert_eq!(value(&window, "eye", "position"), Some(json!(["= ship.position.x", 4, 20])));
    assert!(editor(&window).state().session.meaning().graph.is_some());
    // A copy follows its own knobs, and those of nodes that are not copied.
    act(&mut window, Action::Select(["band".to_string(), "eye".to_string()].into()));
    act(&mut window, Action::Duplicate);
    assert_eq!(value(&window, "band2", "max"), Some(json!("= band2.min + knobs.storm/2")));
    assert_eq!(value(&window, "eye2", "position"), Some(json!(["= ship.position.x", 4, 20])));
    act(&mut window, Action::Select(["sky".to_string()].into()));
    act(&mut window, Action::Duplicate);
    assert_eq!(value(&window, "sky2", "b"), Some(json!("= knobs.ink")), "a linked port stays linked");
    act(&mut window, Action::Panel(Pane::Text));
    assert!(editor(&window).state().session.meaning().graph.is_some());
}

#[test]
fn what_follows_other_nodes_and_knobs_is_viewed() {
    // Neither node that the weight follows is connected to what is viewed.
    let text = SHADE.replace("\"weight\": \"range\"", "\"weight\": \"= eye.position.y/8 + eye.position.x\"");
    let text = text.replace("\"width\": 1280, \"height\": 720", "\"width\": 16, \"height\": 9");
    let mut window = window(Session::new(text, None), None);
    finished(&mut window);
    let seen = &editor(&window).state().evaluated;
    assert_eq!(seen.failed, None);
    // The middle between #2d3f52 and #102030.
    assert_eq!(seen.result.as_ref().unwrap().screen.pixels[..3], [0x1f, 0x30, 0x41]);
}

//! Presets of nodes, and layouts of the panels.

use super::DUSK;
use crate::actions::{Action, Layout, Pane};
use crate::document::{Edit, Path, Session};
use crate::layout;
use crate::testing::{Window, act, ask, editor, graph, window};
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::Queryable;
use serde_json::json;
use std::path::Path as File;

fn open(data: &File) -> Window {
    window(Session::new(DUSK.into(), None), Some(data.to_path_buf()))
}

fn select(window: &mut Window, names: &[&str]) {
    act(window, Action::Select(names.iter().map(|name| (*name).to_string()).collect()));
}

fn name(window: &mut Window, label: &str, name: &str) {
    window.get_by_label(label);
    window.event(Event::Text(name.into()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(4);
}

fn preset(data: &File) -> std::path::PathBuf {
    data.join("presets/Ramp/evening.json")
}

/// Keeps the knobs of the ramp as a preset.
fn keep(window: &mut Window) {
    select(window, &["sky"]);
    act(window, Action::NamePreset);
    name(window, "Name of the preset", "evening");
}

#[test]
fn knobs_are_kept_and_given_to_another_node() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    keep(&mut window);
    let text = trochoid::io::read_text(preset(folder.path()), 1 << 20).unwrap();
    let written: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&written["type"], &written["knobs"]["stops"][1]["color"]), (&json!("Ramp"), &json!("#f0cf8e")));
    act(&mut window, Action::Edit(Edit::set(Path::node("sky").to("stops").to(1).to("color"), &json!("#102030"))));
    let before = editor(&window).state().session.text().to_string();
    select(&mut window, &["sky"]);
    act(&mut window, Action::Preset("evening".into()));
    let written: serde_json::Value = serde_json::from_str(DUSK).unwrap();
    assert_eq!(editor(&window).state().sheet().value, written, "only what differs is written");
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), before, "in one step");
    // A new node gets it from the list of types.
    select(&mut window, &[]);
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.event(Event::Text("evening".into()));
    window.run_steps(3);
    window.get_by_label("Ramp: evening");
    window.key_press(Key::Enter);
    window.run_steps(6);
    let state = editor(&window).state();
    let place = Path::node(state.chosen().unwrap()).to("stops").to(1).to("color");
    assert_eq!(state.sheet().get(&place), Some(&json!("#f0cf8e")));
}

#[test]
fn a_preset_with_a_knob_that_is_no_more_is_told_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    keep(&mut window);
    let file = preset(folder.path());
    let text = trochoid::io::read_text(&file, 1 << 20).unwrap();
    for (from, to, told) in [
        ("\"knobs\": {", "\"knobs\": { \"glimmer\": 3,", "found the knob \"glimmer\"; expected a knob that Ramp has"),
        ("\"trochoid_preset\": 1", "\"trochoid_preset\": 2", "found 2; expected \"trochoid_preset\": 1"),
        ("\"type\": \"Ramp\"", "\"type\": \"Mix\"", "found the type \"Mix\"; expected \"Ramp\""),
        ("\"#f0cf8e\"", "\"yellow\"", "The preset “evening” does not fit"),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        std::fs::write(&file, changed).unwrap();
        select(&mut window, &["sky"]);
        act(&mut window, Action::Preset("evening".into()));
        let notices = editor(&window).notices.texts();
        assert!(notices.iter().any(|text| text.contains(told)), "{told}: {notices:?}");
        assert_eq!(editor(&window).state().session.text(), DUSK);
    }
}

#[test]
fn presets_stand_in_the_menu_of_the_node() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    keep(&mut window);
    window.get_by_label("Close notice").click();
    select(&mut window, &[]);
    act(&mut window, Action::Frames);
    let menu = |window: &mut Window| {
        let at = window.get_by_label("Node sky, Ramp").rect().left_top() + egui::vec2(14.0, 8.0);
        assert!(graph(window).contains(at));
        window.hover_at(at);
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
            window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
            window.step();
        }
        window.run_steps(3);
        window.get_by_label_contains("Presets").click();
        window.run_steps(4);
    };
    menu(&mut window);
    window.get_by_label("evening");
    window.get_by_label("Save as preset …");
    act(&mut window, Action::ForgetPreset("Ramp".into(), "evening".into()));
    assert!(!preset(folder.path()).exists());
    menu(&mut window);
    assert!(window.query_by_label("evening").is_none());
}

#[test]
fn names_that_no_file_can_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    select(&mut window, &["sky"]);
    act(&mut window, Action::NamePreset);
    name(&mut window, "Name of the preset", "../evening");
    window.get_by_label_contains("expected a name without");
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert!(!folder.path().join("presets").exists());
}

#[test]
fn a_value_that_follows_other_nodes_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = DUSK.replace(r#""at": 1, "#, r#""at": "= dusk.weight + 0.75", "#);
    assert_ne!(text, DUSK);
    let mut window = window(Session::new(text, None), Some(folder.path().to_path_buf()));
    keep(&mut window);
    assert!(editor(&window).notices.texts().iter().any(|text| text.contains("because they follow other nodes: stops")));
    let text = trochoid::io::read_text(preset(folder.path()), 1 << 20).unwrap();
    assert!(!text.contains("stops"));
}

#[test]
fn layouts_are_chosen_kept_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    for layout in Layout::ALL {
        act(&mut window, Action::Layout(layout));
        let tree = &editor(&window).tree;
        let kept = layout::written(tree, (egui::ThemePreference::Dark, 1.0));
        assert!(layout::read(&kept).is_some_and(|(read, _)| read == *tree), "{} has every panel", layout.name());
    }
    act(&mut window, Action::Layout(Layout::Painting));
    assert!(window.query_by_label("0 colors with names, 3 without").is_some(), "the palette is in front");
    act(&mut window, Action::Panel(Pane::Report));
    let own = editor(&window).tree.clone();
    act(&mut window, Action::NameLayout);
    name(&mut window, "Name of the layout", "mine");
    ask(&mut window, Action::Layout(Layout::First));
    assert!(editor(&window).tree == layout::first());
    drop(window);
    // It is there the next time.
    let mut window = open(folder.path());
    ask(&mut window, Action::OwnLayout("mine".into()));
    assert!(editor(&window).tree == own);
    act(&mut window, Action::ForgetLayout("mine".into()));
    act(&mut window, Action::OwnLayout("mine".into()));
    assert!(editor(&window).notices.texts().iter().any(|text| text.contains("“mine”")));
    assert!(open(folder.path()).state().as_ref().unwrap().layouts.names().is_empty());
}

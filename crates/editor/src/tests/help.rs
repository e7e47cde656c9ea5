//! The help: pages, links, search, and adding nodes from there.

use super::dusk;
use crate::actions::{Action, HelpPage, Pane};
use crate::testing::{Window, act, editor, unseen};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;

fn open() -> Window {
    unseen(dusk())
}

fn shows(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

fn select(window: &mut Window, name: &str) {
    act(window, Action::Select([name.to_string()].into()));
}

#[test]
fn f1_explains_the_selected_node() {
    let mut window = open();
    select(&mut window, "sky");
    window.key_press(Key::F1);
    window.run_steps(4);
    let known = trochoid::registry().get("Ramp").unwrap().declaration();
    assert!(shows(&window, "Formula") && shows(&window, "Edge cases") && shows(&window, "Ports"));
    assert!(shows(&window, &known.source.replace('`', "")));
    // Ports, knobs and their ranges.
    for item in known.items {
        assert!(shows(&window, &format!("{}: ", item.name())), "{}", item.name());
    }
    // Without a node, all pages are listed.
    act(&mut window, Action::Select(Default::default()));
    window.key_press(Key::F1);
    window.run_steps(4);
    window.get_by_label("Getting started");
}

#[test]
fn links_between_pages_are_followed_and_there_is_a_way_back() {
    let mut window = open();
    act(&mut window, Action::Help(HelpPage::Contents));
    window.get_by_label("Mix").click();
    window.run_steps(4);
    assert!(shows(&window, "Mixes two colors by a mask"));
    act(&mut window, Action::Help(HelpPage::Chapter("editor".into())));
    window.get_all_by_label("group").next().unwrap().click_accesskit();
    window.run_steps(6);
    assert!(shows(&window, "What is used several times is written once"), "the chapter on documents, at its heading");
    window.get_by_label("Back").click();
    window.run_steps(4);
    assert!(shows(&window, "The editor shows and changes the same documents"));
    window.get_by_label("Forward").click();
    window.run_steps(4);
    assert!(shows(&window, "What is used several times is written once"));
}

#[test]
fn all_pages_are_searched() {
    let mut window = open();
    act(&mut window, Action::Help(HelpPage::Contents));
    window.get_by_label("Search the help").focus();
    window.run_steps(2);
    window.event(Event::Text("lambert cosine".into()));
    window.run_steps(4);
    window.get_by_label("NonSpecular").click();
    window.run_steps(4);
    assert!(shows(&window, "A mask of diffuse light on the surface"));
}

#[test]
fn a_node_is_added_from_its_page_and_connected() {
    let mut window = open();
    select(&mut window, "sky");
    act(&mut window, Action::Help(HelpPage::Node("Blur".into())));
    window.get_by_label("Add").click();
    window.run_steps(6);
    let state = editor(&window).state();
    assert_eq!(state.chosen(), Some("blur"));
    let sheet = state.sheet();
    let (sky, blur) = (sheet.find("sky").unwrap(), sheet.find("blur").unwrap());
    assert!(sheet.wires.iter().any(|wire| wire.from.0 == sky && wire.to.0 == blur), "it takes the selected node");
}

#[test]
fn the_keys_are_shown_by_a_question_mark() {
    let mut window = open();
    window.key_press_modifiers(Modifiers::SHIFT, Key::Questionmark);
    window.run_steps(4);
    window.get_all_by_label("Keys and commands").next().unwrap();
    assert!(shows(&window, "Show all keys and commands."));
    // Not while a text is typed.
    act(&mut window, Action::Panel(Pane::Help));
    act(&mut window, Action::Help(HelpPage::Contents));
    window.get_by_label("Search the help").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::SHIFT, Key::Questionmark);
    window.run_steps(4);
    assert!(window.query_all_by_label("Show all keys and commands.").next().is_none());
}

#[test]
fn the_search_for_types_explains_them() {
    let mut window = open();
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.event(Event::Text("lightpool".into()));
    window.run_steps(3);
    window.key_press(Key::F1);
    window.run_steps(5);
    assert!(shows(&window, "A mask of pools of light in world space"));
    window.get_by_label("Add");
    // The search goes on, also for groups of the library.
    window.key_press(Key::Backspace);
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    window.event(Event::Text("rowing".into()));
    window.run_steps(3);
    window.key_press(Key::F1);
    window.run_steps(5);
    assert!(!shows(&window, "No node type and no group"));
    window.get_by_label("Node type");
    assert!(shows(&window, "RowingBoatPaint"));
}

//! Tests of the search in the document.

use crate::actions::{Action, Pane};
use crate::document::Session;
use crate::document::swatches::SwatchKey;
use crate::testing::{Window, act, editor, graph, unseen};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;

/// A document with nodes far from each other, whose knobs fill more than the panel.
const STORM: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 }, "working_space": "srgb",
  "notes": "Painted after a print.",
  "palette": { "deep_water": "#14262e" },
  "nodes": {
    "down": { "type": "ScreenY", "notes": "0 at the horizon" },
    "grain": { "type": "Noise", "octaves": 6 },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.125, "color": "#2d3f52" }, { "at": 0.25, "color": "#2d3f52" },
      { "at": 0.375, "color": "#2d3f52" }, { "at": 0.5, "color": "#2d3f52" }, { "at": 0.625, "color": "#2d3f52" },
      { "at": 0.75, "color": "#2d3f52" }, { "at": 0.9375, "color": "#4d5f72" } ] },
    "dusk": { "type": "Mix", "a": "sky", "b": "palette.deep_water", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "dusk", "file": "stills/beauty.png" } },
  "ui": { "positions": { "down": [0, 0], "grain": [4000, 3000], "sky": [0, 200], "dusk": [0, 400] },
    "backdrops": { "b1": { "at": [-3000, 0], "size": [200, 90], "text": "Far away\nThe last boats", "tint": 0 } } }
}"##;

fn open() -> Window {
    unseen(Session::new(STORM.into(), None))
}

/// Opens the search by its keys, and types a text.
fn find(window: &mut Window, text: &str) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::F);
    window.run_steps(3);
    window.get_by_label("Find");
    window.event(Event::Text(text.into()));
    window.run_steps(3);
}

/// Goes to the first thing that a text finds.
fn go(window: &mut Window, text: &str) {
    find(window, text);
    window.key_press(Key::Enter);
    window.run_steps(12);
    assert!(window.query_by_label("Find").is_none(), "the search is closed");
}

fn is_unchanged(window: &Window) -> bool {
    editor(window).state().session.text() == STORM && editor(window).state().session.history().undoes().is_none()
}

#[test]
fn a_node_is_found_selected_and_brought_into_view() {
    let mut window = open();
    act(&mut window, Action::Panel(Pane::Report));
    assert!(window.query_by_label("Node grain, Noise").is_none(), "it is far away");
    go(&mut window, "noise");
    assert_eq!(editor(&window).state().chosen(), Some("grain"));
    let graph = graph(&window);
    let node = window.get_by_label("Node grain, Noise").rect();
    assert!((node.center() - graph.center()).length() < 2.0, "{node:?} in {graph:?}");
    assert!(window.query_all_by_label("octaves").next().is_some(), "its properties are shown");
    assert!(is_unchanged(&window));
}

#[test]
fn a_knob_is_found_by_its_value_and_comes_into_view() {
    let mut window = open();
    act(&mut window, Action::Select(["sky".to_string()].into()));
    let panel = window.ctx.content_rect();
    let shown = |window: &Window| {
        let fields: Vec<egui::Rect> = window
            .query_all_by_role(egui::accesskit::Role::SpinButton)
            .filter(|node| {
                use egui_kittest::kittest::NodeT;
                node.accesskit_node().numeric_value() == Some(0.9375)
            })
            .map(|node| node.rect())
            .collect();
        fields.first().is_some_and(|field| panel.contains_rect(*field) && field.bottom() < panel.bottom() - 60.0)
    };
    assert!(!shown(&window), "a list of more than six is closed");
    go(&mut window, "0.9375");
    window.run_steps(20);
    assert!(shown(&window));
    assert!(is_unchanged(&window));
}

#[test]
fn a_color_is_found_by_its_hex_and_shown_in_the_palette() {
    let mut window = open();
    go(&mut window, "14262e");
    assert_eq!(editor(&window).state().colors.chosen, Some(SwatchKey::Named("deep_water".into())));
    window.get_by_label_contains("1 color with names");
    go(&mut window, "#4d5f72");
    let key = SwatchKey::Literal("sky.stops[7].color".into());
    assert_eq!(editor(&window).state().colors.chosen, Some(key));
    assert!(is_unchanged(&window));
}

#[test]
fn texts_of_nodes_outputs_backdrops_and_the_document_are_found() {
    let mut window = open();
    go(&mut window, "horizon");
    assert_eq!(editor(&window).state().chosen(), Some("down"));
    go(&mut window, "print");
    assert!(editor(&window).state().selection.is_empty());
    window.get_by_label("Document");
    go(&mut window, "stills");
    assert_eq!(editor(&window).state().output.as_deref(), Some("beauty"));
    go(&mut window, "boats");
    let graph = graph(&window);
    let note = window.get_by_label("Backdrop Far away").rect();
    assert!((note.center().x - graph.center().x).abs() < 2.0, "{note:?} in {graph:?}");
    assert!(is_unchanged(&window));
}

#[test]
fn the_list_is_used_by_arrows_by_clicks_and_left_by_esc() {
    let mut window = open();
    find(&mut window, "deep sea");
    window.get_by_label("Nothing matches. Nodes are found by name or type, knobs by name or value, colors by name or #rrggbb, notes by their text.");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Find").is_none());
    // Without a text, all is listed, nodes first.
    find(&mut window, "");
    for _ in 0..2 {
        window.key_press(Key::ArrowDown);
        window.run_steps(2);
    }
    window.key_press(Key::Enter);
    window.run_steps(6);
    assert_eq!(editor(&window).state().chosen(), Some("sky"));
    find(&mut window, "octaves");
    window.get_by_label("1 found. Enter goes to the marked one.");
    window.get_by_label("Knob grain.octaves, 6").click();
    window.run_steps(6);
    assert_eq!(editor(&window).state().chosen(), Some("grain"));
    assert!(is_unchanged(&window));
}

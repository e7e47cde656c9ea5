//! Tests of what the window reports: notices, prompts, and faults that appear only in evaluation.

use super::DUSK;
use crate::actions::Action;
use crate::document::{Path, Session};
use crate::testing::{Window, act, editor, finished, unseen, window};
use egui::{Event, Modifiers, PointerButton, pos2};
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn texts(window: &Window) -> Vec<&str> {
    editor(window).notices.texts()
}

/// Writes a picture of this size, and a document of 48 × 27 pixels that reads it without a fit.
fn reading(folder: &std::path::Path, [width, height]: [u32; 2]) -> std::path::PathBuf {
    image::RgbImage::from_pixel(width, height, image::Rgb([9; 3])).save(folder.join("plate.png")).unwrap();
    let read = "{ \"type\": \"Read\", \"as\": \"color\", \"file\": \"plate.png\" }";
    let text = DUSK.replace("{ \"type\": \"ScreenY\" }", read);
    let text =
        text.replace("\"weight\": \"down\", ", "\"weight\": 0.5, ").replace("\"b\": \"#14262e\"", "\"b\": \"down\"");
    let file = folder.join("dusk.json");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn an_error_is_closed_by_hand_or_goes_with_its_document() {
    let mut window = unseen(super::dusk());
    for _ in 0..2 {
        act(&mut window, Action::OpenFile("/nowhere/dusk.json".into()));
    }
    assert_eq!(texts(&window).len(), 1, "shown once, however often it is reported");
    window.run_steps(1000);
    assert_eq!(texts(&window).len(), 1, "an error stays until it is closed");
    window.get_by_label("Close notice").click();
    window.run_steps(3);
    assert!(texts(&window).is_empty());
    act(&mut window, Action::OpenFile("/nowhere/dusk.json".into()));
    act(&mut window, Action::New);
    assert!(texts(&window).is_empty());
    // A notice that is no error disappears by itself.
    act(&mut window, Action::Notice("a word".into()));
    assert_eq!(texts(&window), ["a word"]);
    window.run_steps(500);
    assert!(texts(&window).is_empty());
}

#[test]
fn a_notice_takes_no_clicks_beside_itself() {
    let mut window = unseen(super::dusk());
    act(&mut window, Action::Notice("a word".into()));
    let (word, close) = (window.get_by_label("a word").rect(), window.get_by_label("Close notice").rect());
    let own = |at: egui::Pos2| window.ctx.layer_id_at(at).unwrap().order == egui::Order::Middle;
    assert!(own(word.center()) && own(close.center()));
    assert!(!own(pos2(close.right() + 40.0, close.center().y)) && !own(word.center_top() - egui::vec2(0.0, 40.0)));
}

#[test]
fn the_buttons_for_unsaved_work_do_not_depend_on_the_length_of_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut places = Vec::new();
    for name in ["a.json".to_string(), format!("{}.json", "long".repeat(40))] {
        let file = folder.path().join(name);
        std::fs::write(&file, DUSK).unwrap();
        let mut window = unseen(Session::open(&file).unwrap());
        act(&mut window, Action::Edit(crate::document::edit::moved(&[("sky".into(), [7.0, 0.0])])));
        act(&mut window, Action::Quit);
        window.run_steps(3);
        places.push(["Save", "Discard", "Cancel"].map(|word| window.get_by_label(word).rect()));
    }
    assert_eq!(places[0], places[1]);
    assert!(places[0][0].right() < places[0][1].left() && places[0][1].right() < places[0][2].left());
}

#[test]
fn a_picture_of_the_size_of_the_document_is_seen_at_every_size() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Session::open(&reading(folder.path(), [48, 27])).unwrap(), None);
    for proxy in [1, 2, 4] {
        act(&mut window, Action::Proxy(proxy));
        finished(&mut window);
        let seen = &editor(&window).state().evaluated;
        assert_eq!(seen.failed, None);
        assert_eq!(seen.result.as_ref().unwrap().shrunk, proxy);
    }
}

#[test]
fn errors_of_evaluation_are_counted_and_marked_and_name_the_size_of_the_document() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Session::open(&reading(folder.path(), [20, 10])).unwrap(), None);
    finished(&mut window);
    window.run_steps(3);
    let failed = editor(&window).state().evaluated.failed.clone().unwrap();
    assert!(failed.contains("20 × 10 pixels, expected 48 × 27"), "{failed}");
    window.get_by_label("Error in down");
    window.get_by_label("Error above dusk");
    window.get_by_label("1 error").click();
    window.run_steps(3);
    assert!(editor(&window).state().selection.contains("down"));
    // All of that disappears once the fault is fixed.
    act(&mut window, Action::Edit(crate::document::Edit::set(Path::node("down").to("fit"), &json!("nearest"))));
    finished(&mut window);
    window.run_steps(3);
    window.get_by_label("No errors");
    assert!(window.query_by_label("Error in down").is_none());
}

#[test]
fn a_node_that_is_no_picture_is_no_error() {
    let text = DUSK.replace("\"down\": {", "\"eye\": { \"type\": \"Camera\", \"position\": [1, 2, 3] }, \"down\": {");
    let mut window = window(Session::new(text, None), None);
    act(&mut window, Action::Look("eye".into(), 0));
    finished(&mut window);
    window.run_steps(3);
    assert!(editor(&window).state().evaluated.failed.is_some());
    window.get_by_label("No errors");
}

#[test]
fn a_key_of_a_curve_is_taken_by_the_press_and_follows_to_the_end() {
    let text = DUSK.replace("\"weight\": 0.25", "\"weight\": { \"keys\": [[1, 0.2], [4, 0.8], [8, 0.4]] }");
    let mut window = unseen(Session::new(text, None));
    act(&mut window, Action::Select(["dusk".to_string()].into()));
    window.get_by_label("Curve").click();
    window.run_steps(4);
    let plot = window.get_by_label("Keys over frames").rect();
    // The plot shows all keys with a margin of 5 % on each side.
    let at = |frame: f32, value: f32| {
        let [x, y] = [(frame - 1.0 + 0.35) / 7.7, (0.8 - value + 0.03) / 0.66];
        plot.min + egui::vec2(x, y) * plot.size()
    };
    let button = |window: &mut Window, pos: egui::Pos2, pressed: bool| {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        window.event(Event::PointerButton { pos, button, pressed, modifiers });
        window.step();
    };
    let key = |window: &Window| editor(window).state().sheet().value["nodes"]["dusk"]["weight"]["keys"][1].clone();
    let near = |key: &serde_json::Value, frame: f64, value: f64| {
        key[0].as_f64() == Some(frame) && (key[1].as_f64().unwrap() - value).abs() < 0.02
    };
    window.hover_at(at(4.0, 0.8));
    window.step();
    button(&mut window, at(4.0, 0.8), true);
    // The first move already leaves the area in which a press hits the key.
    window.event(Event::PointerMoved(at(6.0, 0.5)));
    window.run_steps(2);
    assert!(near(&key(&window), 6.0, 0.5), "{}", key(&window));
    // The last move arrives in the same frame as the release.
    window.event(Event::PointerMoved(at(5.0, 0.7)));
    button(&mut window, at(5.0, 0.7), false);
    window.run_steps(4);
    assert!(near(&key(&window), 5.0, 0.7), "{}", key(&window));
    act(&mut window, Action::Undo);
    assert!(near(&key(&window), 4.0, 0.8), "undone in one step");
}

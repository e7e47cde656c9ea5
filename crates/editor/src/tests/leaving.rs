//! Tests of leaving a document while text is typed, a tool is armed, rendering runs, or the file changes on disk.

use super::{DUSK, dusk};
use crate::actions::{Action, Pane};
use crate::document::{Edit, Path, Session};
use crate::testing::{Window, act, ask, editor, finished, unseen_in, until, window};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn select(window: &mut Window, node: &str) {
    act(window, Action::Select([node.to_string()].into()));
}

fn press(window: &mut Window, pos: Pos2, pressed: bool) {
    window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE });
}

fn click(window: &mut Window, pos: Pos2) {
    window.hover_at(pos);
    press(window, pos, true);
    press(window, pos, false);
    window.run_steps(4);
}

/// Opens a wide window in which the weight of `dusk` is being typed.
fn typing(text: &str) -> Window {
    let mut window = unseen_in(dusk(), [1280.0, 1200.0]);
    select(&mut window, "dusk");
    let field = super::typing::fields(&window, "weight")[0];
    click(&mut window, field.center());
    window.event(Event::Text(text.into()));
    window.run_steps(2);
    window
}

/// Returns the middle of a node on the canvas.
fn place(window: &Window, node: &str) -> Pos2 {
    let editor = editor(window);
    let sheet = editor.state().sheet();
    window.get_by_label(&format!("Node {node}, {}", sheet.node(node).unwrap().ty)).rect().center()
}

fn weight(window: &Window) -> serde_json::Value {
    editor(window).state().sheet().get(&Path::node("dusk").to("weight")).cloned().unwrap()
}

fn chosen(window: &Window) -> Option<&str> {
    editor(window).state().chosen()
}

#[test]
fn what_is_typed_counts_when_another_node_is_clicked_or_dragged() {
    let mut window = typing("0.5");
    let sky = place(&window, "sky");
    click(&mut window, sky);
    assert_eq!((weight(&window), chosen(&window)), (json!(0.5), Some("sky")));
    let mut window = typing("0.75");
    let sky = place(&window, "sky");
    window.hover_at(sky);
    press(&mut window, sky, true);
    window.step();
    for step in 1..4 {
        window.event(Event::PointerMoved(sky + egui::vec2(10.0 * step as f32, 0.0)));
        window.step();
    }
    press(&mut window, sky + egui::vec2(30.0, 0.0), false);
    window.run_steps(4);
    assert_eq!((weight(&window), chosen(&window)), (json!(0.75), Some("sky")));
}

#[test]
fn a_click_elsewhere_first_shows_why_a_value_was_refused() {
    let mut window = typing("7");
    let sky = place(&window, "sky");
    click(&mut window, sky);
    window.get_by_label_contains("found \"7\"; expected a number from 0 to 1");
    assert_eq!((weight(&window), chosen(&window)), (json!(0.25), Some("dusk")));
    // The second click leaves the field.
    click(&mut window, sky);
    assert_eq!(chosen(&window), Some("sky"));
}

#[test]
fn esc_restores_a_text_that_is_applied_at_each_key() {
    let mut window = unseen_in(dusk(), [1280.0, 1200.0]);
    act(&mut window, Action::Output(Some("beauty".into())));
    let field = window.query_all_by_value("dusk.####.png").next().unwrap().rect();
    click(&mut window, field.center());
    window.event(Event::Text("x".into()));
    window.run_steps(2);
    assert_ne!(editor(&window).state().session.text(), DUSK);
    window.key_press(Key::Escape);
    window.run_steps(4);
    assert_eq!(editor(&window).state().session.text(), DUSK);
    assert!(!editor(&window).state().session.is_changed());
    assert_eq!(editor(&window).state().session.history().undoes(), None, "there is nothing to undo");
}

#[test]
fn the_dropper_ends_when_its_field_is_left() {
    let mut window = unseen_in(dusk(), [1280.0, 1200.0]);
    let take = || Action::Dropper(Some(Path::node("dusk").to("b")));
    let ways: [&dyn Fn(&mut Window); 3] =
        [&|window| select(window, "sky"), &|window| act(window, Action::Output(Some("beauty".into()))), &|window| {
            window.key_press(Key::Escape);
            window.run_steps(2);
        }];
    for (index, way) in ways.into_iter().enumerate() {
        select(&mut window, "dusk");
        act(&mut window, take());
        assert!(editor(&window).state().dropper.is_some());
        way(&mut window);
        assert!(editor(&window).state().dropper.is_none(), "way {index}");
    }
}

#[test]
fn a_document_without_a_file_must_be_saved_before_it_is_rendered() {
    let mut window = unseen_in(dusk(), [1280.0, 800.0]);
    act(&mut window, Action::Render);
    assert!(editor(&window).state().render.is_none() && editor(&window).prompts.is_open());
    assert!(editor(&window).notices.texts()[0].starts_with("Save the document first"));
}

#[test]
fn a_run_is_not_ended_by_closing_the_window_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK.replace("\"last\": 8", "\"last\": 50000")).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Render);
    assert_eq!(editor(&window).notices.texts(), Vec::<&str>::new());
    act(&mut window, Action::Quit);
    window.get_by_label("Keep rendering").click();
    window.run_steps(3);
    assert!(!editor(&window).is_closing() && editor(&window).state().render.is_some());
    act(&mut window, Action::Quit);
    // A run that ends by itself closes the question, and the window stays open.
    window.state_mut().as_mut().unwrap().end_render();
    window.run_steps(3);
    assert!(!editor(&window).is_closing() && !editor(&window).prompts.is_open());
    act(&mut window, Action::Render);
    act(&mut window, Action::Quit);
    // The timeline has a button of this name, too.
    window.get_all_by_label("Stop").last().unwrap().click();
    window.run_steps(3);
    assert!(editor(&window).is_closing());
}

#[test]
fn saving_asks_where_another_program_has_changed_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Edit(crate::document::edit::moved(&[("sky".into(), [7.0, 0.0])])));
    let theirs = DUSK.replace("0.25", "0.75");
    std::fs::write(&file, &theirs).unwrap();
    // Save before the file watcher reports the change.
    ask(&mut window, Action::Save);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), theirs);
    window.run_steps(3);
    window.get_by_label("Overwrite").click();
    window.run_steps(3);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), editor(&window).state().session.text());
}

/// Writes a copy of unsaved work on a file, as a killed editor leaves it.
fn copy(data: &std::path::Path, file: &std::path::Path, text: &str) {
    let unsaved = data.join("unsaved");
    std::fs::create_dir_all(&unsaved).unwrap();
    std::fs::write(unsaved.join("1-0.json"), json!({ "file": file, "text": text }).to_string()).unwrap();
}

#[test]
fn recovered_work_is_not_written_over_a_newer_file_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let (data, file) = (folder.path().join("data"), folder.path().join("dusk.json"));
    copy(&data, &file, &DUSK.replace("0.25", "0.5"));
    std::fs::write(&file, DUSK).unwrap();
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    std::fs::File::options().write(true).open(&file).unwrap().set_modified(later).unwrap();
    let mut window = window(Session::open(&file).unwrap(), Some(data));
    window.get_by_label("the file is newer");
    window.get_by_label("Recover").click();
    window.run_steps(3);
    act(&mut window, Action::Save);
    window.get_by_label("The file has changed");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), DUSK);
}

#[test]
fn work_of_a_document_that_is_gone_is_offered_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (data, file) = (folder.path().join("data"), folder.path().join("gone.json"));
    copy(&data, &file, DUSK);
    let mut window = window(Session::new(crate::document::session::NEW.into(), None), Some(data));
    window.get_by_label("Later").click();
    window.run_steps(3);
    act(&mut window, Action::OpenFile(file.clone()));
    window.get_by_label("Recover").click();
    window.run_steps(3);
    let session = &editor(&window).state().session;
    assert_eq!((session.text(), session.file()), (DUSK, Some(file.as_path())));
}

#[test]
fn a_document_repaired_after_opening_is_shown_from_its_first_frame() {
    let mut window = window(Session::new(DUSK.replace("\"nodes\"", "nodes"), None), None);
    window.run_steps(3);
    assert!(editor(&window).state().evaluated.failed.is_some());
    act(&mut window, Action::Rewrite(DUSK.into()));
    finished(&mut window);
    let state = editor(&window).state();
    assert_eq!((state.evaluated.failed.as_deref(), state.frame, state.range), (None, 1, (1, 8)));
    assert_eq!(state.look.node, Some(("dusk".into(), 0)));
}

#[test]
fn an_edit_of_a_value_that_was_just_typed_in_the_text_is_not_made() {
    let mut window = window(dusk(), None);
    act(&mut window, Action::Panel(Pane::Text));
    window.get_by_role(Role::MultilineTextInput).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    let typed = DUSK.replace("\"weight\": 0.25", "\"weight\": 0.5");
    window.event(Event::Paste(typed.clone()));
    window.run_steps(2);
    act(&mut window, Action::Edit(Edit::set(Path::node("dusk").to("weight"), &json!(0.1))));
    assert_eq!(editor(&window).state().session.text(), typed);
    assert!(editor(&window).notices.texts().iter().any(|text| text.contains("repeat your edit")));
    until(&mut window, "nothing typed", |editor| editor.panels.text.pending().is_none());
}

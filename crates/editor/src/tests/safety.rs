//! Tests that no work is lost and no saved work is offered for recovery: backups of editors that end unexpectedly, and
//! text that is typed but not applied.

use super::DUSK;
use crate::actions::{Action, Pane};
use crate::document::{Edit, Session, edit};
use crate::testing::{Window, act, editor, finished, until, window};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use serde_json::json;
use std::path::{Path, PathBuf};

/// An editor with a document on disk, and a folder for copies of unsaved work.
struct Desk {
    folder: tempfile::TempDir,
    file: PathBuf,
    window: Window,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("dusk.json");
        std::fs::write(&file, DUSK).unwrap();
        let window = window(Session::open(&file).unwrap(), Some(folder.path().join("data")));
        Self { folder, file, window }
    }

    fn act(&mut self, action: Action) {
        act(&mut self.window, action);
    }

    fn saves(&mut self) {
        self.window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        self.window.run_steps(5);
    }

    fn stored(&self) -> String {
        std::fs::read_to_string(&self.file).unwrap()
    }

    /// Waits until the only copy has this text, or until there is none.
    fn keeps(&mut self, what: &str, text: Option<&str>) {
        let folder = self.folder.path().join("data/unsaved");
        until(&mut self.window, what, |_| kept(&folder).as_deref() == text);
    }

    fn dot(&self) -> bool {
        editor(&self.window).title().starts_with('•')
    }

    /// Replaces the whole text in the text panel.
    fn types(&mut self, text: &str) {
        self.act(Action::Panel(Pane::Text));
        self.window.get_by_role(Role::MultilineTextInput).focus();
        self.window.run_steps(2);
        self.window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.window.run_steps(2);
        self.window.event(Event::Paste(text.into()));
        self.window.run_steps(2);
    }
}

/// Returns the text of the only copy.
fn kept(folder: &Path) -> Option<String> {
    let paths = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let copy = paths.into_iter().find(|path| path.extension().is_some_and(|end| end == "json"))?;
    let value: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(copy).ok()?).ok()?;
    value["text"].as_str().map(String::from)
}

fn moved() -> Action {
    Action::Edit(edit::moved(&[("sky".into(), [7.0, 0.0])]))
}

#[test]
fn text_that_equals_its_file_has_no_copy() {
    let mut desk = Desk::new();
    desk.act(moved());
    let text = editor(&desk.window).state().session.text().to_string();
    desk.keeps("the copy", Some(&text));
    desk.saves();
    assert!(!desk.dot() && desk.stored() == text);
    desk.keeps("the copy to go", None);
    // After undo, the text differs from the file; after redo, it is the saved text again.
    desk.act(Action::Undo);
    desk.keeps("the copy of what was before", Some(DUSK));
    desk.act(Action::Redo);
    desk.keeps("that copy to go", None);
    // Opening another document removes the copy of the one before.
    desk.act(Action::Undo);
    desk.keeps("the copy again", Some(DUSK));
    desk.act(Action::New);
    desk.window.get_by_label("Discard").click();
    desk.window.run_steps(3);
    desk.keeps("all copies to go", None);
}

#[test]
fn a_copy_that_equals_its_file_is_not_offered() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let unsaved = folder.path().join("data/unsaved");
    std::fs::create_dir_all(&unsaved).unwrap();
    let copy = unsaved.join("1-0.json");
    std::fs::write(&copy, serde_json::json!({ "file": file, "text": DUSK }).to_string()).unwrap();
    let window = window(Session::open(&file).unwrap(), Some(folder.path().join("data")));
    assert!(window.query_by_label("Recover unsaved work?").is_none());
    assert!(!copy.exists());
}

#[test]
fn a_version_kept_over_a_changed_file_is_unsaved_until_it_is_saved() {
    let mut desk = Desk::new();
    std::fs::write(&desk.file, DUSK.replace("0.25", "0.75")).unwrap();
    until(&mut desk.window, "the question", |editor| editor.prompts.is_open());
    desk.window.run_steps(2);
    desk.window.get_by_label("Keep my version").click();
    desk.window.run_steps(3);
    assert!(desk.dot());
    desk.keeps("the copy", Some(DUSK));
    desk.saves();
    assert_eq!(desk.stored(), DUSK);
    desk.keeps("the copy to go", None);
}

#[test]
fn text_that_is_not_applied_is_unsaved_work() {
    let mut desk = Desk::new();
    let typed = DUSK.replace("0.25", "0.75");
    desk.types(&typed);
    assert!(desk.dot());
    assert_eq!(editor(&desk.window).state().session.text(), DUSK);
    desk.keeps("the copy", Some(&typed));
    for action in [Action::Quit, Action::New, Action::OpenFile(desk.file.clone())] {
        desk.act(action);
        desk.window.get_by_label("Save changes?");
        desk.window.get_by_label("Cancel").click();
        desk.window.run_steps(3);
    }
    assert_eq!(editor(&desk.window).panels.text.pending(), Some(typed.as_str()));
    desk.saves();
    assert_eq!(desk.stored(), typed);
    assert!(!desk.dot() && editor(&desk.window).panels.text.pending().is_none());
    desk.keeps("the copy to go", None);
    desk.act(Action::Undo);
    assert_eq!(editor(&desk.window).state().session.text(), DUSK);
}

#[test]
fn text_that_is_no_json_is_not_saved_in_silence() {
    let mut desk = Desk::new();
    desk.types("{ \"trochoid\": 1, ");
    desk.saves();
    assert_eq!(desk.stored(), DUSK);
    assert!(desk.dot());
    assert_eq!(editor(&desk.window).notices.texts().len(), 1);
    // Other actions do not change the document either.
    desk.act(moved());
    desk.act(Action::SaveAs);
    assert!(!editor(&desk.window).prompts.is_open());
    assert_eq!(editor(&desk.window).state().session.text(), DUSK);
    assert_eq!(editor(&desk.window).panels.text.pending(), Some("{ \"trochoid\": 1, "));
}

#[test]
fn text_that_is_not_applied_yet_is_applied_by_the_next_change() {
    let mut desk = Desk::new();
    desk.types(&DUSK.replace("0.25", "0.75"));
    desk.act(moved());
    let text = editor(&desk.window).state().session.text();
    assert!(text.contains("0.75") && text.contains("\"sky\": [7, 0]"), "{text}");
    desk.act(Action::Undo);
    desk.act(Action::Undo);
    assert_eq!(editor(&desk.window).state().session.text(), DUSK);
}

/// A fault of the program costs one picture, and no work.
#[test]
fn a_panic_is_told_and_the_next_picture_is_made() {
    let mut desk = Desk::new();
    finished(&mut desk.window);
    editor(&desk.window).worker.break_once();
    let weight =
        |weight: f64| Action::Edit(Edit::set(crate::document::Path::node("dusk").to("weight"), &json!(weight)));
    desk.act(weight(0.75));
    finished(&mut desk.window);
    let seen = &editor(&desk.window).state().evaluated;
    let failed = seen.failed.as_deref().unwrap();
    assert!(failed.contains("a fault of Trochoid itself, not of the document: broken for a test"), "{failed}");
    assert!(seen.last.is_some(), "the picture before stays");
    desk.act(weight(0.5));
    finished(&mut desk.window);
    let seen = &editor(&desk.window).state().evaluated;
    assert!(seen.failed.is_none() && seen.result.as_ref().is_some_and(|result| result.finished));
}

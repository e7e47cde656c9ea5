use super::DUSK;
use crate::actions::{Action, Pane};
use crate::document::{Path, Session, VersionStatus};
use crate::testing::{Window, act, editor, finished, window};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn set(value: f64) -> Action {
    Action::Edit(crate::document::Edit::set(Path::node("dusk").to("weight"), &json!(value)))
}

/// Returns a document of a future version, with an unknown node type and an unknown entry.
fn newer() -> String {
    let text = DUSK.replace("\"trochoid\": 1", "\"trochoid\": 2, \"look\": { \"film\": 3 }");
    text.replace("\"down\": {", "\"haze\": { \"type\": \"Haze\", \"thick\": [1, 2] },\n    \"down\": {")
}

fn save(window: &mut Window) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
}

#[test]
fn a_newer_document_is_shown_and_never_written_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("newer.json");
    std::fs::write(&file, newer()).unwrap();
    let on_disk = || std::fs::read_to_string(&file).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    finished(&mut window);
    window.get_by_label_contains("uses format version 2; this editor supports version 1");
    for name in ["Node haze, Haze", "Node sky, Ramp", "Node dusk, Mix"] {
        window.get_by_label(name);
    }
    assert!(window.query_by_label("Set the format version").is_none(), "setting the version would not help");
    save(&mut window);
    assert_eq!(on_disk(), newer(), "nothing was changed");
    act(&mut window, set(0.5));
    save(&mut window);
    window.get_by_label("Overwrite a newer document?");
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert_eq!(on_disk(), newer());
    assert!(editor(&window).state().session.is_changed());
    act(&mut window, Action::Quit);
    window.get_by_label("Save").click();
    window.run_steps(3);
    window.get_by_label("Overwrite a newer document?");
    assert!(!editor(&window).is_closing());
    assert_eq!(on_disk(), newer());
    window.get_by_label("Overwrite").click();
    window.run_steps(3);
    assert!(editor(&window).is_closing());
    assert_eq!(on_disk(), newer().replace("0.25", "0.5"), "unknown entries stay as they were");
}

#[test]
fn a_newer_document_says_what_was_found_in_which_field() {
    let mut window = window(Session::new(newer(), None), None);
    finished(&mut window);
    let failed = editor(&window).state().evaluated.failed.clone().unwrap();
    assert!(failed.contains("found 2, a newer version of the document format"), "{failed}");
    act(&mut window, Action::Panel(Pane::Text));
    window.get_by_label_contains("2:15: trochoid: found 2, a newer version of the document format; expected 1");
}

#[test]
fn a_document_without_a_known_version_says_so_and_can_be_given_one() {
    for (text, found) in [
        (DUSK.replace("\"trochoid\": 1", "\"trochoid\": 0"), "Found \"trochoid\": 0; expected 1"),
        (DUSK.replace("\"trochoid\": 1", "\"trochoid\": \"1\""), "Found \"trochoid\": \"1\"; expected 1"),
        (DUSK.replace("  \"trochoid\": 1,\n", ""), "Found no \"trochoid\" entry at the top level"),
    ] {
        let mut window = window(Session::new(text.clone(), None), None);
        finished(&mut window);
        window.get_by_label_contains(found);
        act(&mut window, Action::Panel(Pane::Text));
        window.get_by_label_contains("trochoid: found");
        window.get_by_label("Set the format version").click();
        window.run_steps(3);
        let state = editor(&window).state();
        assert!(state.session.meaning().graph.is_some(), "{:?}", state.session.meaning().diagnostics);
        assert!(window.query_by_label("Set the format version").is_none());
        act(&mut window, Action::Undo);
        assert_eq!(editor(&window).state().session.text(), text);
    }
}

#[test]
fn versions_are_told_apart() {
    let of = |text: &str| VersionStatus::of(&serde_json::from_str(text).unwrap());
    assert_eq!(of("{ \"trochoid\": 1 }"), VersionStatus::Current);
    assert_eq!(of("{ \"trochoid\": 1.0 }"), VersionStatus::Current);
    assert_eq!(of("{ \"trochoid\": 7 }"), VersionStatus::Newer("7".into()));
    assert_eq!(of("{ \"trochoid\": -1 }"), VersionStatus::Unknown(Some("-1".into())));
    assert_eq!(of("{}"), VersionStatus::Unknown(None));
    assert_eq!(of("[]"), VersionStatus::Current, "what is no document at all has other faults");
}

#[test]
fn text_that_is_not_json_leaves_the_previous_state_visible() {
    let mut window = window(Session::new(DUSK.into(), None), None);
    finished(&mut window);
    let look = editor(&window).state().look.clone();
    act(&mut window, Action::Rewrite(DUSK.replace("\"nodes\": {", "\"nodes\": ")));
    window.get_by_label_contains("The panels show the previous state");
    assert_eq!(editor(&window).state().sheet().nodes.len(), 3);
    // Meanwhile, edits change nothing.
    let broken = editor(&window).state().session.text().to_string();
    let edit = crate::document::Edit::set(Path::node("dusk").to("weight"), &json!(0.5));
    act(&mut window, Action::Edit(edit));
    assert_eq!(editor(&window).state().session.text(), broken);
    window.get_by_label("Show the text").click();
    window.run_steps(3);
    window.get_by_label("Undo").click();
    window.run_steps(3);
    let state = editor(&window).state();
    assert_eq!((state.session.text(), &state.look), (DUSK, &look));
    assert!(window.query_by_label("Show the text").is_none());
}

#[test]
fn a_file_that_is_no_json_opens_with_its_fault() {
    let window = window(Session::new("{\n  \"trochoid\": 1,\n".into(), None), None);
    window.get_by_label_contains("Nothing else can be shown until the text is corrected");
    assert!(window.query_by_label("Width").is_none());
}

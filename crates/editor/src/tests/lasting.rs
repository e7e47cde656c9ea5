//! Tests that pictures survive errors, that the viewed node is kept, and that texts stay as written.

use super::{DUSK, dusk};
use crate::actions::{Action, Pane};
use crate::document::{Edit, Path, Session};
use crate::testing::{Window, act, editor, finished, unseen, window};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn set(value: f64) -> Action {
    Action::Edit(Edit::set(Path::node("dusk").to("weight"), &json!(value)))
}

fn broken() -> Action {
    Action::Rewrite(DUSK.replace("\"sky\", \"b\"", "\"skyy\", \"b\""))
}

#[test]
fn after_an_error_the_last_picture_stays_until_there_is_another() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    act(&mut window, Action::Viewer(crate::actions::Switch::Hold));
    act(&mut window, broken());
    finished(&mut window);
    window.run_steps(2);
    let seen = &editor(&window).state().evaluated;
    assert!(seen.failed.is_some() && seen.result.is_none());
    assert_eq!(seen.last.as_ref().map(|last| last.frame), Some(1));
    // The held picture is shown beside it, and the error message above both.
    window.get_by_label("Wipe line");
    let fault = window.get_by_label(seen.failed.as_deref().unwrap()).rect();
    let picture = window.get_by_label("Picture").rect();
    assert!(fault.top() < picture.top() + 40.0, "{fault:?} in {picture:?}");
    // Another error does not remove it either.
    act(&mut window, Action::Rewrite(DUSK.replace("\"dusk\": {", "\"dusk\": { \"unheard\": 1,")));
    finished(&mut window);
    assert!(editor(&window).state().evaluated.last.is_some());
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    finished(&mut window);
    assert!(editor(&window).state().evaluated.last.is_none() && editor(&window).state().evaluated.result.is_some());
    window.get_by_label("Wipe line");
}

#[test]
fn the_held_picture_is_released_with_its_document() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    act(&mut window, Action::Viewer(crate::actions::Switch::Hold));
    window.get_by_label("Wipe line");
    act(&mut window, Action::New);
    finished(&mut window);
    window.run_steps(3);
    assert!(window.query_by_label("Wipe line").is_none());
}

#[test]
fn undo_brings_back_what_was_looked_at() {
    let mut window = window(dusk(), None);
    act(&mut window, Action::Look("sky".into(), 0));
    act(&mut window, Action::SelectAll);
    act(&mut window, Action::Delete);
    assert_eq!(editor(&window).state().look.node, None);
    act(&mut window, Action::Undo);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("sky".into(), 0)));
    assert!(editor(&window).state().evaluated.result.is_some());
    // Undo does not override a choice made since.
    act(&mut window, Action::Select(["sky".to_string()].into()));
    act(&mut window, Action::Delete);
    act(&mut window, Action::Look("down".into(), 0));
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().look.node, Some(("down".into(), 0)));
}

#[test]
fn a_node_that_is_renamed_is_looked_at_all_the_same() {
    let mut window = window(dusk(), None);
    act(&mut window, Action::Look("sky".into(), 0));
    act(&mut window, Action::Select(["sky".to_string()].into()));
    let edit = crate::document::edit::renamed(editor(&window).state().sheet(), "sky", "air");
    act(&mut window, Action::Edit(edit));
    let look = |window: &Window| editor(window).state().look.node.clone().unwrap().0;
    assert_eq!(look(&window), "air");
    for name in ["sky", "air", "sky"] {
        act(&mut window, if name == "sky" { Action::Undo } else { Action::Redo });
        assert_eq!(look(&window), name);
        assert_eq!(editor(&window).state().chosen(), Some(name));
    }
}

#[test]
fn another_document_has_nothing_of_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| folder.path().join(format!("{name}.json")));
    std::fs::write(&one, DUSK).unwrap();
    std::fs::write(&two, DUSK.replace("#14262e", "#ffffff")).unwrap();
    let mut window = window(Session::open(&one).unwrap(), None);
    act(&mut window, Action::Panel(Pane::Text));
    finished(&mut window);
    let first = editor(&window).state().evaluated.result.as_ref().unwrap().screen.clone();
    act(&mut window, Action::OpenFile(two));
    finished(&mut window);
    assert_ne!(editor(&window).state().evaluated.result.as_ref().unwrap().screen, first);
    assert!(window.query_by_label("Not applied yet").is_none(), "the text is that of this document");
}

#[test]
fn what_is_typed_fast_lands_where_it_is_meant() {
    let text = DUSK.replace("\"down\": {", "\"eye\": { \"type\": \"Camera\", \"position\": [1, 2, 3] }, \"down\": {");
    let mut window = unseen(Session::new(text, None));
    act(&mut window, Action::Select(["eye".to_string()].into()));
    let field = super::typing::fields(&window, "position")[0];
    window.hover_at(field.center());
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
        window.event(Event::PointerButton { pos: field.center(), button, pressed, modifiers });
    }
    window.run_steps(2);
    // All input arrives between two frames, as it does if a frame takes long.
    let key =
        |key: Key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    let typed = |text: &str| text.chars().map(|c| Event::Text(c.into())).collect::<Vec<_>>();
    let events =
        [typed("0.5"), vec![key(Key::Tab)], typed("0.25"), vec![key(Key::Tab)], typed("8"), vec![key(Key::Enter)]];
    window.input_mut().events.extend(events.concat());
    window.run_steps(12);
    let position = editor(&window).state().sheet().get(&Path::node("eye").to("position")).cloned();
    assert_eq!(position, Some(json!([0.5, 0.25, 8])));
}

#[test]
fn what_is_typed_and_not_entered_is_saved_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Select(["dusk".to_string()].into()));
    window.get_by_value("0.25").focus();
    window.run_steps(2);
    window.event(Event::Text("0.75".into()));
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(4);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), DUSK.replace("0.25", "0.75"));
}

#[test]
fn a_warning_that_comes_late_moves_no_knob() {
    let mut window = unseen(dusk());
    act(&mut window, Action::Select(["dusk".to_string()].into()));
    let row = |window: &Window| window.query_all_by_label("weight").last().unwrap().rect();
    let before = row(&window);
    act(&mut window, broken());
    assert!(window.query_all_by_label_contains("skyy").next().is_some());
    assert_eq!(row(&window), before);
    act(&mut window, Action::Undo);
    assert_eq!(row(&window), before);
}

#[test]
fn a_warning_that_comes_or_goes_moves_no_knob_at_the_end_of_a_long_list() {
    let text = DUSK.replace("\"down\": {", "\"storm\": { \"type\": \"GerstnerSea\" }, \"down\": {");
    let mut window = crate::testing::unseen_in(Session::new(text.clone(), None), [1280.0, 460.0]);
    act(&mut window, Action::Select(["storm".to_string()].into()));
    let row = |window: &Window| window.query_all_by_label("seed").last().unwrap().rect();
    let first = row(&window);
    window.hover_at(egui::pos2(first.center().x, 250.0));
    window.run_steps(2);
    for _ in 0..10 {
        let (unit, modifiers) = (egui::MouseWheelUnit::Point, Modifiers::NONE);
        let phase = egui::TouchPhase::Move;
        window.event(Event::MouseWheel { unit, delta: egui::vec2(0.0, -400.0), phase, modifiers });
        window.run_steps(3);
    }
    window.run_steps(30);
    let end = row(&window);
    assert!(end.top() < first.top() - 50.0, "scrolled from {first:?} to {end:?}");
    for _ in 0..2 {
        act(&mut window, Action::Rewrite(text.replace("\"GerstnerSea\" }", "\"GerstnerSea\", \"unheard\": 1 }")));
        window.run_steps(20);
        assert!(window.query_all_by_label_contains("unheard").next().is_some());
        assert_eq!(row(&window), end);
        act(&mut window, Action::Undo);
        window.run_steps(20);
        assert_eq!(row(&window), end);
    }
}

#[test]
fn texts_of_other_systems_stay_as_they_are_but_for_what_is_changed() {
    let lines = DUSK.replace('\n', "\r\n");
    let tabs = DUSK.replace("    ", "\t\t").replace("  \"", "\t\"");
    let bare = DUSK.trim_end().to_string();
    for text in [lines.clone(), tabs, bare] {
        let mut window = unseen(Session::new(text.clone(), None));
        for pane in Pane::ALL {
            act(&mut window, Action::Panel(pane));
        }
        act(&mut window, Action::Select(["dusk".to_string()].into()));
        assert_eq!(editor(&window).state().session.text(), text);
        act(&mut window, set(0.5));
        assert_eq!(editor(&window).state().session.text(), text.replace("0.25", "0.5"));
        act(&mut window, Action::Undo);
        // New text gets the line endings of the rest.
        let edit = crate::document::edit::moved(&[("sky".into(), [7.0, 0.0])]);
        act(&mut window, Action::Edit(edit));
        let new = editor(&window).state().session.text().to_string();
        assert!(new.contains("\"sky\": [7, 0]"));
        assert_eq!(new.contains("\r\n"), text.contains("\r\n"));
        assert!(!text.contains("\r\n") || !new.replace("\r\n", "").contains('\n'), "{new:?}");
        act(&mut window, Action::Undo);
        assert_eq!(editor(&window).state().session.text(), text);
    }
}

#[test]
fn syntax_that_is_not_json_is_reported_with_its_place_and_stays() {
    for (text, found) in
        [(format!("\u{feff}{DUSK}"), "1:1"), (DUSK.replace("  \"format\"", "  // how large\n  \"format\""), "3:3")]
    {
        let mut window = unseen(Session::new(text.clone(), None));
        act(&mut window, Action::Panel(Pane::Text));
        window.get_by_label_contains(found);
        act(&mut window, set(0.5));
        assert_eq!(editor(&window).state().session.text(), text);
    }
}

#[test]
fn an_error_of_an_evaluation_names_the_place_in_the_text() {
    let text = DUSK.replace(
        "{ \"type\": \"ScreenY\" }",
        "{\n      \"type\": \"Read\", \"as\": \"color\",\n      \"fit\": \"nearest\", \"file\": \"nothing.png\" }",
    );
    let text = text.replace("\"weight\": \"down\"", "\"weight\": 0.5").replace("\"b\": \"#14262e\"", "\"b\": \"down\"");
    let line = text.lines().position(|line| line.contains("nothing.png")).unwrap();
    let column = text.lines().nth(line).unwrap().find("\"nothing.png\"").unwrap();
    let mut window = window(Session::new(text, None), None);
    finished(&mut window);
    let failed = editor(&window).state().evaluated.failed.clone().unwrap();
    assert!(failed.contains(&format!("untitled.json:{}:{}: node \"down\"", line + 1, column + 1)), "{failed}");
}

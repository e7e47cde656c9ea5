//! How faults of a document are told, and what is no fault while it is being built.

use super::{DUSK, dusk};
use crate::actions::Action;
use crate::document::{Session, edit};
use crate::testing::{act, editor, finished, unseen, window};
use egui_kittest::kittest::Queryable;

#[test]
fn a_node_that_leads_nowhere_yet_is_a_note() {
    let mut window = unseen(dusk());
    let declaration = trochoid::registry().get("Constant").unwrap().declaration();
    let (edit, name) = edit::added(editor(&window).state().sheet(), declaration, [0.0, 0.0]);
    act(&mut window, Action::Edit(edit));
    act(&mut window, Action::Select([name].into()));
    window.get_by_label("Not rendered yet: no output needs this node.");
    assert!(window.query_by_label_contains("expected every node").is_none());
    assert!(window.query_by_label("1 warning").is_none());
    assert_eq!(editor(&window).state().session.meaning().diagnostics.len(), 1, "the command line tells it");
}

#[test]
fn the_viewer_tells_place_and_remedy_and_leads_to_the_node_that_it_names() {
    // Two nodes have errors; the picture fails because of the viewed one.
    let text =
        DUSK.replace(r#""type": "ScreenY""#, r#""type": "ScreenQ""#).replace(r#""weight": 0.25"#, r#""weight": 2"#);
    let mut window = window(Session::new(text, None), None);
    finished(&mut window);
    window.run_steps(3);
    let seen = &editor(&window).state().evaluated;
    let (failed, culprit) = (seen.failed.clone().unwrap(), seen.culprit.clone().unwrap());
    assert!(failed.starts_with(&culprit) && failed.contains("; expected "), "{failed}");
    window.get_by_label(&format!("Show {culprit}")).click();
    window.run_steps(3);
    assert!(editor(&window).state().selection.contains(&culprit));
    // A type that is nearly one is answered with that one.
    act(&mut window, Action::Look("sky".into(), 0));
    finished(&mut window);
    window.run_steps(3);
    let failed = editor(&window).state().evaluated.failed.clone().unwrap();
    assert!(failed.starts_with("down, ") && failed.contains("did you mean"), "{failed}");
    window.get_by_label("Show down");
}

#[test]
fn a_list_of_connections_is_shown_before_it_has_any() {
    let mut window = unseen(dusk());
    let ty = trochoid::registry().get("ObjectMask").unwrap().declaration();
    let (edit, name) = edit::added(editor(&window).state().sheet(), ty, [0.0, 0.0]);
    act(&mut window, Action::Edit(edit));
    act(&mut window, Action::Select([name].into()));
    window.get_by_label_contains("none yet: connect a Surface");
}

#[test]
fn a_new_gradient_has_two_stops() {
    let mut window = unseen(dusk());
    let ty = trochoid::registry().get("Ramp").unwrap().declaration();
    let (edit, name) = edit::added(editor(&window).state().sheet(), ty, [0.0, 0.0]);
    act(&mut window, Action::Edit(edit));
    let sheet = editor(&window).state().sheet().clone();
    let stops = sheet.get(&crate::document::Path::node(&name).to("stops")).unwrap();
    assert_eq!(stops, &serde_json::json!([{ "at": 0, "color": "#000000" }, { "at": 1, "color": "#ffffff" }]));
    assert_eq!(editor(&window).state().session.meaning().errors().count(), 0);
}

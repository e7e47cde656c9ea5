//! The second viewer.

use super::DUSK;
use crate::actions::{Action, Pane};
use crate::document::{Path, Session, edit};
use crate::editor::Editor;
use crate::testing::{Window, act, editor, finished, until, window};
use egui::{Event, Key, Modifiers, MouseWheelUnit, TouchPhase, vec2};
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn second(editor: &Editor) -> &crate::state::Evaluated {
    &editor.state().second.evaluated
}

/// Draws until both viewers show what they should.
fn both(window: &mut Window) {
    finished(window);
    until(window, "the second picture", |editor| {
        let seen = second(editor);
        let is_done = seen.result.as_ref().is_some_and(|result| result.finished);
        seen.progress.is_none() && (seen.failed.is_some() || is_done)
    });
    window.run_steps(2);
}

fn open() -> Window {
    let mut window = window(Session::new(DUSK.into(), None), None);
    finished(&mut window);
    act(&mut window, Action::Panel(Pane::Second));
    both(&mut window);
    window
}

/// Looks at a node in the second viewer.
fn look(window: &mut Window, node: &str) {
    act(window, Action::Second(Action::Look(node.into(), 0).into()));
    both(window);
}

fn subjects(window: &Window) -> [String; 2] {
    let state = editor(window).state();
    [&state.evaluated, &state.second.evaluated].map(|seen| seen.result.as_ref().unwrap().subject.whole_name())
}

fn pixels(window: &Window) -> [[u8; 3]; 2] {
    let state = editor(window).state();
    [&state.evaluated, &state.second.evaluated].map(|seen| {
        let screen = &seen.result.as_ref().unwrap().screen;
        [screen.pixels[0], screen.pixels[1], screen.pixels[2]]
    })
}

#[test]
fn nothing_is_evaluated_for_it_before_it_is_opened_and_after_it_is_closed() {
    let mut window = window(Session::new(DUSK.into(), None), None);
    finished(&mut window);
    window.run_steps(10);
    assert!(second(editor(&window)).result.is_none() && second(editor(&window)).progress.is_none());
    act(&mut window, Action::Panel(Pane::Second));
    both(&mut window);
    assert_eq!(subjects(&window), ["dusk", "dusk"], "at first it shows the same");
    let tree = &mut window.state_mut().as_mut().unwrap().tree;
    let tile = tree.tiles.find_pane(&Pane::Second).unwrap();
    tree.set_visible(tile, false);
    window.run_steps(2);
    assert!(second(editor(&window)).result.is_none(), "its pictures are freed");
    let bypass = edit::disabled(editor(&window).state().sheet(), &["sky".into()]);
    act(&mut window, Action::Edit(bypass));
    finished(&mut window);
    window.run_steps(10);
    assert!(second(editor(&window)).result.is_none() && second(editor(&window)).progress.is_none());
}

#[test]
fn it_shows_another_node_with_settings_of_its_own_and_follows_edits() {
    let mut window = open();
    look(&mut window, "sky");
    assert_eq!(subjects(&window), ["dusk", "sky"]);
    let before = pixels(&window);
    assert_ne!(before[0], before[1]);
    // Its number key, while the pointer is over it.
    let place = window.get_by_label("Picture 2").rect().center();
    window.hover_at(place);
    window.step();
    window.key_press(Key::Num1);
    both(&mut window);
    assert_eq!(subjects(&window), ["dusk", "dusk"]);
    look(&mut window, "sky");
    // One edit changes both.
    let color = Path::node("sky").to("stops").to(0).to("color");
    act(&mut window, Action::Edit(crate::document::Edit::set(color, &json!("#ff0000"))));
    both(&mut window);
    let after = pixels(&window);
    assert!(after[0] != before[0] && after[1] != before[1]);
    assert!(after[1][0] > 240, "{after:?}");
    // A display of its own.
    let mut display = editor(&window).state().second.look.display.clone();
    display.exposure = -20.0;
    act(&mut window, Action::Second(Action::Display(display).into()));
    until(&mut window, "a dark picture", |editor| second(editor).result.as_ref().unwrap().screen.pixels[0] == 0);
    assert_eq!(pixels(&window)[0], after[0]);
    // The node keeps its place in the viewer under another name.
    let rename = edit::renamed(editor(&window).state().sheet(), "sky", "heaven");
    act(&mut window, Action::Edit(rename));
    both(&mut window);
    assert_eq!(subjects(&window), ["dusk", "heaven"]);
    // Frames are kept for playback, which is the first one's alone.
    for frame in 2..=6 {
        act(&mut window, Action::Frame(frame));
        both(&mut window);
    }
    assert_eq!(second(editor(&window)).result.as_ref().unwrap().frame, 6);
    assert_eq!(editor(&window).state().evaluated.frames.len(), 6);
    assert!(second(editor(&window)).frames.len() <= 2);
}

#[test]
fn an_error_in_one_leaves_the_other_alone() {
    let text = DUSK.replace(
        "\"dusk\":",
        "\"lost\": { \"type\": \"Mix\", \"a\": \"#ffffff\", \"b\": \"sky\", \"weight\": 1 },\n    \"dusk\":",
    );
    let mut window = window(Session::new(text, None), None);
    finished(&mut window);
    act(&mut window, Action::Panel(Pane::Second));
    look(&mut window, "lost");
    let broken = crate::document::Edit::set(Path::node("lost").to("b"), &json!("nothing"));
    act(&mut window, Action::Edit(broken));
    until(&mut window, "the error", |editor| second(editor).failed.is_some());
    finished(&mut window);
    let state = editor(&window).state();
    assert_eq!(state.evaluated.failed, None);
    assert!(state.second.evaluated.last.is_some(), "the last picture stays");
    window.run_steps(2);
    window.get_by_label("Old picture");
    act(&mut window, Action::Undo);
    both(&mut window);
    assert!(window.query_by_label("Old picture").is_none());
    // The other way around.
    act(&mut window, Action::Second(Action::Look("sky".into(), 0).into()));
    act(&mut window, Action::Look("lost".into(), 0));
    both(&mut window);
    let broken = crate::document::Edit::set(Path::node("lost").to("b"), &json!("nothing"));
    act(&mut window, Action::Edit(broken));
    until(&mut window, "the error", |editor| editor.state().evaluated.failed.is_some());
    both(&mut window);
    assert_eq!(second(editor(&window)).failed, None);
    window.get_by_label("Old picture");
}

#[test]
fn a_deleted_node_leaves_the_first_output_until_it_is_back() {
    let mut window = open();
    look(&mut window, "sky");
    let deletion = crate::canvas::deleting(editor(&window).state().sheet(), &["sky".into()]);
    act(&mut window, Action::Edit(deletion));
    window.run_steps(3);
    assert_eq!(editor(&window).state().second.look.node, Some(("dusk".into(), 0)));
    act(&mut window, Action::Undo);
    both(&mut window);
    assert_eq!(subjects(&window), ["dusk", "sky"]);
}

#[test]
fn a_click_in_it_tells_of_what_the_pixel_is_made() {
    let mut window = open();
    look(&mut window, "sky");
    let at = window.get_by_label("Picture 2").rect().center();
    super::typing::click(&mut window, at);
    until(&mut window, "the blame", |editor| second(editor).blame.is_some());
    assert!(editor(&window).state().look.pick.is_none(), "the first one has no mark");
    assert!(editor(&window).state().second.look.pick.is_some());
    let blamed = second(editor(&window)).blame.as_ref().unwrap();
    let sum: f64 = blamed.shares.iter().map(|share| share.weight).sum();
    assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(editor(&window).state().second.look.pick.is_none());
}

#[test]
fn locked_viewers_zoom_together() {
    let mut window = open();
    let zooms =
        |window: &Window| window.query_all_by_label_contains(" %").filter_map(|node| node.value()).collect::<Vec<_>>();
    let scroll = |window: &mut Window, label: &str| {
        let at = window.get_by_label(label).rect().center();
        window.hover_at(at);
        window.step();
        let (unit, delta, phase) = (MouseWheelUnit::Line, vec2(0.0, 6.0), TouchPhase::Move);
        window.event(Event::MouseWheel { unit, delta, modifiers: Modifiers::NONE, phase });
        window.run_steps(60);
    };
    let fitted = zooms(&window);
    scroll(&mut window, "Picture 2");
    let one = zooms(&window);
    assert_eq!(fitted.len(), 2);
    assert_eq!(one.iter().filter(|zoom| fitted.contains(zoom)).count(), 1, "{fitted:?} {one:?}");
    window.get_by_label("Lock").click();
    window.run_steps(3);
    scroll(&mut window, "Picture 2");
    let locked = zooms(&window);
    assert_eq!(locked[0], locked[1]);
    scroll(&mut window, "Picture");
    let both = zooms(&window);
    assert_eq!(both[0], both[1]);
    assert_ne!(both, locked);
}

#[test]
fn the_toolbars_of_both_viewers_are_one_line_each() {
    let mut window = open();
    window.run_steps(3);
    for label in ["RGB", "More"] {
        assert_eq!(window.get_all_by_label(label).count(), 2, "{label}");
    }
    let lines: Vec<f32> = window.get_all_by_label("RGB").map(|tool| tool.rect().center().y).collect();
    for more in window.get_all_by_label("More") {
        let at = more.rect().center().y;
        assert!(lines.iter().any(|line| (line - at).abs() < 2.0), "{at} is on none of {lines:?}");
    }
}

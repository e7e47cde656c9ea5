use super::{DUSK, dusk};
use crate::testing::{Window, editor, finished, window};
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::Queryable;

fn command(window: &mut Window, letters: &str) {
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    window.run_steps(3);
    window.event(Event::Text(letters.into()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(4);
}

fn text(window: &Window, path: &str) -> String {
    let value = editor(window).state().sheet().value.pointer(path);
    value.map(crate::document::change::style).unwrap_or_default()
}

#[test]
fn a_new_backdrop_is_written_on_at_once_and_again_after_a_double_click() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::SHIFT, Key::B);
    window.run_steps(4);
    for c in ["D", "u", "s", "k"] {
        window.event(Event::Text(c.into()));
        window.run_steps(1);
    }
    window.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    window.run_steps(3);
    assert_eq!(text(&window, "/ui/backdrops/backdrop1/text"), "\"Dusk\"");
    command(&mut window, "name backdrop");
    window.event(Event::Text("Dawn".into()));
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    window.run_steps(3);
    assert_eq!(text(&window, "/ui/backdrops/backdrop1/text"), "\"Dawn\"");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(3);
    let title = window.get_by_label("Backdrop Dusk").rect().left_center() + egui::vec2(14.0, 0.0);
    for _ in 0..2 {
        for pressed in [true, false] {
            window.hover_at(title);
            let button = PointerButton::Primary;
            window.event(Event::PointerButton { pos: title, button, pressed, modifiers: Modifiers::NONE });
            window.run_steps(2);
        }
    }
    window.run_steps(3);
    window.key_press(Key::D);
    window.event(Event::Text("D".into()));
    window.run_steps(3);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    window.run_steps(3);
    assert_eq!(text(&window, "/ui/backdrops/backdrop1/text"), "\"DuskD\"");
    assert!(editor(&window).state().sheet().nodes.iter().all(|node| !node.disabled), "nothing went to the hotkeys");
}

#[test]
fn the_palette_takes_the_place_of_a_chooser() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.get_by_label("Node type");
    command(&mut window, "selall");
    assert!(window.query_by_label("Node type").is_none());
    assert_eq!(editor(&window).state().selection.len(), 3);
}

#[test]
fn commands_make_outputs_notes_dots_and_lines() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.state_mut().as_mut().unwrap().select(&["sky"]);
    command(&mut window, "make output");
    assert_eq!(text(&window, "/outputs/sky"), r#"{ "color": "sky", "file": "sky.####.png" }"#);
    window.key_press(Key::Period);
    window.run_steps(3);
    assert!(text(&window, "/ui/wires").contains("dusk.a"));
    window.state_mut().as_mut().unwrap().select(&["sky", "dusk", "down"]);
    command(&mut window, "align left");
    let lefts: Vec<f32> = editor(&window).state().sheet().nodes.iter().map(|node| node.at[0]).collect();
    assert!(lefts.iter().all(|left| (left - lefts[0]).abs() < 1.1), "{lefts:?}");
    command(&mut window, "note");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(text(&window, "/ui/backdrops/backdrop1/text"), "\"Note\"");
    for _ in 0..4 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
    }
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn properties_show_and_change_what_is_rendered() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.get_by_label("beauty").click();
    window.run_steps(3);
    let field = window.get_by_label("File of the output");
    field.focus();
    window.run_steps(2);
    window.get_by_label("File of the output").type_text("x");
    window.run_steps(3);
    assert!(text(&window, "/outputs/beauty/file").contains('x'));
    window.get_by_label("Remove").click();
    window.run_steps(3);
    assert_eq!(text(&window, "/outputs"), "{}");
    assert_eq!(editor(&window).state().output, None);
}

use super::dusk;
use crate::commands::{MENUS, commands};
use crate::testing::{Window, editor, finished, until, window};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::collections::HashMap;

#[test]
fn every_command_stands_in_a_menu_and_no_keys_mean_two_things() {
    let mut keys = HashMap::new();
    for command in commands() {
        assert!(MENUS.contains(&command.menu), "{}", command.name);
        assert!(command.help.ends_with('.'), "{}", command.name);
        if let Some(shortcut) = command.keys {
            let other = keys.insert((shortcut.modifiers, shortcut.logical_key), command.name);
            assert_eq!(other, None, "{}", command.name);
        }
    }
}

#[test]
fn frames_are_stepped_and_played() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.key_press(Key::ArrowRight);
    window.run_steps(2);
    assert_eq!(editor(&window).state().frame, 2);
    window.key_press(Key::End);
    window.run_steps(2);
    assert_eq!(editor(&window).state().frame, 8);
    window.key_press(Key::Home);
    window.run_steps(2);
    window.key_press(Key::Space);
    until(&mut window, "all frames", |editor| editor.state().evaluated.frames.len() == 8);
    assert!(editor(&window).state().playing);
    window.key_press(Key::Space);
    window.run_steps(2);
    assert!(!editor(&window).state().playing);
}

#[test]
fn the_palette_finds_a_command_by_a_few_letters() {
    let mut window = window(dusk(), None);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    window.run_steps(3);
    window.get_by_role(egui::accesskit::Role::TextInput).type_text("selall");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(editor(&window).state().selection.len(), 3);
}

#[test]
fn what_is_chosen_is_deleted_disabled_and_brought_back() {
    let mut window = window(dusk(), None);
    window.state_mut().as_mut().unwrap().select(&["sky"]);
    window.key_press(Key::D);
    window.run_steps(2);
    assert!(editor(&window).state().sheet().node("sky").unwrap().disabled);
    window.key_press(Key::Delete);
    window.run_steps(2);
    assert!(editor(&window).state().sheet().find("sky").is_none());
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(editor(&window).state().session.text(), super::DUSK);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    window.run_steps(2);
    assert!(editor(&window).state().sheet().node("sky").unwrap().disabled);
}

#[test]
fn number_keys_assign_nodes_and_show_them() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("dusk".into(), 0)));
    window.state_mut().as_mut().unwrap().select(&["sky"]);
    window.key_press(Key::Num2);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("sky".into(), 0)));
    window.state_mut().as_mut().unwrap().select(&[]);
    window.key_press(Key::Num1);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("dusk".into(), 0)));
}

#[test]
fn the_space_bar_plays_when_it_is_let_go_unless_it_moved_the_view() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    let picture = window.get_by_label("Picture").rect().center();
    let playing = |window: &Window| editor(window).state().playing;
    window.key_down(Key::Space);
    window.run_steps(3);
    assert!(!playing(&window), "it may become a drag");
    window.hover_at(picture);
    let button = |pos: egui::Pos2, pressed: bool| egui::Event::PointerButton {
        pos,
        pressed,
        button: egui::PointerButton::Primary,
        modifiers: Modifiers::NONE,
    };
    window.event(button(picture, true));
    window.run_steps(1);
    for step in 1..=4 {
        window.hover_at(picture + egui::vec2(12.0 * step as f32, 0.0));
        window.run_steps(1);
    }
    window.event(button(picture + egui::vec2(48.0, 0.0), false));
    window.run_steps(1);
    window.key_up(Key::Space);
    window.run_steps(3);
    assert!(!playing(&window));
    assert_eq!(editor(&window).state().look.pick, None, "the view was moved, and nothing was picked");
    window.key_press(Key::Space);
    window.run_steps(2);
    assert!(playing(&window));
}

#[test]
fn the_viewer_and_the_properties_lead_to_the_faulty_node() {
    let text = super::DUSK.replace("ScreenY", "ScreenZ");
    for button in ["Show down", "Error above, in down"] {
        let mut window = window(crate::document::Session::new(text.clone(), None), None);
        finished(&mut window);
        window.state_mut().as_mut().unwrap().select(&["dusk"]);
        window.run_steps(3);
        window.get_by_label_contains(button).click();
        window.run_steps(3);
        assert_eq!(editor(&window).state().chosen(), Some("down"), "{button}");
    }
}

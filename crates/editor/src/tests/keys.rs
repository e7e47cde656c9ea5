use super::dusk;
use crate::commands::{COMMANDS, MENUS};
use crate::testing::{editor, finished, until, window};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::collections::HashMap;

#[test]
fn every_command_stands_in_a_menu_and_no_keys_mean_two_things() {
    let mut keys = HashMap::new();
    for command in COMMANDS {
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
    until(&mut window, "all frames", |editor| editor.state().seen.frames.len() == 8);
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
fn a_number_shows_what_is_under_it() {
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

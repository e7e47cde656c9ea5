//! What the viewers make of light for the screen.

use crate::actions::{Action, Pane};
use crate::document::Session;
use crate::evaluate::Display;
use crate::testing::{Window, act, editor, finished, until, window};
use crate::transform::{Takes, Transform};
use egui_kittest::kittest::Queryable;

const PLAIN: &str = r##"{
  "trochoid": 1, "format": { "width": 8, "height": 4 }, "working_space": "linear-srgb",
  "nodes": { "plain": { "type": "Constant", "color": "#c08040" } },
  "outputs": { "beauty": { "color": "plain" } }
}"##;

/// A table that turns every value around.
const TURNED: &str = "TITLE \"turned\"\nLUT_3D_SIZE 2\n1 1 1\n0 1 1\n1 0 1\n0 0 1\n1 1 0\n0 1 0\n1 0 0\n0 0 0\n";

fn open() -> Window {
    let mut window = window(Session::new(PLAIN.into(), None), None);
    finished(&mut window);
    assert_eq!(shown(&window), [0xc0, 0x80, 0x40]);
    window
}

fn shown(window: &Window) -> [u8; 3] {
    let screen = &editor(window).state().evaluated.result.as_ref().unwrap().screen;
    [screen.pixels[0], screen.pixels[1], screen.pixels[2]]
}

fn show(window: &mut Window, transform: Transform) {
    let display = Display { transform, ..Display::default() };
    act(window, Action::Display(display.clone()));
    until(window, "the picture", |editor| {
        editor.state().evaluated.result.as_ref().is_some_and(|result| result.finished && result.display == display)
    });
    window.run_steps(2);
}

fn near(found: [u8; 3], expected: [u8; 3]) {
    assert!(
        found.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 1),
        "{found:?} {expected:?}"
    );
}

#[test]
fn the_menu_offers_rec_709_and_nothing_is_written() {
    let mut window = open();
    // Above all panels is the menu.
    let all = window.query_all_by_label("Viewer");
    all.min_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).unwrap().click();
    window.run_steps(3);
    window.get_by_label_contains("Transform").click();
    window.run_steps(4);
    window.get_by_label("For viewing only");
    window.get_by_label("Rec.709 (BT.1886)").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().look.display.transform, Transform::Bt1886);
    finished(&mut window);
    window.run_steps(5);
    let light = [0xc0, 0x80, 0x40].map(|byte| trochoid::srgb_decode(f64::from(byte) / 255.0));
    near(shown(&window), light.map(|light| (light.powf(1.0 / 2.4) * 255.0).round() as u8));
    // The toolbar says what is seen, and leads back.
    window.get_by_label("Transform Rec.709").click();
    window.run_steps(3);
    window.get_by_label("sRGB").click();
    window.run_steps(3);
    finished(&mut window);
    window.run_steps(5);
    assert_eq!(shown(&window), [0xc0, 0x80, 0x40]);
    assert!(window.query_by_label_contains("Transform").is_none());
    assert!(editor(&window).state().session.history().undoes().is_none());
}

#[test]
fn a_table_takes_light_or_encoded_values_after_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turned.cube");
    std::fs::write(&file, TURNED).unwrap();
    let mut window = open();
    show(&mut window, Transform::read(&file, Takes::Encoded).unwrap());
    near(shown(&window), [0x3f, 0x7f, 0xbf]);
    window.get_by_label("Transform turned.cube");
    show(&mut window, Transform::read(&file, Takes::Light).unwrap());
    let light = [0xc0, 0x80, 0x40].map(|byte| trochoid::srgb_decode(f64::from(byte) / 255.0));
    near(shown(&window), light.map(|light| ((1.0 - light) * 255.0).round() as u8));
    // A new document is seen through it, too; the second viewer begins with the same.
    act(&mut window, Action::New);
    finished(&mut window);
    let state = editor(&window).state();
    assert_eq!(state.look.display.transform.name(), "turned.cube");
    assert_eq!(state.second.look.display.transform, state.look.display.transform);
}

#[test]
fn a_transform_is_remembered_and_a_missing_file_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turned.cube");
    std::fs::write(&file, TURNED).unwrap();
    let mut first = open();
    show(&mut first, Transform::read(&file, Takes::Encoded).unwrap());
    let kept = editor(&first).kept_transform();
    let mut second = open();
    second.state_mut().as_mut().unwrap().restore_transform(&kept);
    until(&mut second, "the picture", |editor| {
        editor.state().evaluated.result.as_ref().unwrap().display.transform != Transform::Srgb
    });
    near(shown(&second), [0x3f, 0x7f, 0xbf]);
    std::fs::remove_file(&file).unwrap();
    let mut third = open();
    third.state_mut().as_mut().unwrap().restore_transform(&kept);
    third.run_steps(3);
    assert_eq!(editor(&third).state().look.display.transform, Transform::Srgb);
    third.get_by_label_contains("The viewer shows colors as sRGB: ");
    // What is damaged is as if nothing was remembered.
    for kept in ["", "{", "\"Log\"", "{\"Cube\":1}"] {
        third.state_mut().as_mut().unwrap().restore_transform(kept);
        assert_eq!(editor(&third).state().look.display.transform, Transform::Srgb);
    }
}

#[test]
fn a_color_is_picked_as_it_is_and_not_as_it_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turned.cube");
    std::fs::write(&file, TURNED).unwrap();
    let mut window = open();
    show(&mut window, Transform::read(&file, Takes::Encoded).unwrap());
    let place = crate::document::Path::node("plain").to("color");
    act(&mut window, Action::Panel(Pane::Viewer));
    act(&mut window, Action::Dropper(Some(place.clone())));
    let at = window.get_by_label("Picture").rect().center();
    super::typing::click(&mut window, at);
    window.run_steps(3);
    assert!(editor(&window).state().dropper.is_none());
    assert_eq!(editor(&window).state().sheet().get(&place).unwrap(), "#c08040");
}

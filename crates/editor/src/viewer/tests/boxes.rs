//! Tests of the inspector's box, of the legend over the picture, and of the menu of tools.

use super::{MIXED, WINDOW, act, button, click, hover, open, picture, press, settle};
use crate::actions::{Action, Switch};
use crate::testing::editor;
use egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::kittest::Queryable;

#[test]
fn the_inspector_moves_nothing_and_never_lies_over_its_pixel() {
    let mut window = open(MIXED, WINDOW);
    let before = picture(&window);
    // The picture is fitted into its panel.
    let width = before.width().min(before.height() * 64.0 / 36.0);
    let pixel = |share: f32| pos2(before.center().x + (share - 0.5) * width, before.center().y);
    for share in [0.1, 0.9, 0.5, 0.95, 0.05] {
        act(&mut window, Action::Pick(None));
        click(&mut window, pixel(share));
        assert_eq!(picture(&window), before, "the picture stays at {share}");
        let box_of = window.query_by_label("Mixed of").unwrap_or_else(|| panic!("no inspector at {share}")).rect();
        assert!(before.contains_rect(box_of) && !box_of.expand2(vec2(90.0, 400.0)).contains(pixel(share)), "{share}");
    }
    // A click in it picks no pixel, and it does not leap away from a pointer that is pressed.
    let pick = editor(&window).state().look.pick;
    let inside = window.get_by_label("Mixed of").rect().center();
    click(&mut window, inside);
    assert_eq!(editor(&window).state().look.pick, pick);
    click(&mut window, pixel(0.5));
    let side = window.get_by_label("Mixed of").rect();
    button(&mut window, pixel(0.5), true, Modifiers::NONE);
    for share in [0.3, 0.6, 0.9, 0.95] {
        hover(&mut window, pixel(share));
        assert_eq!(window.get_by_label("Mixed of").rect().left(), side.left());
    }
    button(&mut window, pixel(0.95), false, Modifiers::NONE);
    settle(&mut window);
    press(&mut window, Key::Escape);
    assert!(window.query_by_label("Mixed of").is_none());
}

#[test]
fn near_says_what_its_marks_mean() {
    let solid = MIXED
        .replace(r##""b": "#00ff00", "weight": 0.25"##, r##""b": "dark", "weight": 0.5"##)
        .replace(r##""b": "#ffffff", "weight": 0.25"##, r##""b": "#ffffff", "weight": "across""##);
    let mut window = open(&solid, WINDOW);
    let at = picture(&window).center();
    hover(&mut window, at);
    press(&mut window, Key::N);
    assert!(window.query_by_label("Near: on a face of the hull, to 0.02 inside").is_some());
    press(&mut window, Key::N);
    assert!(window.query_by_label_contains("Near: on a face").is_none());
}

#[test]
fn more_says_what_is_on_in_it() {
    let mut window = open(MIXED, [560.0, 640.0]);
    assert!(window.query_by_label("More").is_some() && window.query_by_label("Scopes").is_none());
    act(&mut window, Action::Viewer(Switch::Hull));
    assert!(window.query_by_label("More •").is_some() && window.query_by_label("More").is_none());
    act(&mut window, Action::Viewer(Switch::Hull));
    assert!(window.query_by_label("More").is_some());
}

//! How the window looks: menus, the timeline, and values that stand below each other.

use super::{DUSK, dusk};
use crate::actions::{Action, HelpPage, Pane, Switch};
use crate::document::Session;
use crate::testing::{Window, act, editor, finished, sized, unseen, window};
use egui::accesskit::{Role, Toggled};
use egui_kittest::kittest::{NodeT, Queryable};

/// Returns a document with a node of numbers that can be animated.
fn clamped() -> Session {
    let band = r#""band": { "type": "Clamp", "field": "down", "min": 0.25, "max": 0.75 }, "sky""#;
    Session::new(DUSK.replacen(r#""sky""#, band, 1), None)
}

fn open_menu(window: &mut Window, menu: &str) {
    // Panels have tabs of the same names, below.
    let named = window.query_all_by_role_and_label(Role::Button, menu);
    let topmost = named.min_by(|a, b| a.rect().top().total_cmp(&b.rect().top()));
    topmost.unwrap().click();
    window.run_steps(4);
}

#[test]
fn menus_tick_what_is_switched_on() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    // Buttons of the toolbar have the same names, and must be in the same state.
    let all_are = |window: &mut Window, entry: &str, ticked: Option<bool>| {
        open_menu(window, "Viewer");
        let found = window.query_all_by_role_and_label(Role::Button, entry);
        let found: Vec<Option<Toggled>> = found.map(|node| node.accesskit_node().toggled()).collect();
        assert!(
            !found.is_empty() && found.iter().all(|found| *found == ticked.map(Toggled::from)),
            "{entry}: {found:?}"
        );
        window.key_press(egui::Key::Escape);
        window.run_steps(4);
    };
    all_are(&mut window, "Full size", Some(true));
    all_are(&mut window, "Next frame", None);
    for (entry, action) in [
        ("Onion skin", Action::Onion(true)),
        ("Hull", Action::Viewer(Switch::Hull)),
        ("Wipe", Action::Viewer(Switch::Wipe)),
        ("Half size", Action::Proxy(2)),
    ] {
        all_are(&mut window, entry, Some(false));
        act(&mut window, action);
        all_are(&mut window, entry, Some(true));
    }
}

#[test]
fn a_menu_offers_each_layout_once() {
    let mut window = unseen(dusk());
    open_menu(&mut window, "Window");
    for once in ["Painting layout", "Save layout …"] {
        assert!(window.query_by_label(once).is_none(), "{once}");
    }
    window.get_by_label_contains("Layout").click();
    window.run_steps(4);
    for entry in ["Default", "Painting", "Animation", "Save layout …"] {
        window.get_by_role_and_label(Role::Button, entry);
    }
}

#[test]
fn everything_beside_the_timeline_stands_on_its_line() {
    for size in [[900.0, 600.0], [1280.0, 800.0], [2560.0, 1440.0]] {
        let window = sized(dusk(), None, size);
        let line = window.get_by_label("Timeline").rect();
        for label in ["First frame (Home)", "Play (Space)", "Last frame (End)", "Onion"] {
            let rect = window.get_by_label(label).rect();
            assert!((rect.center().y - line.center().y).abs() < 1.0, "{label} at {size:?}: {rect:?} beside {line:?}");
        }
        let numbers = window.query_all_by_role(Role::SpinButton).map(|node| node.rect());
        let numbers: Vec<egui::Rect> =
            numbers.filter(|rect| rect.intersects(line.expand2([2000.0, 0.0].into()))).collect();
        assert!(numbers.len() >= 4, "{numbers:?}");
        for rect in numbers {
            assert!((rect.center().y - line.center().y).abs() < 1.0, "{size:?}: {rect:?} beside {line:?}");
        }
    }
}

#[test]
fn numbers_form_a_column_and_names_take_clicks_where_they_stand() {
    let mut window = unseen(clamped());
    window.state_mut().as_mut().unwrap().select(&["band"]);
    window.run_steps(4);
    let names = ["min", "max"].map(|name| window.get_by_label(name).rect());
    for name in names {
        assert!(name.width() < 40.0, "{name:?} is wider than its text");
    }
    let numbers: Vec<egui::Rect> = window
        .query_all_by_role(Role::SpinButton)
        .map(|node| node.rect())
        .filter(|rect| names.iter().any(|name| (name.center().y - rect.center().y).abs() < 3.0))
        .filter(|rect| rect.left() > names[0].left())
        .collect();
    assert_eq!(numbers.len(), 2, "{numbers:?}");
    assert!(numbers.iter().all(|rect| rect.width() >= 63.0), "{numbers:?}");
    assert_eq!(numbers[0].right(), numbers[1].right());
    // Beside the name, nothing is clicked.
    let mut beside = |by: f32| {
        let at = names[0].right_center() + egui::vec2(by, 0.0);
        window.hover_at(at);
        for pressed in [true, false] {
            let modifiers = egui::Modifiers::NONE;
            window.event(egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Secondary,
                pressed,
                modifiers,
            });
        }
        window.run_steps(4);
        window.query_by_label("Copy value").is_some()
    };
    assert!(!beside(20.0) && beside(-3.0));
}

#[test]
fn the_menu_of_a_knob_sets_and_removes_a_key() {
    let mut window = unseen(clamped());
    window.state_mut().as_mut().unwrap().select(&["band"]);
    window.run_steps(4);
    let value = |window: &Window| {
        let path = crate::document::Path::node("band").to("min");
        editor(window).state().sheet().get(&path).cloned()
    };
    for (entry, expected) in
        [("Set key", serde_json::json!({ "keys": [[1, 0.25]] })), ("Remove key", serde_json::json!(0.25))]
    {
        window.get_by_label("min").click_secondary();
        window.run_steps(4);
        window.get_by_label(entry).click();
        window.run_steps(4);
        let found = value(&window).unwrap();
        match entry {
            "Set key" => assert_eq!(found["keys"], expected["keys"]),
            _ => assert_eq!(found, expected),
        }
    }
}

#[test]
fn lines_of_the_text_are_not_wrapped() {
    let height = |notes: &str| {
        let text = DUSK.replacen(r#""frames""#, &format!(r#""notes": "{notes}", "frames""#), 1);
        let mut window = unseen(Session::new(text, None));
        act(&mut window, Action::Panel(Pane::Text));
        window.run_steps(3);
        window.get_by_role(Role::MultilineTextInput).rect().height()
    };
    let short = height("a sea");
    assert!(short > 100.0);
    assert_eq!(height(&"a sea ".repeat(400)), short);
}

#[test]
fn the_contents_of_the_help_show_no_markup() {
    let mut window = unseen(dusk());
    act(&mut window, Action::Help(HelpPage::Contents));
    window.run_steps(3);
    let labels = window.query_all_by_role(Role::Label).filter_map(|node| node.accesskit_node().value());
    let marked: Vec<String> = labels.filter(|text| text.contains('`')).collect();
    assert!(marked.is_empty(), "{marked:?}");
    assert!(
        trochoid::registry().iter().any(|ty| ty.declaration().summary.contains('`')),
        "then this test shows nothing"
    );
}

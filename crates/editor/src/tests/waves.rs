//! The waves panel: plots that follow knobs and frames, for seas in groups too.

use crate::actions::{Action, Pane};
use crate::document::{Edit, Path, Session};
use crate::testing::{Window, act, editor, unseen};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// One wave whose height follows keys, steep enough to fold at the last frame.
const WAVE: &str = r#"{
  "trochoid": 1,
  "format": { "width": 32, "height": 18 },
  "frames": { "first": 1, "last": 9 },
  "nodes": {
    "eye": { "type": "Camera", "position": [0, 6, 20] },
    "storm": { "type": "GerstnerSea", "count": 0, "waves": [
      { "wavelength": 20, "amplitude": { "keys": [[1, 1.5], [9, 3]] }, "sharpness": { "keys": [[1, 0], [9, 1.5]] }, "speed": 0 }
    ] },
    "view": { "type": "Render", "camera": "eye", "surfaces": ["storm"] },
    "deep": { "type": "Depth", "view": "view" }
  },
  "outputs": { "depth": { "field": "deep" } }
}"#;

/// Two seas: one in a group that is used twice, and a toon sea.
const GROUPED: &str = r#"{
  "trochoid": 1,
  "format": { "width": 32, "height": 18 },
  "frames": { "first": 1, "last": 24 },
  "groups": { "Bay": {
    "knobs": { "wild": { "default": 1.5, "unit": "m" } },
    "nodes": { "sea": { "type": "GerstnerSea", "count": 20, "height": "= knobs.wild", "direction": 90 } },
    "outputs": { "sea": "sea" }
  } },
  "nodes": {
    "eye": { "type": "Camera", "position": [0, 6, 20] },
    "toon": { "type": "ToonSea", "columns": 32, "rows": 32, "bursts": [{ "path": [0, 0, 1, 1, 2, 2, 4, 4], "height": 2 }] },
    "front": { "type": "Bay", "wild": 2 },
    "back": { "type": "Bay" },
    "near": { "type": "Render", "camera": "eye", "surfaces": ["front"] },
    "far": { "type": "Render", "camera": "eye", "surfaces": ["back", "toon"] },
    "deep": { "type": "Depth", "view": "near" },
    "beyond": { "type": "Depth", "view": "far" }
  },
  "outputs": { "depth": { "field": "deep" }, "beyond": { "field": "beyond" } }
}"#;

fn opened(text: &str) -> Window {
    let mut window = unseen(Session::new(text.into(), None));
    act(&mut window, Action::Panel(Pane::Waves));
    window
}

/// Draws until something with this in its label is there.
fn awaited(window: &mut Window, label: &str) {
    let started = Instant::now();
    while window.query_all_by_label_contains(label).next().is_none() {
        assert!(started.elapsed() < Duration::from_secs(60), "waited in vain for {label}");
        std::thread::sleep(Duration::from_millis(2));
        window.step();
    }
}

fn value(window: &Window, path: &Path) -> Option<Value> {
    editor(window).state().sheet().get(path).cloned()
}

#[test]
fn a_sea_shows_its_waves() {
    let text = WAVE.replace("\"count\": 0", "\"count\": 40, \"sharpness\": 3");
    let mut window = opened(&text);
    awaited(&mut window, "Crests fold over");
    awaited(&mut window, "41 waves: amplitude over length");
    let sharpness = Path::node("storm").to("sharpness");
    act(&mut window, Action::Edit(Edit::set(sharpness, &json!(0.1))));
    awaited(&mut window, "Crests do not fold over");
}

#[test]
fn the_profile_follows_the_frame_and_marks_what_is_turned_over() {
    let mut window = opened(WAVE);
    awaited(&mut window, "Profile, heights from -1.50 to 1.50 m");
    assert!(window.query_by_label_contains("turned over").is_none());
    act(&mut window, Action::Frame(5));
    awaited(&mut window, "Profile, heights from -2.25 to 2.25 m");
    act(&mut window, Action::Frame(9));
    awaited(&mut window, "Profile, heights from -3.00 to 3.00 m");
    awaited(&mut window, "The marked part is turned over");
    // An edit of anything changes the plots before any picture is made.
    let amplitude = Path::node("storm").to("waves").to(0).to("amplitude");
    act(&mut window, Action::Edit(Edit::set(amplitude, &json!(0.5))));
    awaited(&mut window, "Profile, heights from -0.50 to 0.50 m");
    window.get_by_label("1 wave: amplitude over length");
}

#[test]
fn the_axes_can_have_one_scale() {
    let mut window = opened(WAVE);
    awaited(&mut window, "Heights are drawn");
    window.get_by_label("Equal axes").click();
    window.run_steps(3);
    assert!(window.query_by_label_contains("Heights are drawn").is_none());
    let text = editor(&window).state().session.text();
    assert_eq!(text, WAVE, "what the panel shows is no part of the document");
}

#[test]
fn the_spread_and_the_dispersion_can_be_set() {
    let mut window = opened(WAVE);
    for label in ["spread", "sharpness", "direction spread", "convention"] {
        let name = window.get_all_by_label(label).map(|node| node.rect()).min_by(|a, b| a.left().total_cmp(&b.left()));
        let name = name.unwrap_or_else(|| panic!("{label}"));
        // The value stands behind its name, as in the properties.
        let roles = [Role::Slider, Role::ComboBox].into_iter();
        let values = roles.flat_map(|role| window.query_all_by_role(role).map(|node| node.rect()).collect::<Vec<_>>());
        let mut own =
            values.filter(|rect| rect.y_range().contains(name.center().y) && rect.left() < name.left() + 400.0);
        assert!(own.any(|rect| rect.left() > name.right()), "{label} at {name:?}");
    }
    // A speed counts only where it is chosen.
    assert!(window.query_all_by_label("speed").next().is_none());
    window.get_by_role_and_label(Role::ComboBox, "dispersion").click();
    window.run_steps(3);
    window.get_by_label("speed").click();
    window.run_steps(3);
    assert_eq!(value(&window, &Path::node("storm").to("dispersion")), Some(json!("speed")));
    assert!(window.query_all_by_label("speed").next().is_some());
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), WAVE, "one step of undo");
}

#[test]
fn waves_are_counted_by_length_amplitude_and_steepness() {
    let mut window = opened(&WAVE.replace("\"count\": 0", "\"count\": 300"));
    // What comes above a button moves it.
    awaited(&mut window, "Profile, heights");
    awaited(&mut window, "The curve is the log-normal one");
    window.get_by_label("Steepness").click();
    window.run_steps(3);
    assert!(window.query_by_label_contains("The curve is the log-normal one").is_none());
    window.get_by_label("Lengths").click();
    window.run_steps(3);
    window.get_by_label_contains("The curve is the log-normal one");
}

#[test]
fn a_sea_within_a_group_is_shown_and_changed_inside() {
    let mut window = opened(GROUPED);
    act(&mut window, Action::Select(["near".to_string()].into()));
    awaited(&mut window, "This sea is inside of front, a group.");
    window.get_by_label("front/sea");
    awaited(&mut window, "20 waves: amplitude over length");
    window.get_by_label("2.00 m");
    window.get_by_label("Enter").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().scope, ["front"]);
    window.get_by_label_contains("height is linked, now 2.00 m");
    let before = editor(&window).state().session.text().to_string();
    act(&mut window, Action::Edit(Edit::set(Path::node("sea").to("spread"), &json!(0.1))));
    let text = editor(&window).state().session.text().to_string();
    assert_ne!(text, before);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["groups"]["Bay"]["nodes"]["sea"]["spread"], json!(0.1));
    // Another sea of the document.
    act(&mut window, Action::Enter(Vec::new()));
    act(&mut window, Action::Select(["back".to_string()].into()));
    awaited(&mut window, "This sea is inside of back, a group.");
}

#[test]
fn a_toon_sea_says_what_it_reaches() {
    let mut window = opened(GROUPED);
    act(&mut window, Action::Select(["toon".to_string()].into()));
    awaited(&mut window, "over all frames.");
    awaited(&mut window, "Profile, heights from");
    window.get_by_role_and_label(Role::ComboBox, "mode");
}

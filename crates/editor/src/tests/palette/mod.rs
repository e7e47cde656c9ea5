//! The palette panel: changes to colors, pictures painted while one drags, and palettes that are compared.

mod dragging;
mod edits;

use crate::actions::{Action, Pane};
use crate::document::swatches::{Swatch, SwatchKey};
use crate::document::{Path, Session, palette};
use crate::editor::Editor;
use crate::evaluate::Screen;
use crate::testing::{Window, act, editor, finished, until, window};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use serde_json::{Value, json};
use std::sync::Arc;

/// A picture of four named colors, of which one is keyed and one unused, and of one without a name.
pub(super) const PAINTED: &str = r##"{
  "trochoid": 1,
  "format": { "width": 96, "height": 54, "samples": 4 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 8, "fps": 24 },
  "palette": {
    "night": "#101a33",
    "foam": "#f2ead2",
    "glow": { "keys": [[1, "#d8513a"], [5, "#3a51d8"]] },
    "spare": "#123456"
  },
  "nodes": {
    "across": { "type": "ScreenX" },
    "down": { "type": "ScreenY" },
    "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "across" },
    "lit": { "type": "Mix", "a": "sea", "b": "palette.glow", "weight": 0.25 },
    "hazy": { "type": "Mix", "a": "lit", "b": "#808080", "weight": "down" },
    "lower": { "type": "Mix", "a": "hazy", "b": "palette.night", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "lower", "file": "painted.####.png" } }
}
"##;

/// Opens a document with the panel in front, and waits for its picture.
fn shown(text: &str) -> Window {
    let mut window = window(Session::new(text.into(), None), None);
    act(&mut window, Action::Panel(Pane::Palette));
    finished(&mut window);
    window.run_steps(2);
    window
}

/// Does the same, and waits for the recipe.
fn weighed(text: &str) -> Window {
    let mut window = shown(text);
    wait_for_recipe(&mut window);
    window
}

fn wait_for_recipe(window: &mut Window) {
    until(window, "the recipe", |editor| editor.state().evaluated.mixture.is_some());
    window.run_steps(2);
}

fn named(name: &str) -> SwatchKey {
    SwatchKey::Named(name.into())
}

fn text(window: &Window) -> String {
    editor(window).state().session.text().into()
}

fn value(window: &Window, path: &Path) -> Value {
    editor(window).state().sheet().get(path).cloned().unwrap_or_default()
}

fn undoes(window: &Window) -> Option<String> {
    editor(window).state().session.history().undoes().map(String::from)
}

/// Returns whether the picture shown is one that was painted.
fn painted(editor: &Editor) -> Option<Arc<Screen>> {
    editor.state().evaluated.painted.as_ref().map(|result| result.screen.clone())
}

fn pointer(window: &mut Window, at: Pos2, pressed: Option<bool>) {
    window.event(Event::PointerMoved(at));
    if let Some(pressed) = pressed {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    window.run_steps(2);
}

/// Presses the pointer on a widget and moves it, without releasing it; returns the place.
fn drag(window: &mut Window, label: &str, by: Vec2) -> Pos2 {
    let start = window.get_by_label(label).rect().center();
    pointer(window, start, Some(true));
    for step in 1..=4 {
        pointer(window, start + by * (step as f32 / 4.0), None);
    }
    start + by
}

/// Returns the largest difference of a byte of two pictures.
fn apart(a: &Screen, b: &Screen) -> u8 {
    assert_eq!(a.size, b.size);
    a.pixels.iter().zip(&b.pixels).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

fn screen(window: &Window) -> Arc<Screen> {
    editor(window).state().evaluated.result.as_ref().unwrap().screen.clone()
}

#[test]
fn all_colors_are_listed_with_uses_and_shares() {
    let mut window = weighed(PAINTED);
    for label in ["Color night", "Color foam", "Color glow", "Color spare", "Color #808080"] {
        window.get_by_label(label);
    }
    window.get_by_label("4 colors with names, 1 without");
    let state = editor(&window).state();
    let mixture = state.evaluated.mixture.clone().unwrap();
    let all = state.swatches();
    let uses: Vec<usize> = all.iter().map(|swatch| swatch.uses.len()).collect();
    assert_eq!(uses, [2, 1, 1, 0, 1]);
    let shares: Vec<Option<f64>> = all.iter().map(|swatch| mixture.share(&swatch.controls())).collect();
    let sum: f64 = shares.iter().flatten().sum();
    assert!((sum - 1.0).abs() < 1e-6, "{shares:?}");
    assert_eq!(shares[3], None, "the picture has nothing of it");
    assert!((shares[4].unwrap() - 0.25).abs() < 1e-2 && shares[0] > shares[1], "{shares:?}");
    assert_eq!(all[2].color, crate::document::color::rgb("#d8513a"), "the color at the first frame");
    act(&mut window, Action::Frame(5));
    assert_eq!(editor(&window).state().swatches()[2].color, crate::document::color::rgb("#3a51d8"));
    assert_eq!(undoes(&window), None);
}

#[test]
fn a_pixel_says_which_colors_it_is_mixed_from() {
    let mut window = weighed(PAINTED);
    act(&mut window, Action::Pick(Some([0.25, 0.75])));
    finished(&mut window);
    window.run_steps(3);
    let state = editor(&window).state();
    let mixture = state.evaluated.mixture.clone().unwrap();
    let known = mixture.weights(Some([24, 40]));
    let weight = |swatch: &Swatch| -> f64 {
        swatch.controls().iter().filter_map(|name| known.get(name.as_str())).map(|weights| weights[1]).sum()
    };
    let weights: Vec<f64> = state.swatches().iter().map(weight).collect();
    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{weights:?}");
    assert!(weights[0] > 0.5 && weights[3] == 0.0, "{weights:?}");
    let result = state.evaluated.result.as_ref().unwrap();
    let colors: Vec<f64> =
        state.swatches().iter().zip(&weights).map(|(s, w)| f64::from(s.color.unwrap()[0]) * w).collect();
    let red = f64::from(result.picture.planes[0].nearest(24, 40));
    assert!((colors.iter().sum::<f64>() - red).abs() < 2e-3);
    // The pixel under the pointer comes before the inspected one.
    let at = window.get_by_label("Picture").rect().center();
    pointer(&mut window, at, None);
    assert!(editor(&window).state().colors.hover.is_some());
    let outside = window.get_by_label("Color night").rect().center();
    pointer(&mut window, outside, None);
    assert_eq!(editor(&window).state().colors.hover, None);
}

#[test]
fn the_viewer_shows_where_a_color_is() {
    let mut window = weighed(PAINTED);
    let old = screen(&window);
    act(&mut window, Action::Swatch(Some(named("foam"))));
    window.run_steps(2);
    window.get_by_label("Show where").click();
    until(&mut window, "the painting", Editor::is_painted);
    let spot = painted(editor(&window)).unwrap();
    let red = |screen: &Screen, x: usize| f32::from(screen.pixels[4 * (10 * 96 + x)]);
    assert!(red(&spot, 4) < 0.3 * red(&old, 4), "there is none of it at the left");
    assert!(red(&spot, 90) / red(&old, 90) > red(&spot, 40) / red(&old, 40), "there is most of it at the right");
    window.get_by_label("Show where").click();
    window.run_steps(3);
    assert!(painted(editor(&window)).is_none());
    assert_eq!(undoes(&window), None);
    window.get_by_label("Select nodes").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().selection, ["sea".to_string()].into());
}

#[test]
fn a_literal_in_the_properties_is_picked_like_a_color_of_the_palette() {
    let mut window = weighed(PAINTED);
    let before = text(&window);
    act(&mut window, Action::Panel(Pane::Properties));
    act(&mut window, Action::Select(["hazy".to_string()].into()));
    window.get_by_label("Swatch of hazy.b").click();
    window.run_steps(3);
    wait_for_recipe(&mut window);
    let end = drag(&mut window, "Lightness", vec2(30.0, 0.0));
    until(&mut window, "the painting", Editor::is_painted);
    assert_eq!(text(&window), before);
    pointer(&mut window, end, Some(false));
    assert_ne!(value(&window, &Path::node("hazy").to("b")), json!("#808080"));
    act(&mut window, Action::Undo);
    assert_eq!((text(&window), undoes(&window)), (before, None));
}

#[test]
fn a_named_color_in_the_properties_leads_to_the_palette() {
    let mut window = shown(PAINTED);
    act(&mut window, Action::Panel(Pane::Properties));
    act(&mut window, Action::Select(["sea".to_string()].into()));
    window.get_by_label("Swatch of sea.b").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().colors.chosen, Some(named("foam")));
    window.get_by_label("Color foam");
    assert_eq!(undoes(&window), None);
}

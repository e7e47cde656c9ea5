//! The palette panel: changes to colors, pictures painted while one drags, and palettes that are compared.

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
fn the_whole_picture_follows_a_dragged_color_and_the_document_changes_once_on_release() {
    let mut window = weighed(PAINTED);
    let before = text(&window);
    let old = screen(&window);
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    until(&mut window, "the painting", Editor::is_painted);
    window.run_steps(3);
    assert_eq!(text(&window), before, "nothing is written while one drags");
    assert_eq!(undoes(&window), None);
    let last = painted(editor(&window)).unwrap();
    assert!(apart(&last, &old) > 20);
    pointer(&mut window, end, Some(false));
    assert_ne!(text(&window), before);
    assert_eq!(undoes(&window).as_deref(), Some("Set night"));
    finished(&mut window);
    window.run_steps(3);
    assert!(painted(editor(&window)).is_none());
    let off = apart(&last, &screen(&window));
    assert!(off <= 1, "{off} of 255 from the evaluated picture");
    // The recipe stays good: the next drag needs no other one.
    wait_for_recipe(&mut window);
    let recipe = |window: &Window| editor(window).state().evaluated.mixture.clone().unwrap().recipe.clone();
    let known = recipe(&window);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before, "one step of undo");
    finished(&mut window);
    wait_for_recipe(&mut window);
    assert!(Arc::ptr_eq(&known, &recipe(&window)));
}

#[test]
fn escape_puts_a_dragged_color_back() {
    for is_weighed in [true, false] {
        let mut window = if is_weighed { weighed(PAINTED) } else { shown(PAINTED) };
        if !is_weighed {
            // Nothing that is viewed has a recipe.
            act(&mut window, Action::Look("down".into(), 0));
            finished(&mut window);
            until(&mut window, "the reason", |editor| editor.state().evaluated.unmixed.is_some());
            window.run_steps(2);
        }
        let before = text(&window);
        let end = drag(&mut window, "Swatch foam", vec2(30.0, 40.0));
        assert_eq!(text(&window) == before, is_weighed, "without a recipe, the document is changed");
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert_eq!(text(&window), before);
        pointer(&mut window, end + vec2(20.0, 20.0), None);
        pointer(&mut window, end, Some(false));
        window.run_steps(3);
        assert_eq!(text(&window), before);
        assert_eq!(undoes(&window), None);
        assert!(painted(editor(&window)).is_none());
        assert!(editor(&window).state().colors.tint.is_none());
        // The next drag is a drag again.
        let end = drag(&mut window, "Swatch foam", vec2(30.0, 40.0));
        pointer(&mut window, end, Some(false));
        window.run_steps(3);
        assert_ne!(text(&window), before);
    }
}

#[test]
fn a_drag_that_ends_while_its_panel_is_hidden_is_cancelled() {
    let mut window = weighed(PAINTED);
    let before = text(&window);
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    assert!(editor(&window).state().colors.tint.is_some());
    act(&mut window, Action::Panel(Pane::Report));
    pointer(&mut window, end, Some(false));
    window.run_steps(3);
    assert!(editor(&window).state().colors.tint.is_none() && painted(editor(&window)).is_none());
    assert_eq!((text(&window), undoes(&window)), (before, None));
}

#[test]
fn without_a_recipe_a_drag_is_one_step_of_undo() {
    let mut window = shown(PAINTED);
    act(&mut window, Action::Look("down".into(), 0));
    finished(&mut window);
    until(&mut window, "the reason", |editor| editor.state().evaluated.unmixed.is_some());
    window.run_steps(2);
    let before = text(&window);
    let end = drag(&mut window, "Swatch foam", vec2(30.0, 40.0));
    pointer(&mut window, end, Some(false));
    assert_ne!(text(&window), before);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before);
    assert_eq!(undoes(&window), None);
}

#[test]
fn a_color_without_a_name_is_dragged_with_and_without_a_recipe() {
    for looked in ["lower", "down"] {
        let mut window = shown(PAINTED);
        act(&mut window, Action::Look(looked.into(), 0));
        finished(&mut window);
        until(&mut window, "what is known", |editor| {
            let seen = &editor.state().evaluated;
            seen.unmixed.is_some() || seen.mixture.is_some()
        });
        window.run_steps(2);
        let before = text(&window);
        window.get_by_label("Color #808080").click();
        window.run_steps(3);
        let end = drag(&mut window, "Lightness", vec2(40.0, 0.0));
        pointer(&mut window, end, Some(false));
        let color = value(&window, &Path::node("hazy").to("b"));
        let color = crate::document::color::rgb(color.as_str().unwrap()).unwrap();
        let rect = window.get_by_label("Lightness").rect();
        let expected = f64::from((end.x - rect.left()) / rect.width());
        let found = trochoid::oklch(color.map(f64::from))[0];
        assert!((found - expected).abs() < 0.02, "{looked}: {found} where the track was left, {expected}");
        act(&mut window, Action::Undo);
        assert_eq!((text(&window), undoes(&window)), (before, None), "{looked}");
    }
}

#[test]
fn a_click_selects_and_writes_nothing() {
    let mut window = weighed(PAINTED);
    let before = text(&window);
    window.get_by_label("Swatch foam").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().colors.chosen, Some(named("foam")));
    // A click on the track where the color is does not change it either, but for rounding.
    window.get_by_label("Color foam").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().colors.chosen, None);
    assert_eq!((text(&window), undoes(&window)), (before, None));
}

#[test]
fn tracks_pick_lightness_chroma_and_hue() {
    let mut window = weighed(PAINTED);
    act(&mut window, Action::Swatch(Some(named("foam"))));
    window.run_steps(3);
    let of = |window: &Window| {
        let color = editor(window).state().swatches()[1].color.unwrap();
        trochoid::oklch(color.map(f64::from))
    };
    let before = of(&window);
    let end = drag(&mut window, "Lightness", vec2(-10.0, 0.0));
    until(&mut window, "the painting", Editor::is_painted);
    pointer(&mut window, end, Some(false));
    let after = of(&window);
    assert!(after[0] < before[0] - 0.2, "{before:?} {after:?}");
    assert!((after[2] - before[2]).abs() < 3.0, "{before:?} {after:?}");
    // No display shows so much chroma; that is said.
    let rect = window.get_by_label("Chroma").rect();
    pointer(&mut window, rect.right_center() - vec2(3.0, 0.0), Some(true));
    assert!(window.query_all_by_label_contains("A display shows chroma up to").next().is_some());
    pointer(&mut window, rect.right_center() - vec2(3.0, 0.0), Some(false));
    assert!(of(&window)[1] > after[1]);
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(undoes(&window), None, "two gestures, two steps");
}

/// Types a text into a field and presses Enter.
fn enter(window: &mut Window, written: &str, typed: &str) {
    let field = window.get_all_by_value(written).next().unwrap();
    field.focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    window.event(Event::Text(typed.into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn a_color_is_renamed_with_all_its_uses() {
    let mut window = shown(PAINTED);
    let before = text(&window);
    act(&mut window, Action::Swatch(Some(named("night"))));
    window.run_steps(2);
    enter(&mut window, "night", "foam");
    assert_eq!(text(&window), before, "a name that is taken is refused");
    assert!(window.query_all_by_label_contains("a color with this name already exists").next().is_some());
    window.key_press(Key::Escape);
    window.run_steps(3);
    act(&mut window, Action::Swatch(None));
    act(&mut window, Action::Swatch(Some(named("night"))));
    enter(&mut window, "night", "deep_1");
    assert_eq!(value(&window, &Path::node("sea").to("a")), json!("palette.deep_1"));
    assert_eq!(value(&window, &Path::node("lower").to("b")), json!("palette.deep_1"));
    assert!(editor(&window).state().session.meaning().errors().next().is_none());
    assert_eq!(editor(&window).state().colors.chosen, Some(named("deep_1")));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before);
}

#[test]
fn colors_are_merged_deleted_added_and_named_each_in_one_step() {
    let mut window = shown(PAINTED);
    let mut steps = vec![text(&window)];
    let swatch = |window: &Window, key: &SwatchKey| {
        let all = editor(window).state().swatches();
        all.into_iter().find(|swatch| swatch.key == *key).unwrap()
    };
    let night = swatch(&window, &named("night"));
    act(&mut window, Action::Edit(palette::merged(&night, "foam")));
    act(&mut window, Action::Seal);
    assert_eq!(value(&window, &Path::node("lower").to("b")), json!("palette.foam"));
    steps.push(text(&window));
    act(&mut window, Action::Swatch(Some(named("spare"))));
    window.get_by_label("Delete").click();
    window.run_steps(3);
    steps.push(text(&window));
    act(&mut window, Action::AddColor);
    assert_eq!(value(&window, &Path::default().to("palette").to("color")), json!("#808080"));
    steps.push(text(&window));
    act(&mut window, Action::NameColors);
    assert_eq!(value(&window, &Path::node("hazy").to("b")), json!("palette.hazy_b"));
    steps.push(text(&window));
    let names: Vec<String> = editor(&window).state().swatches().iter().map(|swatch| swatch.called()).collect();
    assert_eq!(names, ["foam", "glow", "color", "hazy_b"]);
    assert!(editor(&window).state().session.meaning().errors().next().is_none());
    while let Some(after) = steps.pop() {
        assert_eq!(text(&window), after);
        act(&mut window, Action::Undo);
    }
    assert_eq!(undoes(&window), None);
}

#[test]
fn all_colors_of_a_document_without_a_palette_get_names() {
    let text_without = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [ { "at": 0, "color": "#2D3F52" }, { "at": 1, "color": "#f0cf8e" } ] },
    "ink": { "type": "Constant", "color": [0.25, 0.5, 1.5] },
    "sea": { "type": "Mix", "a": "sky", "b": "#2d3f52", "weight": 0.5 },
    "all": { "type": "Mix", "a": "sea", "b": "ink", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "all" } }
}"##;
    let mut window = shown(text_without);
    let old = screen(&window);
    act(&mut window, Action::NameColors);
    finished(&mut window);
    let names: Vec<String> = editor(&window).state().swatches().iter().map(|swatch| swatch.called()).collect();
    assert_eq!(names, ["sky_stops_0", "sky_stops_1", "ink"], "equal colors have one name");
    assert!(editor(&window).state().session.meaning().diagnostics.is_empty());
    assert_eq!(apart(&old, &screen(&window)), 0, "the picture stays the same");
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), text_without);
}

#[test]
fn a_change_to_a_keyed_color_is_to_the_key_at_the_frame() {
    let mut window = weighed(PAINTED);
    let keys = |window: &Window| value(window, &Path::default().to("palette").to("glow").to("keys"));
    act(&mut window, Action::Swatch(Some(named("glow"))));
    window.get_by_label_contains("Keyed (2 keys): a change is to the key at frame 1");
    let end = drag(&mut window, "Swatch glow", vec2(0.0, -30.0));
    pointer(&mut window, end, Some(false));
    assert_eq!((keys(&window)[1].clone(), keys(&window).as_array().unwrap().len()), (json!([5, "#3a51d8"]), 2));
    assert_ne!(keys(&window)[0][1], json!("#d8513a"));
    act(&mut window, Action::Frame(3));
    finished(&mut window);
    window.run_steps(2);
    window.get_by_label_contains("a change adds a key at frame 3");
    wait_for_recipe(&mut window);
    let end = drag(&mut window, "Swatch glow", vec2(0.0, -30.0));
    until(&mut window, "the painting", Editor::is_painted);
    let last = painted(editor(&window)).unwrap();
    pointer(&mut window, end, Some(false));
    assert_eq!(keys(&window)[1][0], json!(3));
    finished(&mut window);
    assert!(apart(&last, &screen(&window)) <= 1);
}

#[test]
fn a_palette_in_a_file_is_brought_into_the_document_before_it_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("night.json"),
        r##"{ "night": "#101a33", "foam": "#f2ead2", "glow": "#d8513a" }"##,
    )
    .unwrap();
    let start = PAINTED.find("\"palette\": {").unwrap();
    let end = PAINTED.find("\"nodes\"").unwrap();
    let filed = format!("{}\"palette\": \"night.json\",\n  {}", &PAINTED[..start], &PAINTED[end..]);
    let file = folder.path().join("painted.json");
    std::fs::write(&file, &filed).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Panel(Pane::Palette));
    finished(&mut window);
    wait_for_recipe(&mut window);
    window.get_by_label("The named colors are in night.json.");
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    pointer(&mut window, end, Some(false));
    assert!(window.query_all_by_label_contains("night is a color of night.json").next().is_some());
    act(&mut window, Action::AddColor);
    act(&mut window, Action::NameColors);
    assert_eq!((text(&window), undoes(&window)), (filed.clone(), None));
    let old = screen(&window);
    window.get_by_label("Bring into document").click();
    window.run_steps(3);
    finished(&mut window);
    assert_eq!(value(&window, &Path::default().to("palette").to("foam")), json!("#f2ead2"));
    assert_eq!(apart(&old, &screen(&window)), 0);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), filed);
}

#[test]
fn a_palette_that_is_missing_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let start = PAINTED.find("\"palette\": {").unwrap();
    let end = PAINTED.find("\"nodes\"").unwrap();
    let file = folder.path().join("painted.json");
    std::fs::write(&file, format!("{}\"palette\": \"gone.gpl\",\n  {}", &PAINTED[..start], &PAINTED[end..])).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Panel(Pane::Palette));
    until(&mut window, "the reason", |editor| editor.state().evaluated.unmixed.is_some());
    window.run_steps(2);
    assert!(!editor(&window).state().evaluated.mixing);
    window.get_by_label("no shares");
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
fn images_stay_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let image = image::RgbImage::from_fn(96, 54, |x, y| image::Rgb([2 * x as u8, 4 * y as u8, 90]));
    image.save(folder.path().join("paint.png")).unwrap();
    let with_image = PAINTED.replace(r##""a": "hazy""##, r##""a": "print""##).replace(
        r##""lower""##,
        r##""paint": { "type": "Read", "file": "paint.png", "as": "color" },
    "print": { "type": "Mix", "a": "hazy", "b": "paint", "weight": 0.5 },
    "lower""##,
    );
    let with_image = with_image.replacen(r##""color": "paint""##, r##""color": "lower""##, 1);
    let at = with_image.rfind("\"outputs\"").unwrap();
    let with_image = format!("{}\"outputs\": {{ \"beauty\": {{ \"color\": \"lower\" }} }}\n}}\n", &with_image[..at]);
    let file = folder.path().join("printed.json");
    std::fs::write(&file, &with_image).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Panel(Pane::Palette));
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    wait_for_recipe(&mut window);
    let mixture = editor(&window).state().evaluated.mixture.clone().unwrap();
    assert!(mixture.recipe.info().has_images);
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    until(&mut window, "the painting", Editor::is_painted);
    let last = painted(editor(&window)).unwrap();
    pointer(&mut window, end, Some(false));
    finished(&mut window);
    assert!(apart(&last, &screen(&window)) <= 1);
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
fn a_color_is_added_from_the_picture() {
    let mut window = shown(PAINTED);
    let before = text(&window);
    window.get_by_label("Add").click();
    window.run_steps(3);
    window.get_by_label("From a picture …").click();
    window.run_steps(3);
    let at = window.get_by_label("Picture").rect().center();
    pointer(&mut window, at, Some(true));
    pointer(&mut window, at, Some(false));
    let result = screen(&window);
    let added = value(&window, &Path::default().to("palette").to("color"));
    let [r, g, b] = crate::document::color::rgb(added.as_str().unwrap()).unwrap().map(|v| (255.0 * v).round() as u8);
    assert!(result.pixels.chunks_exact(4).any(|pixel| pixel[..3] == [r, g, b]), "{added} is in the picture");
    act(&mut window, Action::Undo);
    assert_eq!((text(&window), undoes(&window)), (before, None));
}

#[test]
fn a_palette_elsewhere_is_read_once_its_folder_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("scene")).unwrap();
    let colors = r##"{ "night": "#101a33", "foam": "#f2ead2", "glow": "#d8513a" }"##;
    std::fs::write(folder.path().join("night.json"), colors).unwrap();
    let (start, end) = (PAINTED.find("\"palette\": {").unwrap(), PAINTED.find("\"nodes\"").unwrap());
    let filed = format!("{}\"palette\": \"../night.json\",\n  {}", &PAINTED[..start], &PAINTED[end..]);
    let file = folder.path().join("scene/painted.json");
    std::fs::write(&file, &filed).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Panel(Pane::Palette));
    finished(&mut window);
    window.run_steps(2);
    assert!(editor(&window).state().evaluated.failed.is_some());
    window.get_by_label_contains("Allow reading").click();
    window.run_steps(3);
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    wait_for_recipe(&mut window);
    assert_eq!(editor(&window).state().swatches().len(), 4);
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

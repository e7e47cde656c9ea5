//! Colors that one drags, and what is painted meanwhile.

use super::*;
use std::time::Duration;

/// Opens a document and views a mask, which has no recipe.
fn without_recipe() -> Window {
    let mut window = shown(PAINTED);
    act(&mut window, Action::Look("down".into(), 0));
    finished(&mut window);
    until(&mut window, "the reason", |editor| editor.state().evaluated.unmixed.is_some());
    window.run_steps(2);
    window
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
    assert_eq!(editor(&window).state().colors.chosen, Some(named("night")), "its tracks show the dragged color");
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
fn undo_and_redo_of_a_color_are_painted_while_the_picture_is_evaluated() {
    let mut window = weighed(PAINTED);
    let old = screen(&window);
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    pointer(&mut window, end, Some(false));
    finished(&mut window);
    wait_for_recipe(&mut window);
    let new = screen(&window);
    assert!(apart(&old, &new) > 20);
    editor(&window).worker.slow_down(Duration::from_secs(600));
    for (action, wanted) in [(Action::Undo, &old), (Action::Redo, &new), (Action::Undo, &old)] {
        act(&mut window, action);
        let is_wanted = |editor: &Editor| painted(editor).is_some_and(|shown| apart(&shown, wanted) <= 1);
        until(&mut window, "the painting", is_wanted);
        assert!(editor(&window).state().evaluated.progress.is_some(), "the picture takes longer");
    }
}

#[test]
fn what_changes_no_weight_keeps_the_recipe() {
    let mut window = weighed(PAINTED);
    let mixture = |window: &Window| editor(window).state().evaluated.mixture.clone().unwrap();
    let known = mixture(&window);
    let night = known.share(&["night".into()]).unwrap();
    editor(&window).worker.slow_down(Duration::from_secs(600));
    let swatch = || editor(&window).state().swatches().into_iter().find(|own| own.key == named("night")).unwrap();
    let renamed = crate::document::palette::renamed(&swatch(), "dusk");
    for action in [Action::Edit(renamed), Action::AddColor] {
        act(&mut window, action);
        wait_for_recipe(&mut window);
        let now = mixture(&window);
        assert!(Arc::ptr_eq(&known.recipe, &now.recipe));
        assert_ne!(known.generation, now.generation);
        assert_eq!(now.share(&["dusk".into()]), Some(night));
        assert_eq!(now.share(&["night".into()]), None);
        assert_eq!(now.colors, known.colors);
        assert!(editor(&window).state().evaluated.progress.is_some(), "the picture takes longer");
    }
}

#[test]
fn what_was_painted_stays_until_it_is_known_what_can_be() {
    let mut window = weighed(PAINTED);
    let end = drag(&mut window, "Swatch night", vec2(40.0, -60.0));
    editor(&window).worker.slow_down(Duration::from_secs(600));
    pointer(&mut window, end, Some(false));
    // One change right after another: no frame shows what the first one has made.
    for action in [Action::Undo, Action::Redo, Action::Undo, Action::Redo] {
        let before = painted(editor(&window));
        assert!(before.is_some());
        act(&mut window, action);
        assert!(painted(editor(&window)).is_some());
    }
}

#[test]
fn escape_puts_a_dragged_color_back() {
    for is_weighed in [true, false] {
        let mut window = if is_weighed { weighed(PAINTED) } else { without_recipe() };
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
    let mut window = without_recipe();
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

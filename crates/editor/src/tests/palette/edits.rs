//! Changes to the palette of a document.

use super::*;

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
    assert!(editor(&window).state().evaluated.mixing.is_none());
    window.get_by_label("no shares");
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

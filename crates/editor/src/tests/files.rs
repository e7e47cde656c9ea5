use super::{DUSK, dusk};
use crate::actions::Action;
use crate::document::{Session, edit};
use crate::testing::{Window, act, editor, finished, until, window};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

fn moved(x: f32) -> Action {
    Action::Edit(edit::moved(&[("sky".into(), [x, 0.0])]))
}

#[test]
fn a_document_is_saved_and_the_mark_goes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), Some(folder.path().join("data")));
    assert_eq!(editor(&window).title(), "dusk.json — Trochoid");
    act(&mut window, moved(7.0));
    assert_eq!(editor(&window).title(), "• dusk.json — Trochoid");
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    assert_eq!(editor(&window).title(), "dusk.json — Trochoid");
    let saved = std::fs::read_to_string(&file).unwrap();
    assert!(saved.contains("\"sky\": [7, 0]"), "{saved}");
    assert_eq!(
        saved.replace(",\n  \"ui\": { \"positions\": { \"sky\": [7, 0] } }", ""),
        DUSK,
        "all else stays as it was"
    );
}

#[test]
fn unsaved_work_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, moved(3.0));
    act(&mut window, Action::Quit);
    window.get_by_label("Save changes?");
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert!(!editor(&window).is_closing());
    assert!(window.query_by_label("Save changes?").is_none());
    act(&mut window, Action::Quit);
    window.get_by_label("Save").click();
    window.run_steps(3);
    assert!(editor(&window).is_closing());
    assert!(std::fs::read_to_string(&file).unwrap().contains("[3, 0]"));
    let mut window = crate::testing::window(Session::open(&file).unwrap(), None);
    act(&mut window, moved(4.0));
    act(&mut window, Action::New);
    window.get_by_label("Discard").click();
    window.run_steps(3);
    assert_eq!(editor(&window).title(), "untitled — Trochoid");
    assert!(std::fs::read_to_string(&file).unwrap().contains("[3, 0]"), "discarded is not saved");
}

#[test]
fn a_change_by_another_program_is_noticed_once_and_can_be_undone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Save);
    window.run_steps(20);
    assert!(window.query_by_label("The file has changed").is_none(), "the editor does not report its own save");
    let other = DUSK.replace("0.25", "0.75");
    std::fs::write(&file, &other).unwrap();
    until(&mut window, "the question", |editor| editor.prompts.is_open());
    window.run_steps(2);
    window.get_by_label("Reload").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.text(), other);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

/// Writes a copy of unsaved work into the data folder, of a document or of none; returns its path.
fn kept(folder: &std::path::Path, number: usize, file: Option<&std::path::Path>, text: &str) -> std::path::PathBuf {
    let unsaved = folder.join("data").join("unsaved");
    std::fs::create_dir_all(&unsaved).unwrap();
    let copy = serde_json::json!({ "file": file, "text": text }).to_string();
    let path = unsaved.join(format!("1-{number}.json"));
    std::fs::write(&path, copy).unwrap();
    path
}

#[test]
fn work_of_an_editor_that_ended_is_offered() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let lost = DUSK.replace("0.25", "0.5");
    let copy = kept(folder.path(), 0, Some(&file), &lost);
    let mut window = window(Session::open(&file).unwrap(), Some(folder.path().join("data")));
    window.get_by_label("Recover unsaved work?");
    window.get_by_label("Recover").click();
    window.run_steps(3);
    let state = editor(&window).state();
    assert_eq!(state.session.text(), lost);
    assert_eq!(state.session.file(), Some(file.as_path()));
    assert!(state.session.is_changed());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), DUSK, "nothing is written before it is saved");
    until(&mut window, "another copy takes the place of that one", |_| !copy.exists());
    assert_eq!(std::fs::read_dir(copy.parent().unwrap()).unwrap().count(), 2, "a copy and its lock");
}

#[test]
fn unsaved_work_is_offered_for_its_own_document_alone() {
    let folder = tempfile::tempdir().unwrap();
    let data = Some(folder.path().join("data"));
    let [one, two] = ["one", "two"].map(|name| folder.path().join(format!("{name}.json")));
    std::fs::write(&one, DUSK).unwrap();
    std::fs::write(&two, DUSK).unwrap();
    let asks = |window: &Window| window.query_by_label("Recover unsaved work?").is_some();
    let copy = kept(folder.path(), 0, Some(&one), &DUSK.replace("0.25", "0.5"));
    let mut first = window(Session::open(&two).unwrap(), data.clone());
    assert!(!asks(&first), "another was opened");
    // It is offered when its document is opened, by whatever path.
    act(&mut first, Action::OpenFile(folder.path().join("data/../one.json")));
    assert!(asks(&first));
    drop(first);
    let bare = window(dusk(), data.clone());
    assert!(!asks(&bare));
    assert_eq!(editor(&bare).notices.texts().len(), 1, "a notice names its document");
    drop(bare);
    std::fs::remove_file(copy).unwrap();
    // Work that was never saved belongs to no document.
    kept(folder.path(), 1, None, DUSK);
    assert!(!asks(&window(Session::open(&one).unwrap(), data.clone())));
    assert!(asks(&window(dusk(), data)));
}

#[test]
fn recent_documents_are_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let (data, one, two) = (folder.path().join("data"), folder.path().join("one.json"), folder.path().join("two.json"));
    std::fs::write(&one, DUSK).unwrap();
    std::fs::write(&two, DUSK).unwrap();
    drop(window(Session::open(&one).unwrap(), Some(data.clone())));
    drop(window(Session::open(&two).unwrap(), Some(data.clone())));
    assert_eq!(crate::recent::read(&data), [two.clone(), one.clone()]);
    assert_eq!(crate::recent::remove(&data, &one), std::slice::from_ref(&two));
    assert_eq!(crate::recent::read(&data), [two]);
}

#[test]
fn the_range_is_rendered_to_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, DUSK).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    act(&mut window, Action::Range(2, 4));
    act(&mut window, Action::Render);
    until(&mut window, "the files", |editor| editor.state().render.is_none());
    let mut names: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".png"))
        .collect();
    names.sort();
    assert_eq!(names, ["dusk.0002.png", "dusk.0003.png", "dusk.0004.png"]);
}

/// Writes a document into a folder of its own, where it reads a picture, and the picture if `picture` is set.
fn reading(folder: &std::path::Path, picture: bool) -> std::path::PathBuf {
    std::fs::create_dir_all(folder).unwrap();
    if picture {
        image::RgbImage::from_pixel(2, 2, image::Rgb([9; 3])).save(folder.join("plate.png")).unwrap();
    }
    let file = folder.join("dusk.json");
    let text = DUSK.replace(
        "{ \"type\": \"ScreenY\" }",
        "{ \"type\": \"Read\", \"as\": \"color\", \"fit\": \"nearest\", \"file\": \"plate.png\" }",
    );
    let text =
        text.replace("\"weight\": \"down\", ", "\"weight\": 0.5, ").replace("\"b\": \"#14262e\"", "\"b\": \"down\"");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_document_saved_elsewhere_shows_the_same_picture_and_says_what_it_rewrote() {
    let folder = tempfile::tempdir().unwrap();
    let (shot, other) = (reading(&folder.path().join("shot"), true), folder.path().join("other"));
    std::fs::create_dir(&other).unwrap();
    let mut window = window(Session::open(&shot).unwrap(), None);
    finished(&mut window);
    let context = window.ctx.clone();
    let file = other.join("copy.json");
    window.state_mut().as_mut().unwrap().save(&file, None, &context);
    window.run_steps(3);
    assert_eq!(editor(&window).notices.texts().len(), 2, "that it is saved, and what was rewritten");
    finished(&mut window);
    // The rewritten paths lead out of the folder of the copy, which needs a permission.
    act(&mut window, Action::Allow(crate::actions::Grant::Read(folder.path().join("shot"))));
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    assert!(editor(&window).state().session.text().contains("\"../shot/plate.png\""));
    assert!(editor(&window).state().session.text().contains("\"../shot/dusk.####.png\""));
    // The editor now watches the new file.
    std::fs::write(&file, DUSK).unwrap();
    until(&mut window, "the question", |editor| editor.prompts.is_open());
}

#[test]
fn copied_nodes_read_the_same_files_in_a_document_of_another_folder() {
    let folder = tempfile::tempdir().unwrap();
    let one = reading(&folder.path().join("one"), true);
    let two = reading(&folder.path().join("two"), false);
    let mut window = window(Session::open(&one).unwrap(), None);
    act(&mut window, Action::Select(["down".to_string()].into()));
    act(&mut window, Action::Copy);
    let sheet = crate::canvas::placed(editor(&window).state().sheet());
    let text = edit::copied(&sheet, &["down".into()]);
    act(&mut window, Action::OpenFile(two));
    act(&mut window, Action::Paste(text, [0.0, 0.0]));
    let sheet = editor(&window).state().sheet().clone();
    assert_eq!(sheet.value["nodes"]["down2"]["file"], "../one/plate.png");
    assert_eq!(sheet.value["nodes"]["down"]["file"], "plate.png");
}

/// Keys are those of the dialog: nothing behind it is deleted.
#[test]
fn a_dialog_keeps_keys_from_the_nodes_behind_it() {
    let text = r#"{ "trochoid": 1, "format": { "width": 4, "height": 4 },
        "nodes": { "plate": { "type": "Read", "file": "", "as": "color" } },
        "outputs": { "beauty": { "color": "plate" } } }"#;
    let mut window = crate::testing::unseen(Session::new(text.into(), None));
    crate::testing::choose(&mut window, "plate");
    window.get_by_label("Choose file").click();
    window.run_steps(4);
    for key in [Key::Delete, Key::D, Key::Backspace] {
        window.key_press(key);
        window.run_steps(2);
    }
    window.key_press_modifiers(Modifiers::COMMAND, Key::X);
    window.run_steps(2);
    assert_eq!(editor(&window).state().session.text(), text);
    // When it is closed, they are those of the graph again.
    window.key_press(Key::Escape);
    window.run_steps(4);
    window.key_press(Key::Delete);
    window.run_steps(3);
    assert!(editor(&window).state().sheet().nodes.is_empty());
}

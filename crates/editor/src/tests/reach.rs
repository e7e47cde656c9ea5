//! Tests of permissions for files outside a document's folder: requested, given, stored, and revoked.

use super::DUSK;
use crate::actions::Action;
use crate::document::Session;
use crate::testing::{Window, act, editor, finished, until, window};
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};

/// A folder with a picture, and another with a document that reads it.
struct Shot {
    root: tempfile::TempDir,
    /// Canonical path of the picture's folder, as messages show it.
    plates: PathBuf,
}

impl Shot {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let plates = root.path().canonicalize().unwrap().join("plates");
        std::fs::create_dir(&plates).unwrap();
        image::RgbImage::from_pixel(2, 2, image::Rgb([9; 3])).save(plates.join("plate.png")).unwrap();
        Self { root, plates }
    }

    /// Writes a document that reads the picture into a folder of its own.
    fn document(&self, name: &str) -> PathBuf {
        let folder = self.root.path().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let text = DUSK
            .replace(
                "{ \"type\": \"ScreenY\" }",
                "{ \"type\": \"Read\", \"as\": \"color\", \"fit\": \"nearest\", \"file\": \"../plates/plate.png\" }",
            )
            .replace("\"weight\": \"down\", ", "\"weight\": 0.5, ")
            .replace("\"b\": \"#14262e\"", "\"b\": \"down\"");
        std::fs::write(folder.join("dusk.json"), text).unwrap();
        folder.join("dusk.json")
    }

    fn open(&self, document: &Path) -> Window {
        let mut window = window(Session::open(document).unwrap(), Some(self.root.path().join("data")));
        look(&mut window);
        window
    }

    fn reading(&self) -> String {
        format!("Allow reading {}", self.plates.display())
    }
}

fn look(window: &mut Window) {
    finished(window);
    window.run_steps(2);
}

fn is_seen(window: &Window) -> bool {
    let seen = &editor(window).state().evaluated;
    seen.failed.is_none() && seen.result.is_some()
}

#[test]
fn a_file_elsewhere_is_read_once_it_is_allowed_and_that_is_remembered() {
    let shot = Shot::new();
    let (one, two) = (shot.document("one"), shot.document("two"));
    let text = std::fs::read_to_string(&one).unwrap();
    let mut first = shot.open(&one);
    let fault = editor(&first).state().evaluated.failed.clone().unwrap();
    assert!(fault.contains("node \"down\" (Read)") && fault.contains("plate.png"), "{fault}");
    let (told, button) = (first.get_by_label(&fault).rect(), first.get_by_label(&shot.reading()).rect());
    assert!(button.top() >= told.bottom(), "{button:?} below {told:?}");
    assert!(first.get_by_label("Picture").rect().contains_rect(button));
    assert!(!shot.root.path().join("data/allowed.json").exists(), "nothing is allowed by itself");
    first.get_by_label(&shot.reading()).click();
    first.run_steps(2);
    look(&mut first);
    assert!(is_seen(&first), "{:?}", editor(&first).state().evaluated.failed);
    assert!(first.query_by_label(&shot.reading()).is_none());
    assert!(!editor(&first).state().session.is_changed());
    assert_eq!(std::fs::read_to_string(&one).unwrap(), text);
    // Another document in the same window may not read the picture, although it is in the cache.
    act(&mut first, Action::OpenFile(two.clone()));
    look(&mut first);
    assert!(!is_seen(&first));
    first.get_by_label(&shot.reading());
    drop(first);
    assert!(is_seen(&shot.open(&one)), "a new editor does not ask");
    // The permission holds whatever path names the document.
    assert!(is_seen(&shot.open(&one.parent().unwrap().join("../one/dusk.json"))));
    let second = shot.open(&two);
    assert!(!is_seen(&second));
    second.get_by_label(&shot.reading());
}

#[test]
fn a_document_saved_under_another_path_is_asked_about_anew() {
    let shot = Shot::new();
    let mut window = shot.open(&shot.document("one"));
    window.get_by_label(&shot.reading()).click();
    window.run_steps(2);
    look(&mut window);
    assert!(is_seen(&window));
    let context = window.ctx.clone();
    let copy = shot.root.path().join("one/copy.json");
    window.state_mut().as_mut().unwrap().save(&copy, None, &context);
    window.run_steps(3);
    look(&mut window);
    assert!(!is_seen(&window));
    window.get_by_label(&shot.reading());
    // A new document has no path, so its permission lasts while it is open.
    let text = editor(&window).state().session.text().replace("../plates/plate.png", &path(&shot));
    act(&mut window, Action::New);
    act(&mut window, Action::Rewrite(text));
    act(&mut window, Action::Look("dusk".into(), 0));
    look(&mut window);
    window.get_by_label(&shot.reading()).click();
    window.run_steps(2);
    look(&mut window);
    assert!(is_seen(&window), "{:?}", editor(&window).state().evaluated.failed);
}

fn path(shot: &Shot) -> String {
    shot.plates.join("plate.png").display().to_string()
}

#[test]
fn what_the_command_line_allows_is_not_asked() {
    let shot = Shot::new();
    let mut window = shot.open(&shot.document("one"));
    window.state_mut().as_mut().unwrap().allow_all(&[shot.plates.join("plate.png")]);
    look(&mut window);
    assert!(is_seen(&window));
    act(&mut window, Action::OpenFile(shot.document("two")));
    look(&mut window);
    assert!(is_seen(&window));
    drop(window);
    assert!(!is_seen(&shot.open(&shot.root.path().join("one/dusk.json"))), "it is not remembered");
}

#[test]
fn a_run_asks_what_it_may_write_and_read_and_goes_on() {
    let shot = Shot::new();
    let document = shot.document("one");
    let made = shot.root.path().canonicalize().unwrap().join("made");
    std::fs::create_dir(&made).unwrap();
    let text = std::fs::read_to_string(&document).unwrap().replace("dusk.####.png", "../made/dusk.####.png");
    std::fs::write(&document, text).unwrap();
    let mut window = shot.open(&document);
    act(&mut window, Action::Range(2, 3));
    let writing = format!("Allow writing {}", made.display());
    act(&mut window, Action::Render);
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert!(window.query_by_label(&writing).is_none());
    act(&mut window, Action::Render);
    assert!(editor(&window).state().render.is_none());
    window.get_by_label(&writing).click();
    window.run_steps(3);
    // One button in the viewer, and one in the question of the run.
    let reading = shot.reading();
    assert_eq!(window.get_all_by_label(&reading).count(), 2);
    assert_eq!(std::fs::read_dir(&made).unwrap().count(), 0, "no file is written before all questions are answered");
    window.get_all_by_label(&reading).last().unwrap().click();
    window.run_steps(2);
    until(&mut window, "the files", |editor| editor.state().render.is_none());
    let mut names: Vec<_> = std::fs::read_dir(&made).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["dusk.0002.png", "dusk.0003.png"]);
    look(&mut window);
    assert!(is_seen(&window));
}

#[test]
fn a_folder_that_may_be_read_may_not_be_written() {
    let shot = Shot::new();
    let document = shot.document("one");
    let text = std::fs::read_to_string(&document).unwrap().replace("dusk.####.png", "../plates/dusk.####.png");
    std::fs::write(&document, text).unwrap();
    let mut window = shot.open(&document);
    window.get_by_label(&shot.reading()).click();
    window.run_steps(2);
    look(&mut window);
    assert!(is_seen(&window));
    act(&mut window, Action::Range(1, 1));
    act(&mut window, Action::Render);
    let writing = format!("Allow writing {}", shot.plates.display());
    window.get_by_label(&writing).click();
    window.run_steps(2);
    until(&mut window, "the file", |editor| editor.state().render.is_none());
    assert!(shot.plates.join("dusk.0001.png").exists());
    // Reading and writing are revoked separately.
    act(&mut window, Action::ShowAllowed);
    window.get_by_label(&format!("Remove writing {}", shot.plates.display())).click();
    window.run_steps(3);
    window.get_by_label(&format!("Remove reading {}", shot.plates.display()));
    window.get_by_label("Close").click();
    window.run_steps(3);
    act(&mut window, Action::Render);
    window.get_by_label(&writing);
}

#[test]
fn permissions_can_be_revoked() {
    let shot = Shot::new();
    let (one, two) = (shot.document("one"), shot.document("two"));
    for document in [&two, &one] {
        let mut window = shot.open(document);
        window.get_by_label(&shot.reading()).click();
        window.run_steps(2);
        look(&mut window);
        assert!(is_seen(&window));
    }
    let mut window = shot.open(&one);
    assert!(is_seen(&window));
    window.get_by_label("File").click();
    window.run_steps(3);
    window.get_by_label("Allowed folders …").click();
    window.run_steps(3);
    let remove = format!("Remove reading {}", shot.plates.display());
    assert_eq!(window.get_all_by_label(&remove).count(), 2, "of this document, and of the other");
    window.get_all_by_label(&remove).next().unwrap().click();
    window.run_steps(3);
    assert_eq!(window.get_all_by_label(&remove).count(), 1);
    look(&mut window);
    assert!(!is_seen(&window), "revoked at once");
    window.get_all_by_label(&remove).next().unwrap().click();
    window.run_steps(3);
    assert!(window.query_by_label(&remove).is_none());
    window.get_by_label("Close").click();
    window.run_steps(3);
    assert!(window.query_by_label("Allowed folders").is_none());
    assert!(!editor(&window).state().session.is_changed());
    drop(window);
    for document in [&one, &two] {
        assert!(!is_seen(&shot.open(document)), "revoked for later runs, too");
    }
}

#[test]
fn a_permission_of_a_document_without_a_file_can_be_revoked() {
    let shot = Shot::new();
    let text = std::fs::read_to_string(shot.document("one")).unwrap();
    let text = text.replace("../plates/plate.png", &path(&shot));
    let mut window = window(Session::new(text, None), Some(shot.root.path().join("data")));
    look(&mut window);
    window.get_by_label(&shot.reading()).click();
    window.run_steps(2);
    look(&mut window);
    assert!(is_seen(&window));
    act(&mut window, Action::ShowAllowed);
    window.get_by_label(&format!("Remove reading {}", shot.plates.display())).click();
    window.run_steps(3);
    look(&mut window);
    assert!(!is_seen(&window));
}

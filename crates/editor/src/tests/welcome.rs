//! The welcome, its templates, and the document that is new.

use super::{DUSK, dusk};
use crate::actions::Action;
use crate::document::session::NEW;
use crate::document::{Edit, Path, Session};
use crate::testing::{Window, act, editor, unseen, until, window};
use crate::welcome::templates;
use egui::Key;
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::json;
use trochoid::{Buffers, Cache, Plan, Plane, Settings, Silent};

fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(4);
}

/// Returns the label of the marked choice.
fn marked(window: &Window) -> String {
    let names: Vec<&str> = ["New", "Open …"].into_iter().chain(templates::ALL.iter().map(|scene| scene.name)).collect();
    let mut all = window.query_all(egui_kittest::kittest::By::new().predicate(move |node| {
        let is_marked = node.toggled() == Some(egui::accesskit::Toggled::True);
        is_marked && node.label().is_some_and(|label| names.contains(&label.as_str()))
    }));
    let found = all.next().and_then(|node| node.accesskit_node().label()).unwrap_or_default();
    assert!(all.next().is_none(), "one is marked");
    found
}

#[test]
fn the_new_document_is_a_sea_without_faults() {
    let session = Session::new(NEW.into(), None);
    let meaning = session.meaning();
    assert!(meaning.diagnostics.is_empty(), "{:?}", meaning.diagnostics);
    assert!(meaning.graph.is_some());
    let sheet = session.sheet();
    assert!(sheet.nodes.len() <= 12, "few enough to be read");
    assert!(
        crate::document::swatches::swatches(sheet, meaning.graph.as_deref(), 1)
            .iter()
            .all(|swatch| { matches!(swatch.key, crate::document::swatches::SwatchKey::Named(_)) })
    );
}

/// Evaluates the first frame of a document, 96 × 54 pixels.
fn small(mut session: Session) -> Vec<Plane> {
    for (side, count) in [("width", 96), ("height", 54)] {
        session.edit(Edit::set(Path::default().to("format").to(side), &json!(count))).unwrap();
    }
    let graph = session.meaning().graph.clone().unwrap();
    let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap();
    let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    frame.pictures.into_iter().flat_map(|picture| picture.planes).collect()
}

#[test]
fn the_picture_of_the_new_document_has_sky_water_and_foam() {
    let planes = small(Session::new(NEW.into(), None));
    let mean = |channel: usize, rows: std::ops::Range<usize>| {
        let samples = &planes[channel].samples()[96 * rows.start..96 * rows.end];
        samples.iter().sum::<f32>() / samples.len() as f32
    };
    let [sky, sea] = [0..14, 40..54].map(|rows| [0, 1, 2].map(|channel| mean(channel, rows.clone())));
    assert!(sky[0] > sky[2] + 0.04, "a warm sky: {sky:?}");
    assert!(sea[2] > sea[0] + 0.08, "cold water: {sea:?}");
    let is_white = |pixel: &usize| planes.iter().take(3).all(|plane| plane.samples()[*pixel] > 0.82);
    let share = (0..96 * 54).filter(is_white).count() as f32 / (96.0 * 54.0);
    assert!(share > 0.004 && share < 0.2, "foam on crests: {share}");
}

#[test]
fn every_template_that_is_part_of_the_program_is_whole() {
    let mut count = 0;
    for scene in &templates::ALL {
        assert!(image::load_from_memory(scene.picture).is_ok_and(|picture| picture.width() == 240), "{}", scene.name);
        let session = scene.open().unwrap();
        let errors: Vec<String> = session.meaning().errors().map(ToString::to_string).collect();
        let beside = session.sheet().value.get("include").is_some();
        assert!(errors.is_empty() && session.meaning().graph.is_some(), "{}: {errors:?}", scene.name);
        assert_eq!(session.file(), None);
        assert!(!session.is_changed());
        for output in session.sheet().value["outputs"].as_object().unwrap().values() {
            assert!(!output["file"].as_str().unwrap_or_default().contains('/'), "{}: beside the document", scene.name);
        }
        // What needs no files includes none.
        count += usize::from(!beside);
    }
    assert!(count >= 8, "{count} need no other document");
}

#[test]
fn a_template_that_includes_groups_has_the_picture_of_its_scene() {
    let scene = templates::ALL.iter().find(|scene| scene.file == "toon_lines").unwrap();
    let template = scene.open().unwrap();
    assert!(template.sheet().value.get("include").is_none() && template.sheet().value.get("groups").is_some());
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{}.json", scene.file));
    let original = Session::open(&root).unwrap();
    let bits = |session: Session| -> Vec<Vec<u32>> {
        small(session).iter().map(|plane| plane.samples().iter().map(|sample| sample.to_bits()).collect()).collect()
    };
    assert_eq!(bits(template), bits(original));
}

#[test]
fn a_template_becomes_a_new_document_by_the_keys() {
    let mut window = unseen(dusk());
    act(&mut window, Action::Welcome);
    assert_eq!(marked(&window), "New");
    press(&mut window, Key::ArrowDown);
    assert_eq!(marked(&window), "Open …");
    press(&mut window, Key::ArrowRight);
    let first = marked(&window);
    assert!(templates::ALL.iter().any(|scene| scene.name == first), "{first}");
    press(&mut window, Key::ArrowRight);
    let second = marked(&window);
    assert_ne!(first, second);
    press(&mut window, Key::ArrowLeft);
    assert_eq!(marked(&window), first);
    press(&mut window, Key::Enter);
    let state = editor(&window).state();
    assert!(window.query_by_label("Begin with a scene").is_none(), "the welcome is closed");
    assert_eq!(editor(&window).title(), "untitled — Trochoid");
    assert_ne!(state.session.text(), DUSK);
}

#[test]
fn esc_keeps_the_document() {
    let mut window = unseen(dusk());
    act(&mut window, Action::Welcome);
    window.get_by_label("Begin with a scene");
    press(&mut window, Key::Escape);
    assert!(window.query_by_label("Begin with a scene").is_none());
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn recent_documents_are_opened_and_those_that_are_gone_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (data, one, two) = (folder.path().join("data"), folder.path().join("one.json"), folder.path().join("two.json"));
    std::fs::write(&one, DUSK).unwrap();
    std::fs::write(&two, DUSK).unwrap();
    drop(window(Session::open(&one).unwrap(), Some(data.clone())));
    drop(window(Session::open(&two).unwrap(), Some(data.clone())));
    std::fs::remove_file(&two).unwrap();
    let mut window = window(dusk(), Some(data.clone()));
    act(&mut window, Action::Welcome);
    window.get_by_label("two.json is gone");
    window.get_by_label("Remove two.json").click();
    window.run_steps(3);
    assert!(window.query_by_label("two.json is gone").is_none());
    assert_eq!(crate::recent::read(&data), std::slice::from_ref(&one));
    window.get_by_label("one.json").click();
    window.run_steps(4);
    assert_eq!(editor(&window).state().session.file(), Some(one.as_path()));
}

#[test]
fn a_scene_that_reads_files_finds_them_wherever_it_is_saved() {
    let scene = templates::ALL.iter().find(|scene| scene.file == "toon_sea").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut session = scene.open().unwrap();
    assert_eq!(session.file(), None);
    session.save(&folder.path().join("mine.json")).unwrap();
    let includes = session.sheet().value["include"].as_array().unwrap();
    assert!(includes.len() > 1);
    for include in includes {
        let file = folder.path().join(include.as_str().unwrap());
        assert!(file.is_file(), "{}", file.display());
    }
}

#[test]
fn a_recent_document_has_the_picture_that_was_seen() {
    let folder = tempfile::tempdir().unwrap();
    let (data, one) = (folder.path().join("data"), folder.path().join("one.json"));
    std::fs::write(&one, DUSK).unwrap();
    let mut window = window(Session::open(&one).unwrap(), Some(data.clone()));
    assert!(crate::recent::picture_of(&data, &one).is_none());
    until(&mut window, "the thumbnails", |editor| editor.state().evaluated.thumbnails.contains_key("dusk"));
    let seen = editor(&window).state().evaluated.thumbnails["dusk"].clone();
    act(&mut window, Action::New);
    assert_eq!(crate::recent::picture_of(&data, &one).as_ref(), Some(&*seen));
    act(&mut window, Action::Welcome);
    window.get_by_label("one.json");
    crate::recent::remove(&data, &one);
    assert!(crate::recent::picture_of(&data, &one).is_none());
}

//! Tests of files that are dropped on the window.

use super::{DUSK, dusk};
use crate::actions::{Action, Pane};
use crate::document::{Session, edit};
use crate::testing::{Window, act, editor, finished, graph, unseen, value, window};
use egui_kittest::kittest::Queryable;
use serde_json::json;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

#[derive(Debug)]
struct File(PathBuf);

impl egui::DroppedFile for File {
    fn path(&self) -> &FilePath {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the editor reads files by their paths".into())
    }
}

/// Drops files at a place of the window.
fn drop_at(window: &mut Window, files: &[&FilePath], at: egui::Pos2) {
    window.hover_at(at);
    window.step();
    window.input_mut().hovered_files.push(egui::HoveredFile::default());
    window.step();
    window.get_by_label("Drop to open a document, or to add a picture, a model or a palette");
    window.input_mut().hovered_files.clear();
    window.input_mut().dropped_files = files.iter().map(|file| Arc::new(File(file.to_path_buf())) as _).collect();
    window.step();
    window.input_mut().dropped_files.clear();
    window.run_steps(3);
    assert!(window.query_by_label_contains("Drop to open a document").is_none());
}

fn drop_file(window: &mut Window, file: &FilePath) {
    let at = graph(window).center();
    drop_at(window, &[file], at);
}

fn written(folder: &FilePath, name: &str, text: &str) -> PathBuf {
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_document_opens_unless_unsaved_work_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let other = written(folder.path(), "other.json", &DUSK.replace("0.25", "0.75"));
    let mut window = unseen(dusk());
    act(&mut window, Action::Edit(edit::moved(&[("sky".into(), [7.0, 0.0])])));
    let text = editor(&window).state().session.text().to_string();
    drop_file(&mut window, &other);
    window.get_by_label("Save changes?");
    // Nothing else is taken while a question is open.
    drop_file(&mut window, &other);
    window.get_by_label("Answer the open question first, then drop the file again");
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.text(), text);
    drop_file(&mut window, &other);
    window.get_by_label("Discard").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.file(), Some(other.as_path()));
    // Without unsaved work, nothing is asked.
    let third = written(folder.path(), "third.json", DUSK);
    drop_file(&mut window, &third);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn a_picture_becomes_a_node_where_it_is_dropped_that_can_be_undone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("plates")).unwrap();
    let plate = folder.path().join("plates/take #1.png");
    image::RgbImage::from_pixel(48, 27, image::Rgb([9, 200, 100])).save(&plate).unwrap();
    let file = written(folder.path(), "dusk.json", DUSK);
    let mut window = window(Session::open(&file).unwrap(), None);
    finished(&mut window);
    let graph = graph(&window);
    let at = graph.right_center() - egui::vec2(110.0, 0.0);
    drop_at(&mut window, &[&plate], at);
    assert_eq!(editor(&window).state().chosen(), Some("read"));
    assert_eq!(value(&window, "read", "file"), Some(json!(r"plates/take \#1.png")));
    let node = window.get_by_label("Node read, Read").rect();
    assert!((node.center() - at).length() < 60.0, "{node:?} {at:?}");
    assert!(editor(&window).state().session.meaning().graph.is_some());
    act(&mut window, Action::Look("read".into(), 0));
    finished(&mut window);
    let result = editor(&window).state().evaluated.result.clone().unwrap();
    assert_eq!(result.screen.pixels[..3], [9, 200, 100]);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn models_and_several_files_become_nodes_apart_from_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let [hull, sail] =
        ["hull.obj", "sail.obj"].map(|name| written(folder.path(), name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    let boat = written(folder.path(), "boat.json", r#"{ "trochoid_model": 1, "points": [], "patches": [] }"#);
    let file = written(folder.path(), "dusk.json", DUSK);
    let mut window = unseen(Session::open(&file).unwrap());
    let at = graph(&window).center();
    drop_at(&mut window, &[&hull, &sail, &boat], at);
    assert_eq!(value(&window, "mesh", "file"), Some(json!("hull.obj")));
    assert_eq!(value(&window, "mesh2", "file"), Some(json!("sail.obj")));
    assert_eq!(value(&window, "bezier_model", "model"), Some(json!("boat.json")));
    assert_eq!(editor(&window).state().selection.len(), 3);
    let places = ["Node mesh, Mesh", "Node mesh2, Mesh", "Node bezier_model, BezierModel"];
    let places = places.map(|label| window.get_by_label(label).rect());
    assert!(!places[0].intersects(places[1]) && !places[1].intersects(places[2]) && !places[0].intersects(places[2]));
    for _ in 0..3 {
        act(&mut window, Action::Undo);
    }
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn a_file_outside_of_the_documents_folders_is_told_of() {
    let [folder, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let plate = other.path().join("plate.png");
    image::RgbImage::from_pixel(48, 27, image::Rgb([9; 3])).save(&plate).unwrap();
    let file = written(folder.path(), "dusk.json", DUSK);
    let mut window = window(Session::open(&file).unwrap(), None);
    drop_file(&mut window, &plate);
    window.get_by_label_contains("is outside of the folders that the document may read: view read");
    act(&mut window, Action::Look("read".into(), 0));
    finished(&mut window);
    window.run_steps(3);
    window.get_by_label_contains("Allow reading").click();
    finished(&mut window);
    assert!(editor(&window).state().evaluated.failed.is_none());
}

#[test]
fn a_palette_is_offered_and_taken_whole_or_by_the_names_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let named = DUSK.replace("\"nodes\"", "\"palette\": { \"deep\": \"#14262e\" },\n  \"nodes\"");
    let named = named.replace("\"b\": \"#14262e\"", "\"b\": \"palette.deep\"");
    let gimp = written(folder.path(), "night.gpl", "GIMP Palette\n16 32 48\tdeep\n240 224 208\tfoam\n");
    let json = written(folder.path(), "night.json", r##"{ "deep": "#102030", "foam": "#f0e0d0" }"##);
    for file in [gimp, json] {
        let mut window = unseen(Session::new(named.clone(), None));
        assert!(editor(&window).state().session.meaning().graph.is_some());
        let colors = |window: &Window| editor(window).state().sheet().value["palette"].clone();
        drop_file(&mut window, &file);
        window.get_by_label_contains("has 2 colors. Names that the document has, too: 1.");
        window.get_by_label("Cancel").click();
        window.run_steps(3);
        assert_eq!(editor(&window).state().session.text(), named);
        drop_file(&mut window, &file);
        window.get_by_label("Only those of the same names").click();
        window.run_steps(4);
        assert_eq!(colors(&window), json!({ "deep": "#102030" }));
        act(&mut window, Action::Undo);
        drop_file(&mut window, &file);
        window.get_by_label("Take all").click();
        window.run_steps(4);
        assert_eq!(colors(&window), json!({ "deep": "#102030", "foam": "#f0e0d0" }));
        assert!(window.query_by_label_contains("2 colors with names").is_some(), "the panel shows them");
        act(&mut window, Action::Undo);
        assert_eq!(editor(&window).state().session.text(), named);
    }
    // A document without a palette gets one.
    let mut window = unseen(dusk());
    drop_file(&mut window, &folder.path().join("night.json"));
    window.get_by_label("Take all").click();
    window.run_steps(4);
    assert_eq!(editor(&window).state().sheet().value["palette"]["foam"], json!("#f0e0d0"));
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn anything_else_is_refused_with_a_message_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = unseen(dusk());
    for (name, found) in [
        ("notes.txt", "notes.txt: found a .txt file; expected a document (.json), a palette (.json, .gpl), a picture"),
        ("clip.mov", "clip.mov: found a .mov file"),
        ("README", "README: found a file without an ending"),
        ("set.json", "set.json: found JSON that is none of these"),
    ] {
        drop_file(&mut window, &written(folder.path(), name, r#"{ "a": "b" }"#));
        window.get_by_label_contains(found);
    }
    drop_file(&mut window, folder.path());
    window.get_by_label_contains("found a folder");
    drop_file(&mut window, &written(folder.path(), "bad.gpl", "no palette"));
    assert_eq!(editor(&window).notices.texts().len(), 6, "{:?}", editor(&window).notices.texts());
    assert_eq!(editor(&window).state().session.text(), DUSK);
    assert!(editor(&window).state().session.history().undoes().is_none());
    act(&mut window, Action::Panel(Pane::Text));
}

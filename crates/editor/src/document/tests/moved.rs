use crate::document::Session;
use std::path::{Path, PathBuf};

/// Returns a document that reads a picture beside it, one below and one above its folder, a sequence, one by an
/// absolute path, and one that is missing.
fn text(whole: &Path) -> String {
    let whole = serde_json::json!(whole);
    format!(
        r##"{{
  "trochoid": 1,
  "format": {{ "width": 8, "height": 4 }},
  "frames": {{ "first": 3, "last": 5 }},
  "nodes": {{
    "beside": {{ "type": "Read", "as": "color", "file": "beside.png" }},
    "under": {{ "type": "Read", "as": "color", "file": "plates/./far/../under.png" }},
    "above": {{ "type": "Read", "as": "color", "file": "../above.png" }},
    "many": {{ "type": "Read", "as": "color", "file": "many.####.png" }},
    "whole": {{ "type": "Read", "as": "color", "file": {whole} }},
    "gone": {{ "type": "Read", "as": "color", "file": "gone.png" }},
    "all": {{ "type": "Blend", "colors": ["beside", "under", "above", "many", "whole", "gone"], "weights": [0.5, 0.1, 0.1, 0.1, 0.1, 0.1] }}
  }},
  "outputs": {{ "beauty": {{ "color": "all", "file": "out/beauty.####.exr" }}, "bare": {{ "color": "all" }} }}
}}
"##
    )
}

/// A folder `shot` with a document and its pictures.
struct Shot {
    root: tempfile::TempDir,
}

impl Shot {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let shot = Self { root };
        for folder in ["shot/plates/far", "shot/later", "other/deep"] {
            std::fs::create_dir_all(shot.at(folder)).unwrap();
        }
        let pictures = ["shot/beside", "shot/plates/under", "above", "shot/many.0003", "shot/many.0004", "whole"];
        for (index, name) in pictures.into_iter().enumerate() {
            let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([index as u8; 3]));
            picture.save(shot.at(&format!("{name}.png"))).unwrap();
        }
        std::fs::write(shot.at("shot/a.json"), text(&shot.at("whole.png"))).unwrap();
        shot
    }

    fn at(&self, path: &str) -> PathBuf {
        self.root.path().canonicalize().unwrap().join(path)
    }

    fn open(&self) -> Session {
        let session = Session::open(&self.at("shot/a.json")).unwrap();
        assert!(session.meaning().graph.is_some(), "{:?}", session.meaning().diagnostics);
        session
    }
}

/// Returns the canonical paths of the files that nodes read at the document's first frame.
fn read(session: &Session) -> Vec<PathBuf> {
    let graph = session.meaning().graph.clone().unwrap();
    let files = graph.files(&vec![true; graph.nodes().len()], &graph.frame_context(3, u64::MAX));
    let mut files: Vec<PathBuf> = files
        .into_iter()
        .filter(|file| !file.ends_with("gone.png"))
        .map(|file| file.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", file.display())))
        .collect();
    files.sort();
    files
}

fn path(session: &Session, name: &str) -> String {
    let value = &session.sheet().value;
    value["nodes"][name]["file"].as_str().unwrap().into()
}

#[test]
fn paths_lead_to_the_same_files_from_another_folder() {
    let shot = Shot::new();
    for (target, beside, under, output) in [
        ("shot/later/b.json", "../beside.png", "../plates/under.png", "../out/beauty.####.exr"),
        ("b.json", "shot/beside.png", "shot/plates/under.png", "shot/out/beauty.####.exr"),
        ("other/deep/b.json", "../../shot/beside.png", "../../shot/plates/under.png", "../../shot/out/beauty.####.exr"),
        ("shot/plates/b.json", "../beside.png", "under.png", "../out/beauty.####.exr"),
    ] {
        let mut session = shot.open();
        let before = read(&session);
        assert_eq!(before.len(), 5);
        assert_eq!(session.save(&shot.at(target)).unwrap(), 6, "{target}");
        assert_eq!(read(&session), before, "{target}");
        assert_eq!(path(&session, "beside"), beside);
        assert_eq!(path(&session, "under"), under);
        assert_eq!(Path::new(&path(&session, "whole")), shot.at("whole.png"), "the absolute path stays");
        assert_eq!(session.sheet().value["outputs"]["beauty"]["file"], output);
        assert!(!session.is_changed());
        let reopened = Session::open(&shot.at(target)).unwrap();
        assert_eq!(read(&reopened), before, "{target}");
        assert_eq!(std::fs::read_to_string(shot.at("shot/a.json")).unwrap(), text(&shot.at("whole.png")));
        assert_eq!(session.undo().as_deref(), Some("Rewrite 6 paths"));
        assert_eq!(session.text(), text(&shot.at("whole.png")));
        assert!(session.is_changed(), "the file has another text");
        session.redo();
        assert!(!session.is_changed());
    }
}

#[test]
fn nothing_is_rewritten_within_a_folder() {
    let shot = Shot::new();
    let mut session = shot.open();
    assert_eq!(session.save(&shot.at("shot/b.json")).unwrap(), 0);
    assert_eq!(session.save(&shot.at("shot/later/../c.json")).unwrap(), 0, "it is the same folder");
    assert_eq!(session.text(), text(&shot.at("whole.png")));
    assert_eq!(session.history().undoes(), None);
}

#[cfg(unix)]
#[test]
fn a_folder_behind_a_link_is_where_it_leads_to() {
    let shot = Shot::new();
    std::os::unix::fs::symlink(shot.at("other/deep"), shot.at("shot/link")).unwrap();
    let mut session = shot.open();
    let before = read(&session);
    session.save(&shot.at("shot/link/b.json")).unwrap();
    assert_eq!(read(&session), before);
    assert_eq!(path(&session, "beside"), "../../shot/beside.png");
}

#[test]
fn a_document_that_cannot_be_written_stays_where_it_is() {
    let shot = Shot::new();
    let mut session = shot.open();
    assert!(session.save(&shot.at("shot/a.json/b.json")).is_err());
    assert_eq!(session.file(), Some(shot.at("shot/a.json").as_path()));
    assert_eq!(session.text(), text(&shot.at("whole.png")));
    assert_eq!(session.history().undoes(), None);
}

#[test]
fn in_a_document_never_saved_only_paths_of_existing_files_are_rewritten() {
    let folder = tempfile::tempdir().unwrap();
    // Tests run in the folder of their crate.
    let text = text(&folder.path().join("whole.png")).replace("../above.png", "src/lib.rs");
    let mut session = Session::new(text, None);
    assert_eq!(session.save(&folder.path().join("a.json")).unwrap(), 1);
    let found = folder.path().canonicalize().unwrap().join(path(&session, "above"));
    assert_eq!(found.canonicalize().unwrap(), Path::new("src/lib.rs").canonicalize().unwrap());
    assert_eq!(path(&session, "beside"), "beside.png");
    assert_eq!(session.sheet().value["outputs"]["beauty"]["file"], "out/beauty.####.exr");
}

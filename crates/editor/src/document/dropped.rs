//! Files that are dropped on the window: what each of them is, and the node that reads it.

use super::change::Edit;
use super::edit;
use super::json::{Op, Path as ValuePath, quoted};
use super::palette_file;
use super::relocate;
use super::sheet::{Point, Sheet};
use super::swatches::space;
use serde_json::Value;
use std::path::Path;
use trochoid::{Access, Arity, Declaration, Item, Kind, KnobType, registry};

/// Maximum size of a JSON file, in bytes.
const MOST_BYTES: u64 = 64 << 20;

/// What a dropped file is.
#[derive(Clone, Debug)]
pub enum Dropped {
    /// A document.
    Document,
    /// A palette, with its colors as documents have them.
    Palette(Vec<(String, Value)>),
    /// A file that this type of node reads.
    Read(&'static Declaration),
}

/// Reason that a dropped file is of no use.
#[derive(Debug, thiserror::Error)]
pub enum Useless {
    /// It is none of the known kinds.
    #[error(
        "{file}: found {found}; expected a document (.json), a palette (.json, .gpl), a picture (.exr, .png, .jpg, .tif), or a \
         model (.obj, .gltf, .glb, or .json of patches)"
    )]
    Unknown {
        /// Its name.
        file: String,
        /// What it is instead.
        found: String,
    },
    /// It cannot be read.
    #[error(transparent)]
    Unreadable(#[from] trochoid::io::Error),
    /// It is a palette with faults.
    #[error(transparent)]
    Palette(#[from] trochoid::LoadError),
    /// No document can name it.
    #[error(transparent)]
    Path(#[from] relocate::NoText),
}

/// Returns what a file is, by its name and, if it is JSON, its content.
///
/// # Errors
/// It is nothing that a document can use.
pub fn kind(file: &Path, sheet: &Sheet) -> Result<Dropped, Useless> {
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let unknown = |found: &str| Useless::Unknown { file: name.clone(), found: found.into() };
    if file.is_dir() {
        return Err(unknown("a folder"));
    }
    // The user chose the file, which the document does not name.
    let palette = || palette_file::read(file, space(sheet), &Access::everything()).map(Dropped::Palette);
    match ending.as_str() {
        "gpl" => Ok(palette()?),
        "json" => {
            let text = trochoid::io::read_text(file, MOST_BYTES)?;
            let Ok(value) = serde_json::from_str::<Value>(text.trim_start_matches('\u{feff}')) else {
                // The editor shows where a document is damaged.
                return Ok(Dropped::Document);
            };
            let has = |key: &str| value.get(key).is_some();
            if has("trochoid") || has("nodes") {
                Ok(Dropped::Document)
            } else if has("trochoid_model") {
                reader(&name).map(Dropped::Read).ok_or_else(|| unknown("a model that no node reads"))
            } else if has("trochoid_palette") || is_palette(&value) {
                Ok(palette()?)
            } else {
                Err(unknown("JSON that is none of these"))
            }
        }
        "" => Err(unknown("a file without an ending")),
        _ => reader(&name).map(Dropped::Read).ok_or_else(|| unknown(&format!("a .{ending} file"))),
    }
}

/// Returns whether a value may be the colors of a palette: names with colors.
fn is_palette(value: &Value) -> bool {
    let is_color = |value: &Value| match value {
        Value::String(text) => text.starts_with('#'),
        Value::Array(items) => items.len() == 3 && items.iter().all(Value::is_number),
        value => value.get("keys").is_some(),
    };
    value.as_object().is_some_and(|entries| !entries.is_empty() && entries.values().all(is_color))
}

/// Returns the type of node that reads a file: the one that needs nothing else.
fn reader(name: &str) -> Option<&'static Declaration> {
    let all = registry().iter().map(|ty| ty.declaration());
    let reading =
        all.filter(|known| known.reads.is_some_and(|files| files.include(name)) && file_knob(known).is_some());
    // What gives what the file is, and not something made of it.
    let is_plain = |known: &&Declaration| {
        needs(known) == 0 && known.outputs.first().is_some_and(|made| matches!(made.kind, Kind::Color | Kind::Surface))
    };
    reading.filter(is_plain).min_by_key(|known| known.items.len())
}

/// Returns how many connections and lists a type needs, and knobs that could be anything.
fn needs(declaration: &Declaration) -> usize {
    let is_needed = |item: &&Item| match item {
        Item::Port(port) => !matches!(port.arity, Arity::Optional | Arity::Many { min: 0, .. }),
        Item::List(list) => list.min > 0,
        Item::Knob(knob) => {
            knob.default.is_none() && !matches!(knob.takes, KnobType::Path | KnobType::Choice(_) | KnobType::Bool)
        }
    };
    declaration.items.iter().filter(is_needed).count()
}

/// Returns the knob that names the file.
fn file_knob(declaration: &Declaration) -> Option<&'static str> {
    declaration.items.iter().find_map(|item| match item {
        Item::Knob(knob) if matches!(knob.takes, KnobType::Path) => Some(knob.name),
        _ => None,
    })
}

/// Adds the node that reads a file to a document in a folder; also returns its name.
///
/// # Errors
/// No document can name the file.
pub fn added(
    sheet: &Sheet,
    declaration: &'static Declaration,
    file: &Path,
    folder: &Path,
    at: Point,
) -> Result<(Edit, String), Useless> {
    let path = relocate::relative(file, folder)?;
    let (edit, name) = edit::added(sheet, declaration, at);
    let knob = file_knob(declaration).unwrap_or_default();
    let label = format!("Add {} of {}", declaration.name, file.file_name().unwrap_or_default().to_string_lossy());
    let set = Op::Set(ValuePath::node(&name).to(knob), quoted(&path));
    Ok((Edit { label, ..edit.then(Edit::new("", vec![set])) }, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_file_has_the_node_that_reads_it_and_needs_nothing_else() {
        for (file, ty) in [
            ("plate.exr", "Read"),
            ("Plate.0001.PNG", "Read"),
            ("print.jpeg", "Read"),
            ("hull.obj", "Mesh"),
            ("boat.glb", "Mesh"),
            ("model.json", "BezierModel"),
        ] {
            assert_eq!(reader(file).map(|known| known.name), Some(ty), "{file}");
        }
        assert!(reader("notes.txt").is_none() && reader("clip.mov").is_none());
    }

    #[test]
    fn json_is_told_apart_by_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let sheet = Sheet::default();
        let told = |text: &str| {
            let file = folder.path().join("some.json");
            std::fs::write(&file, text).unwrap();
            match kind(&file, &sheet) {
                Ok(Dropped::Document) => "document".to_string(),
                Ok(Dropped::Palette(colors)) => format!("palette of {}", colors.len()),
                Ok(Dropped::Read(known)) => known.name.into(),
                Err(why) => why.to_string(),
            }
        };
        assert_eq!(told(r#"{ "trochoid": 1, "nodes": {} }"#), "document");
        assert_eq!(told(r#"{ "nodes": {} }"#), "document");
        assert_eq!(told("{ \"trochoid\": 1, "), "document", "the editor shows what is wrong with it");
        assert_eq!(told(r#"{ "trochoid_model": 1, "points": [] }"#), "BezierModel");
        assert_eq!(told(r##"{ "trochoid_palette": 1, "palette": { "a": "#102030" } }"##), "palette of 1");
        assert_eq!(told(r##"{ "a": "#102030", "b": [0, 0.5, 1] }"##), "palette of 2");
        assert!(
            told(r#"{ "a": "b" }"#).starts_with("some.json: found JSON that is none of these; expected a document")
        );
        let text = folder.path().join("some.txt");
        std::fs::write(&text, "").unwrap();
        let why = kind(&text, &sheet).unwrap_err().to_string();
        assert!(why.starts_with("some.txt: found a .txt file; expected a document (.json), a palette"), "{why}");
        let why = kind(folder.path(), &sheet).unwrap_err().to_string();
        assert!(why.contains("found a folder"), "{why}");
    }
}

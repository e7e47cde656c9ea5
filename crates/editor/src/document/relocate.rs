//! Rewrites the relative paths of a document that moves to another folder, so that they still refer to the same files.

use super::change::Edit;
use super::edit::count;
use super::group;
use super::json::{Op, Path as ValuePath, quoted};
use super::link::is_link;
use super::sheet::Sheet;
use serde_json::Value;
use std::path::{Component, Path, PathBuf};
use trochoid::{Item, Knob, KnobType, escape_frame, expand_frame};

/// Maximum number of frames of a sequence to look for.
const FRAMES: usize = 1000;

/// A folder on the way to a file, whose name is no text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found \"{}\" on the way to a file that the document names; expected folders whose names are text, because a document can \
     name no others; rename the folder, or write the path in the document from the root",
    path.display()
)]
pub struct NoText {
    /// The path so far.
    pub path: PathBuf,
}

/// Rewrites the relative paths of a document for a move from one folder to another; absolute paths stay. The edit has
/// one operation for each path that changes.
///
/// If the document has no file yet (`stored` is false), only paths to existing files are rewritten, and output paths
/// are not: they are meant relative to the folder where the document is saved.
///
/// # Errors
/// Fails if a path would lead through a folder whose name is not Unicode.
pub fn relocated(sheet: &Sheet, from: &Path, to: &Path, stored: bool) -> Result<Edit, NoText> {
    let (from, to) = (real(from), real(to));
    let mut ops = Vec::new();
    if from != to {
        for (place, path) in paths(sheet, stored) {
            if path.is_empty() || Path::new(&path).is_absolute() || !(stored || is_there(sheet, &from, &path)) {
                continue;
            }
            let new = rewritten(&path, &from, &to)?;
            if new != path {
                ops.push(Op::Set(place, quoted(&new)));
            }
        }
    }
    Ok(Edit::new(format!("Rewrite {}", count(ops.len(), "path")), ops))
}

/// Rewrites the paths of copied nodes, from a document in one folder to one in another.
pub fn carried(text: &str, from: &Path, to: &Path) -> Option<String> {
    let sheet = Sheet::new(serde_json::from_str(text).ok()?, None);
    let edit = relocated(&sheet, from, to, true).ok()?;
    Some(edit.applied(text).ok()?.0)
}

/// Returns the path of a file as a document in a folder has it: relative to the folder, with placeholders escaped.
///
/// # Errors
/// Fails if the path would lead through a folder whose name is not Unicode, or the file's is not.
pub fn relative(file: &Path, folder: &Path) -> Result<String, NoText> {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.into());
    let name = file.file_name().and_then(|name| name.to_str()).ok_or_else(|| NoText { path: file.clone() })?;
    rewritten(&escape_frame(name), &real(file.parent().unwrap_or(&file)), &real(folder))
}

/// Returns every path in a document: of files it reads and, on request, of its outputs.
fn paths(sheet: &Sheet, outputs: bool) -> Vec<(ValuePath, String)> {
    let mut found = Vec::new();
    for node in &sheet.nodes {
        let place = ValuePath::node(&node.name);
        if let (Some(declaration), Some(body)) = (node.declaration, sheet.get(&place)) {
            collect(declaration.items, body, &place, &mut found);
        }
    }
    let includes = sheet.value.get("include").and_then(Value::as_array);
    for (index, path) in includes.into_iter().flatten().enumerate() {
        found.extend(path.as_str().map(|path| (ValuePath::default().to("include").to(index), path.to_string())));
    }
    for name in sheet.library.names() {
        group_paths(sheet, name, &mut found);
    }
    for output in sheet.outputs.iter().filter(|_| outputs) {
        let place = ValuePath::default().to("outputs").to(&output.name).to("file");
        if let Some(Value::String(path)) = sheet.get(&place) {
            found.push((place, path.clone()));
        }
    }
    found
}

/// Adds the paths in the definition of a group that the document itself has.
fn group_paths(sheet: &Sheet, name: &str, found: &mut Vec<(ValuePath, String)>) {
    let Some(group) = sheet.library.group(name).filter(|group| group.file.is_none()) else { return };
    let place = ValuePath::default().to("groups").to(name);
    for (node, body) in group.entries("nodes") {
        if let Some(declaration) = sheet.library.declaration(body) {
            collect(declaration.items, body, &place.to("nodes").to(node), found);
        }
    }
    for item in sheet.library.face(name).map_or(&[][..], |face| face.items) {
        let Item::Knob(Knob { name, takes: KnobType::Path, .. }) = item else { continue };
        let place = place.to("knobs").to(*name);
        let Some((default, is_described)) = sheet.get(&place).map(group::whole_default) else { continue };
        let place = if is_described { place.to("default") } else { place };
        found.extend(default.and_then(Value::as_str).map(|path| (place, path.to_string())));
    }
}

fn collect(items: &[Item], body: &Value, place: &ValuePath, found: &mut Vec<(ValuePath, String)>) {
    for item in items {
        match (item, body.get(item.name())) {
            (Item::Knob(knob), Some(Value::String(path))) if matches!(knob.takes, KnobType::Path) && !is_link(path) => {
                found.push((place.to(knob.name), path.clone()));
            }
            (Item::List(list), Some(Value::Array(records))) => {
                for (index, record) in records.iter().enumerate() {
                    collect(list.items, record, &place.to(list.name).to(index), found);
                }
            }
            _ => {}
        }
    }
}

/// Returns whether a path refers to a file at any frame of the document.
fn is_there(sheet: &Sheet, folder: &Path, path: &str) -> bool {
    let (first, last, _) = sheet.frames;
    (first..=last).take(FRAMES).any(|frame| folder.join(expand_frame(path, frame)).exists())
}

/// Resolves the links in a folder's path, so that `..` leads to the actual parent.
fn real(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::fs::canonicalize(folder).or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.into())
}

/// Escapes frame placeholders in a folder's path, as documents do.
fn escaped(folder: &Path) -> PathBuf {
    let name = |step: Component<'_>| match step.as_os_str().to_str() {
        Some(name) => escape_frame(name).into(),
        None => step.as_os_str().to_os_string(),
    };
    folder.components().map(name).collect()
}

/// Converts a path relative to one folder into one relative to another; both folders are free of links. Frame
/// placeholders in the folders' names are escaped, as they already are in the path.
fn rewritten(path: &str, from: &Path, to: &Path) -> Result<String, NoText> {
    let mut target = escaped(from);
    for step in Path::new(path).components() {
        match step {
            Component::ParentDir => {
                let there = target.to_str().map_or_else(|| target.clone(), |name| expand_frame(name, 0).into());
                if there.is_symlink() {
                    target = escaped(&real(&there));
                }
                target.pop();
            }
            Component::Normal(name) => target.push(name),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    // No relative path exists between two drives.
    let Some(relative) = pathdiff::diff_paths(&target, escaped(to)) else { return text(&target) };
    let steps: Result<Vec<String>, NoText> = relative.components().map(|step| text(step.as_ref())).collect();
    Ok(steps?.join("/"))
}

fn text(path: &Path) -> Result<String, NoText> {
    path.to_str().map(String::from).ok_or_else(|| NoText { path: path.into() })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn signs_of_frames_in_names_of_folders_are_escaped() {
        let moved = |path: &str| rewritten(path, Path::new("/x/take #1/50%d"), Path::new("/x")).unwrap();
        assert_eq!(moved("a.####.png"), r"take \#1/50\%d/a.####.png");
        assert_eq!(moved(r"../a\#.png"), r"take \#1/a\#.png");
        let back = rewritten(r"take \#1/a.png", Path::new("/x"), Path::new("/x/take #1")).unwrap();
        assert_eq!(back, "a.png");
    }
}

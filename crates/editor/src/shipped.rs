//! Groups that come with the program. A document that uses one gets a copy, so that it needs no other document.

use crate::document::group::{Library, copied};
use crate::document::{Edit, Op, Path as ValuePath, Sheet, relocate};
use crate::welcome::templates;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use trochoid::{Declaration, registry};

/// A document of groups.
struct Shelf {
    file: &'static str,
    library: Library,
    /// By group: itself and those that it uses.
    needed: BTreeMap<String, BTreeSet<String>>,
    /// Groups that read files.
    reading: BTreeSet<String>,
}

macro_rules! shelves {
    ($($file:literal),*) => {
        [$(($file, include_str!(concat!("../scenes/", $file)))),*]
    };
}

static SHELVES: LazyLock<Vec<Shelf>> = LazyLock::new(|| {
    let texts: [(&str, &str); 7] = shelves![
        "lib/boats.json",
        "lib/ink.json",
        "lib/octopus.json",
        "lib/painting.json",
        "lib/spray.json",
        "lib/storm.json",
        "lib/toon_sea.json"
    ];
    texts.into_iter().map(|(file, text)| Shelf::read(file, text)).collect()
});

/// The folder of the scenes, which has the models that some groups read.
static FOLDER: LazyLock<Option<PathBuf>> = LazyLock::new(templates::folder);

/// Returns the faces of the groups that a document could use: those that it does not have, and that clash with none of
/// its own.
pub(crate) fn offered(sheet: &Sheet) -> impl Iterator<Item = &'static Declaration> {
    let all = SHELVES.iter().flat_map(|shelf| shelf.library.names().map(move |name| (shelf, name)));
    all.filter_map(|(shelf, name)| if shelf.may_go(sheet, name) { shelf.library.face(name) } else { None })
}

/// Returns whether a type is such a group.
pub(crate) fn is_offered(sheet: &Sheet, ty: &str) -> bool {
    SHELVES.iter().any(|shelf| shelf.may_go(sheet, ty))
}

/// Puts an edit that uses a group behind one that copies it into the document, with the groups that it uses, if the
/// document in this folder does not have it.
pub(crate) fn with_group(sheet: &Sheet, folder: &Path, ty: &str, edit: Edit) -> Edit {
    let Some(shelf) = SHELVES.iter().find(|shelf| shelf.may_go(sheet, ty)) else { return edit };
    let missing = shelf.needed.get(ty).into_iter().flatten().filter(|name| sheet.library.group(name).is_none());
    let folder = shelf.folder_from(folder).unwrap_or_default();
    let ops = missing.filter_map(|name| {
        let text = copied(&shelf.library, name, &folder)?;
        Some(Op::Set(ValuePath::default().to("groups").to(name), text))
    });
    let label = edit.label.clone();
    Edit { label, ..Edit::new("", ops.collect()).then(edit) }
}

/// Returns a group and those that it uses.
fn needed(library: &Library, name: &str) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut open = vec![name.to_string()];
    while let Some(name) = open.pop() {
        let Some(group) = library.group(&name) else { continue };
        if all.insert(name) {
            let types = group.entries("nodes").filter_map(|(_, node)| node.get("type")?.as_str());
            open.extend(types.map(String::from));
        }
    }
    all
}

impl Shelf {
    fn read(file: &'static str, text: &str) -> Self {
        let library = Library::read(&serde_json::from_str::<Value>(text).unwrap_or_default(), None);
        let needed = library.names().map(|name| (name.clone(), needed(&library, name))).collect();
        // What differs in another folder names files.
        let reads = |name: &&String| copied(&library, name, "") != copied(&library, name, "elsewhere");
        let reading = library.names().filter(reads).cloned().collect();
        Self { file, library, needed, reading }
    }

    /// Returns whether a document that does not have a group can get it.
    fn may_go(&self, sheet: &Sheet, name: &str) -> bool {
        let Some(needed) = self.needed.get(name).filter(|_| sheet.library.group(name).is_none()) else { return false };
        let body = |library: &Library, name: &str| library.group(name).map(|group| group.body.clone());
        let fits = |name: &String| {
            sheet.library.group(name).is_none() || body(&sheet.library, name) == body(&self.library, name)
        };
        registry().get(name).is_none()
            && needed.iter().all(fits)
            && (FOLDER.is_some() || needed.is_disjoint(&self.reading))
    }

    /// Returns the folder of the shelf as a document in a folder names it.
    fn folder_from(&self, folder: &Path) -> Option<String> {
        let file = FOLDER.as_ref()?.join(self.file);
        let path = relocate::relative(&file, folder).ok()?;
        Some(path.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_of_the_library_is_offered_once() {
        let names: Vec<&str> = offered(&Sheet::default()).map(|face| face.name).collect();
        let unique: BTreeSet<&str> = names.iter().copied().collect();
        assert_eq!(names.len(), unique.len(), "{names:?}");
        for name in ["RowingBoat", "Ink", "Octopus", "Painted", "StormSpray", "StormFleet", "ToonWater"] {
            assert!(unique.contains(name), "{name}: {names:?}");
        }
    }
}

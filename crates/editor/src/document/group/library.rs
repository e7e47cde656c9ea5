//! The groups of a document, and of the documents that it includes.

use super::face;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use trochoid::{Access, Declaration, registry};

/// Definition of a group.
#[derive(Clone, Debug)]
pub struct Group {
    /// What the document says under its name.
    pub body: Value,
    /// The included file that has it, relative to the document; `None` if the document itself does.
    pub file: Option<String>,
}

impl Group {
    /// Returns its entries under a key, such as its nodes.
    pub fn entries(&self, key: &str) -> impl Iterator<Item = (&String, &Value)> {
        self.body.get(key).and_then(Value::as_object).into_iter().flatten()
    }

    /// Returns whether it has an entry under a key.
    pub fn has(&self, key: &str, name: &str) -> bool {
        self.body.get(key).and_then(|entries| entries.get(name)).is_some()
    }
}

/// All groups that a document can use.
#[derive(Clone, Debug, Default)]
pub struct Library {
    groups: BTreeMap<String, Group>,
    faces: BTreeMap<String, &'static Declaration>,
    files: BTreeSet<String>,
}

impl Library {
    /// Reads the groups of a parsed document, and those of the documents that it includes as far as they can be read.
    pub fn read(document: &Value, place: Option<(&Path, &Access)>) -> Self {
        let mut library = Self::default();
        library.take(document, None);
        if let Some((folder, access)) = place {
            library.include(document, folder, access);
        }
        let names: Vec<String> = library.groups.keys().cloned().collect();
        for name in names {
            library.know(&name, &mut BTreeSet::new());
        }
        library
    }

    fn take(&mut self, document: &Value, file: Option<&str>) {
        let groups = document.get("groups").and_then(Value::as_object);
        for (name, body) in groups.into_iter().flatten() {
            let group = Group { body: body.clone(), file: file.map(String::from) };
            self.groups.entry(name.clone()).or_insert(group);
        }
    }

    /// Takes the groups of included documents, each of which is read once. Files that cannot be read are faults of the
    /// document, which are told where it is checked.
    fn include(&mut self, document: &Value, folder: &Path, access: &Access) {
        let mut open: Vec<String> = named(document, "");
        while let Some(file) = open.pop() {
            if !self.files.insert(file.clone()) {
                continue;
            }
            let path = folder.join(&file);
            let Ok(()) = access.check(&path) else { continue };
            let Ok(text) = trochoid::io::read_text(&path, MOST_BYTES) else { continue };
            let Ok(value) = serde_json::from_str::<Value>(&text) else { continue };
            self.take(&value, Some(&file));
            let within = file.rsplit_once('/').map_or("", |(folder, _)| folder);
            open.extend(named(&value, within));
        }
    }

    /// Makes the face of a group, after those of the groups that it uses.
    fn know(&mut self, name: &str, asked: &mut BTreeSet<String>) {
        // A group that uses itself is a fault; it has no face inside of itself.
        if self.faces.contains_key(name) || !asked.insert(name.into()) {
            return;
        }
        let Some(group) = self.groups.get(name).cloned() else { return };
        for (_, node) in group.entries("nodes") {
            if let Some(ty) = node.get("type").and_then(Value::as_str) {
                self.know(ty, asked);
            }
        }
        self.faces.insert(name.into(), face::made(self, name, &group));
    }

    /// Returns the group with this name.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.groups.get(name)
    }

    /// Returns the included files, relative to the document, whether they can be read or not.
    pub fn files(&self) -> &BTreeSet<String> {
        &self.files
    }

    /// Returns the names of all groups.
    pub fn names(&self) -> impl Iterator<Item = &String> {
        self.groups.keys()
    }

    /// Returns what uses of a group look like.
    pub fn face(&self, name: &str) -> Option<&'static Declaration> {
        self.faces.get(name).copied()
    }

    /// Returns the declaration of a node: that of its type, or the face of the group that it uses. An input of a group has
    /// a list of connections if the use has one.
    pub fn declaration(&self, body: &Value) -> Option<&'static Declaration> {
        let ty = body.get("type").and_then(Value::as_str)?;
        match registry().get(ty) {
            Some(ty) => Some(ty.declaration()),
            None => Some(face::with_lists(self.face(ty)?, body)),
        }
    }

    /// Returns the group that a node uses.
    pub fn used(&self, body: &Value) -> Option<(&str, &Group)> {
        let ty = body.get("type").and_then(Value::as_str)?;
        let (name, group) = self.groups.get_key_value(ty)?;
        registry().get(ty).is_none().then_some((name.as_str(), group))
    }

    /// Returns a name for a group that neither a group nor a node type has.
    pub fn free_name(&self, wanted: &str) -> String {
        let is_free = |name: &String| self.group(name).is_none() && registry().get(name).is_none();
        let names = std::iter::once(wanted.to_string()).chain((2..).map(|n: usize| format!("{wanted}{n}")));
        names.into_iter().find(is_free).unwrap_or_default()
    }
}

/// Maximum size of an included document, in bytes, as for evaluation.
const MOST_BYTES: u64 = 1 << 20;

/// Returns the documents that a document in some folder includes, relative to the document that is open.
fn named(document: &Value, folder: &str) -> Vec<String> {
    let names = document.get("include").and_then(Value::as_array);
    let names = names.into_iter().flatten().filter_map(Value::as_str);
    names.map(|name| joined(folder, name)).collect()
}

/// Joins a folder and a path; names of folders that the path leaves again are left out.
pub(super) fn joined(folder: &str, path: &str) -> String {
    use std::path::Component;
    let whole: PathBuf = Path::new(folder).join(path);
    let mut parts: Vec<Component<'_>> = Vec::new();
    for part in whole.components() {
        match (part, parts.last()) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => _ = parts.pop(),
            _ => parts.push(part),
        }
    }
    parts.into_iter().collect::<PathBuf>().to_string_lossy().into_owned()
}

/// Returns an object of entries under a key, which may be missing.
pub(super) fn object<'v>(value: &'v Value, key: &str) -> Option<&'v Map<String, Value>> {
    value.get(key)?.as_object()
}

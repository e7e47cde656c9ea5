//! Groups of other documents, which a document names under `"include"`.

use super::{Document, FILED, MAX_FILE_BYTES, ReadFile, STRIDE, fault, json, relocate};
use crate::access::ALLOW;
use crate::check::FORMAT_VERSION;
use crate::spanned::{Entry, Json, Spanned, line_and_column};
use crate::{AccessViolation, Diagnostic, Means};
use std::path::{Component, Path, PathBuf};

/// A document whose groups another one includes.
#[derive(Clone, Debug)]
pub(super) struct Include {
    /// Its path, relative to the document that is loaded.
    path: String,
    /// Place of its name.
    offset: usize,
    is_read: bool,
}

impl Document {
    /// Returns the path of the next document whose groups are to be included, relative to this one; `None` if there is
    /// none, or all are read.
    pub fn next_include(&self) -> Option<&str> {
        self.includes.iter().find(|include| !include.is_read).map(|include| include.path.as_str())
    }

    /// Adds the groups of the [next](Self::next_include) included document, which has this text; what it includes itself
    /// comes after it. `path` is its path from the current folder, as diagnostics call it.
    ///
    /// # Errors
    /// The text is not a document with groups.
    pub fn include(&mut self, path: &Path, text: &str) -> Result<(), Box<Diagnostic>> {
        let Some(include) = self.includes.iter_mut().find(|include| !include.is_read) else { return Ok(()) };
        include.is_read = true;
        let folder = parent(&include.path);
        let name = &path.display().to_string();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.len() > MAX_FILE_BYTES {
            let (found, expected) = (format!("{} bytes", text.len()), format!("at most {MAX_FILE_BYTES} bytes"));
            return Err(fault(name, (0, 0), found, expected, "split it into several documents"));
        }
        let mut root = json(name, text, "a document with groups")?;
        let groups = groups_of(name, text, &root)?;
        let first = FILED + STRIDE * self.files.len();
        relocate(&mut root, &|offset| first + offset);
        self.files.push(ReadFile {
            path: path.into(),
            name: name.as_str().into(),
            text: text.into(),
            folder: Some(folder.clone()),
        });
        self.find_includes(&root, &folder);
        let Json::Object(entries) = root.json else { return Ok(()) };
        let added = entries.into_iter().nth(groups).map(|entry| entry.value);
        let Some(Spanned { json: Json::Object(added), offset }) = added else { return Ok(()) };
        if let Json::Object(top) = &mut self.root.json
            && !top.iter().any(|entry| entry.key == "groups")
        {
            let value = Spanned { offset, json: Json::Object(Vec::new()) };
            top.push(Entry { key: "groups".into(), offset, value });
        }
        if let Some(Spanned { json: Json::Object(groups), .. }) = self.top("groups") {
            groups.extend(added);
        }
        Ok(())
    }

    /// Notes the documents that a root includes, by paths relative to `folder`; each is read once.
    pub(super) fn find_includes(&mut self, root: &Spanned, folder: &str) {
        let Json::Object(entries) = &root.json else { return };
        let Some(Json::Array(named)) =
            entries.iter().find(|entry| entry.key == "include").map(|entry| &entry.value.json)
        else {
            return;
        };
        for named in named {
            let Json::String(path) = &named.json else { continue };
            let path = joined(folder, path);
            if !self.includes.iter().any(|known| known.path == path) {
                self.includes.push(Include { path, offset: named.offset, is_read: false });
            }
        }
    }

    /// Returns a path as a document of its own folder would write it, if it is written in an included document, whose paths
    /// are relative to that one.
    pub(crate) fn relocated(&self, path: &str, offset: usize) -> Option<String> {
        let folder = self.file_at(offset)?.folder.as_ref()?;
        (!path.is_empty()).then(|| joined(folder, path))
    }

    /// Returns the fault of an included document that may not be read.
    pub fn refused_include(&self, outside: AccessViolation) -> Diagnostic {
        let found = format!("the document {}", outside.leads_to.display());
        let mut fault = self.include_fault(found, outside.expected(), ALLOW);
        fault.means = Some(Means::Allow(vec![outside]));
        fault
    }

    /// Returns the fault of an included document that cannot be read, for some reason.
    pub fn unread_include(&self, why: String) -> Diagnostic {
        let remedy = "correct the path, which is relative to the document that names it";
        self.include_fault(why, "a document with groups".into(), remedy)
    }

    /// Returns a fault at the name of the next included document.
    fn include_fault(&self, found: String, expected: String, remedy: &str) -> Diagnostic {
        let next = self.includes.iter().find(|include| !include.is_read);
        let origin = self.origin(next.map_or(0, |include| include.offset));
        let mut fault = fault(&origin.file, (origin.line, origin.column), found, expected, remedy);
        fault.port = Some("include".into());
        *fault
    }
}

/// Returns the index of the entry that has the groups of an included document.
fn groups_of(name: &str, text: &str, root: &Spanned) -> Result<usize, Box<Diagnostic>> {
    let at = |offset: usize| line_and_column(text, offset);
    let remedy = "write { \"trochoid\": 1, \"groups\": { … } }, or name another document";
    let Json::Object(entries) = &root.json else {
        return Err(fault(name, at(root.offset), root.brief(), "a document with groups", remedy));
    };
    match entries.iter().find(|entry| entry.key == "trochoid").map(|entry| &entry.value) {
        Some(Spanned { json: Json::Number(version), .. }) if *version == f64::from(FORMAT_VERSION) => {}
        Some(version) => {
            let found = format!("\"trochoid\": {}", version.brief());
            let expected = format!("{FORMAT_VERSION}, the version of the document format");
            return Err(fault(
                name,
                at(version.offset),
                found,
                expected,
                "write \"trochoid\": 1, or take a newer Trochoid",
            ));
        }
        None => return Err(fault(name, at(root.offset), "no \"trochoid\"".into(), "a document with groups", remedy)),
    }
    let groups = entries.iter().position(|entry| entry.key == "groups");
    match groups.map(|index| (index, &entries[index].value)) {
        Some((index, Spanned { json: Json::Object(_), .. })) => Ok(index),
        Some((_, value)) => Err(fault(name, at(value.offset), value.brief(), "an object of groups by name", remedy)),
        // One that only passes on what it includes.
        None if entries.iter().any(|entry| entry.key == "include") => Ok(entries.len()),
        None => Err(fault(name, at(root.offset), "a document without groups".into(), "a document with groups", remedy)),
    }
}

/// Returns the folder of a path; empty for a file beside the document.
fn parent(path: &str) -> String {
    path.rsplit_once('/').map_or("", |(folder, _)| if folder.is_empty() { "/" } else { folder }).into()
}

/// Joins a folder and a path. Names of folders that the path leaves again are left out.
fn joined(folder: &str, path: &str) -> String {
    let mut parts: Vec<Component<'_>> = Vec::new();
    let whole: PathBuf = Path::new(folder).join(path);
    for part in whole.components() {
        match (part, parts.last()) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => _ = parts.pop(),
            _ => parts.push(part),
        }
    }
    let joined: PathBuf = parts.into_iter().collect();
    joined.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_included_documents_are_relative_to_them() {
        for (folder, path, whole) in [
            ("", "a.json", "a.json"),
            ("", "./lib/a.json", "lib/a.json"),
            ("lib", "b.json", "lib/b.json"),
            ("lib", "../samples/b.obj", "samples/b.obj"),
            ("../lib", "../samples/b.obj", "../samples/b.obj"),
            ("lib", "../../b.obj", "../b.obj"),
            ("lib", "/b.obj", "/b.obj"),
        ] {
            assert_eq!(joined(folder, path), whole, "{folder} and {path}");
        }
        assert_eq!((parent("a.json"), parent("lib/a.json")), (String::new(), "lib".into()));
        assert_eq!(parent("/a.json"), "/");
    }
}

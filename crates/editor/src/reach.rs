//! Permissions for folders outside a document's own: the request, the stored answers per document, and their
//! revocation.

use crate::actions::Grant;
use egui::Ui;
use std::path::{Path, PathBuf};
use trochoid::{Access, RefusedFile};

/// Maximum number of documents whose permissions are stored.
const MOST: usize = 200;

/// Maximum number of permissions stored per document.
const MOST_FOLDERS: usize = 50;

/// Maximum size of the stored list, in bytes; paths are short.
const MOST_BYTES: u64 = 16 << 20;

/// A document and its permissions.
pub(crate) type Answer = (PathBuf, Vec<Grant>);

fn list(data: &Path) -> PathBuf {
    data.join("allowed.json")
}

/// Reads the permissions of all documents, most recently changed first.
pub(crate) fn read(data: &Path) -> Vec<Answer> {
    let text = trochoid::io::read_text(list(data), MOST_BYTES).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Returns a document's path with links resolved, so that permissions apply however the path is written.
pub(crate) fn whole(document: &Path) -> PathBuf {
    document.canonicalize().or_else(|_| std::path::absolute(document)).unwrap_or_else(|_| document.into())
}

/// Returns the stored permissions of a document.
pub(crate) fn remembered(data: &Path, document: &Path) -> Vec<Grant> {
    let document = whole(document);
    read(data).into_iter().find(|(known, _)| *known == document).map_or_else(Vec::new, |(_, grants)| grants)
}

/// Stores a permission of a document.
pub(crate) fn remember(data: &Path, document: &Path, grant: &Grant) {
    let mut grants = remembered(data, document);
    grants.retain(|known| known != grant);
    grants.insert(0, grant.clone());
    grants.truncate(MOST_FOLDERS);
    // Moved to the front of the list.
    let (document, mut answers) = (whole(document), read(data));
    answers.retain(|(known, _)| *known != document);
    answers.insert(0, (document, grants));
    answers.truncate(MOST);
    write(data, &answers);
}

/// Deletes a stored permission of a document.
pub(crate) fn forget(data: &Path, document: &Path, grant: &Grant) {
    let (whole, mut answers) = (whole(document), read(data));
    for (_, grants) in answers.iter_mut().filter(|(known, _)| *known == whole || known == document) {
        grants.retain(|known| known != grant);
    }
    answers.retain(|(_, grants)| !grants.is_empty());
    write(data, &answers);
}

fn write(data: &Path, answers: &[Answer]) {
    if let Ok(text) = serde_json::to_string_pretty(answers) {
        // If storing fails, the user is asked again the next time.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
}

/// Returns the access of a document in a folder, with the permissions of this run and those of the document.
pub(crate) fn access(folder: &Path, run: &[PathBuf], grants: &[Grant]) -> Access {
    let access = run.iter().fold(Access::usual(folder), |access, path| access.allowing(path));
    grants.iter().map(Grant::parts).fold(access, |access, (folder, right, _)| access.granting(folder, right))
}

/// Draws a button for each folder that access was refused to; returns the permission given.
pub(crate) fn buttons_ui(ui: &mut Ui, refused: &[RefusedFile], has_file: bool) -> Option<Grant> {
    let mut allowed = None;
    let mut asked: Vec<Grant> = Vec::new();
    for one in refused {
        let grant = Grant::of(one);
        if asked.contains(&grant) {
            continue;
        }
        let button = egui::Button::new(format!("Allow {grant}")).wrap();
        if ui.add(button).on_hover_text(help(one, &grant, has_file)).clicked() {
            allowed = Some(grant.clone());
        }
        asked.push(grant);
    }
    allowed
}

/// Returns the tooltip of a button: the request, the actual path, and the consequences.
fn help(refused: &RefusedFile, grant: &Grant, has_file: bool) -> String {
    let (asks, may) = match &refused.node {
        Some(node) => (format!("Node “{node}” requests to read"), "read"),
        None => ("An output requests to write".into(), "write"),
    };
    let (path, leads_to) = (refused.path.display(), refused.outside.leads_to.display());
    let lasts = match has_file {
        true => "The permission is stored for this document only, by its path.",
        false => "The permission lasts until the document is saved or closed.",
    };
    format!(
        "{asks} {path}\nwhich refers to {leads_to}\n\nThis document may not {may} there. Allow it if you trust \
         the document: it may then {may} in {} and all folders below. {lasts}",
        grant.parts().0.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::Right;

    fn reading(folder: &str) -> Grant {
        Grant::Read(folder.into())
    }

    #[test]
    fn answers_go_by_document_and_the_oldest_is_forgotten() {
        let data = tempfile::tempdir().unwrap();
        let document = |index: usize| data.path().join(format!("{index}.json"));
        for index in 0..=MOST {
            remember(data.path(), &document(index), &reading("/one"));
        }
        let writing = Grant::Write { write: "/one".into() };
        remember(data.path(), &document(1), &writing);
        remember(data.path(), &document(1), &reading("/one"));
        assert_eq!(remembered(data.path(), &document(1)), [reading("/one"), writing.clone()]);
        assert_eq!(remembered(data.path(), &document(MOST)), [reading("/one")]);
        assert!(remembered(data.path(), &document(0)).is_empty());
        assert_eq!(read(data.path()).len(), MOST);
        forget(data.path(), &document(1), &reading("/one"));
        assert_eq!(remembered(data.path(), &document(1)), [writing]);
    }

    #[test]
    fn remembered_permissions_without_a_right_are_for_reading() {
        let data = tempfile::tempdir().unwrap();
        let document = data.path().join("a.json");
        let old = serde_json::json!([[whole(&document), ["/one"]]]);
        std::fs::write(list(data.path()), old.to_string()).unwrap();
        assert_eq!(remembered(data.path(), &document), [reading("/one")]);
        let access = access(data.path(), &[], &remembered(data.path(), &document));
        assert!(access.check(Path::new("/one/x.png")).is_ok());
        assert!(access.check_for(Path::new("/one/x.png"), Right::Write).is_err());
    }

    #[test]
    fn a_list_that_is_damaged_allows_nothing() {
        let data = tempfile::tempdir().unwrap();
        let document = data.path().join("a.json");
        remember(data.path(), &document, &reading("/one"));
        let text = std::fs::read_to_string(list(data.path())).unwrap();
        std::fs::write(list(data.path()), &text[..text.len() / 2]).unwrap();
        assert!(remembered(data.path(), &document).is_empty());
    }
}

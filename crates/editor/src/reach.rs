//! Folders that documents may reach besides their own: which are asked for, what was answered, by document, and what of that
//! is taken back.

use crate::actions::Grant;
use egui::Ui;
use std::path::{Path, PathBuf};
use trochoid::{Access, RefusedFile};

/// How many documents are remembered.
const MOST: usize = 200;

/// How many folders are remembered of each.
const MOST_FOLDERS: usize = 50;

/// Most bytes of the list: paths are short.
const MOST_BYTES: u64 = 16 << 20;

/// A document, and what was allowed it.
pub(crate) type Answer = (PathBuf, Vec<Grant>);

fn list(data: &Path) -> PathBuf {
    data.join("allowed.json")
}

/// What every document was allowed, the newest first.
pub(crate) fn read(data: &Path) -> Vec<Answer> {
    let text = trochoid::io::read_text(list(data), MOST_BYTES).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// A document's path with links followed: what is answered for it counts however it is named.
pub(crate) fn whole(document: &Path) -> PathBuf {
    document.canonicalize().or_else(|_| std::path::absolute(document)).unwrap_or_else(|_| document.into())
}

/// What was allowed a document.
pub(crate) fn remembered(data: &Path, document: &Path) -> Vec<Grant> {
    let document = whole(document);
    read(data).into_iter().find(|(known, _)| *known == document).map_or_else(Vec::new, |(_, grants)| grants)
}

/// Remembers what was allowed a document.
pub(crate) fn remember(data: &Path, document: &Path, grant: &Grant) {
    let mut grants = remembered(data, document);
    grants.retain(|known| known != grant);
    grants.insert(0, grant.clone());
    grants.truncate(MOST_FOLDERS);
    // Before those of all others.
    let (document, mut answers) = (whole(document), read(data));
    answers.retain(|(known, _)| *known != document);
    answers.insert(0, (document, grants));
    answers.truncate(MOST);
    write(data, &answers);
}

/// Remembers no more that this was allowed a document.
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
        // What cannot be kept is asked again.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
}

/// What a document of a folder may reach: what this run allows, and what was allowed the document.
pub(crate) fn access(folder: &Path, run: &[PathBuf], grants: &[Grant]) -> Access {
    let access = run.iter().fold(Access::usual(folder), |access, path| access.allowing(path));
    grants.iter().map(Grant::parts).fold(access, |access, (folder, right, _)| access.granting(folder, right))
}

/// A button for each folder that files were refused of; gives what is allowed.
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

/// What is asked for, where it leads, and what follows from an answer.
fn help(refused: &RefusedFile, grant: &Grant, has_file: bool) -> String {
    let (asks, may) = match &refused.node {
        Some(node) => (format!("The node “{node}” asks to read"), "read"),
        None => ("An output asks to write".into(), "write"),
    };
    let (path, leads_to) = (refused.path.display(), refused.outside.leads_to.display());
    let lasts = match has_file {
        true => "This is remembered for this document, by its path, and for no other.",
        false => "This lasts until the document is saved or closed; then it is asked again.",
    };
    format!(
        "{asks} {path}\nwhich leads to {leads_to}\n\nThat is outside of what this document may {may}. Allow it if you trust \
         the document: it may then {may} in {} and all folders beneath. {lasts}",
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
    fn what_was_remembered_without_saying_for_what_is_for_reading() {
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

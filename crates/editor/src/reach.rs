//! Folders that documents may reach besides their own: which are asked for, what was answered, by document, and what of that
//! is taken back.

use crate::actions::Action;
use crate::editor::Editor;
use crate::prompts::titled;
use egui::{Context, Modal, ScrollArea, Ui, WidgetInfo, WidgetType};
use std::path::{Path, PathBuf};
use trochoid::{Access, Refused};

/// How many documents are remembered.
const MOST: usize = 200;

/// How many folders are remembered of each.
const MOST_FOLDERS: usize = 50;

/// Most bytes of the list: paths are short.
const MOST_BYTES: u64 = 16 << 20;

/// A document, and the folders that were allowed it.
type Answer = (PathBuf, Vec<PathBuf>);

fn list(data: &Path) -> PathBuf {
    data.join("allowed.json")
}

fn read(data: &Path) -> Vec<Answer> {
    let text = trochoid::io::read_text(list(data), MOST_BYTES).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// A document's path with links followed: what is answered for it counts however it is named.
pub(crate) fn whole(document: &Path) -> PathBuf {
    document.canonicalize().or_else(|_| std::path::absolute(document)).unwrap_or_else(|_| document.into())
}

/// The folders that were allowed a document.
pub(crate) fn remembered(data: &Path, document: &Path) -> Vec<PathBuf> {
    let document = whole(document);
    read(data).into_iter().find(|(known, _)| *known == document).map_or_else(Vec::new, |(_, folders)| folders)
}

/// Remembers a folder that was allowed a document.
pub(crate) fn remember(data: &Path, document: &Path, folder: &Path) {
    let mut folders = remembered(data, document);
    folders.retain(|known| known != folder);
    folders.insert(0, folder.into());
    folders.truncate(MOST_FOLDERS);
    write(data, whole(document), folders);
}

/// Remembers no more that a folder was allowed a document.
pub(crate) fn forget(data: &Path, document: &Path, folder: &Path) {
    let mut folders = remembered(data, document);
    folders.retain(|known| known != folder);
    write(data, whole(document), folders);
}

/// Puts a document's folders before those of all others.
fn write(data: &Path, document: PathBuf, folders: Vec<PathBuf>) {
    let mut answers = read(data);
    answers.retain(|(known, _)| *known != document);
    if !folders.is_empty() {
        answers.insert(0, (document, folders));
    }
    answers.truncate(MOST);
    if let Ok(text) = serde_json::to_string_pretty(&answers) {
        // What cannot be kept is asked again.
        let _ = trochoid::write_whole(&list(data), text.as_bytes());
    }
}

/// What a document of a folder may reach, with what was allowed it.
pub(crate) fn access<'p>(folder: &Path, allowed: impl IntoIterator<Item = &'p PathBuf>) -> Access {
    allowed.into_iter().fold(Access::usual(folder), |access, path| access.allowing(path))
}

/// A button for each folder that files were refused of; gives the one that is allowed.
pub(crate) fn buttons_ui(ui: &mut Ui, refused: &[Refused], has_file: bool) -> Option<PathBuf> {
    let mut allowed = None;
    for (index, one) in refused.iter().enumerate() {
        let folder = one.outside.folder();
        if refused[..index].iter().any(|before| before.outside.folder() == folder) {
            continue;
        }
        let doing = if one.node.is_some() { "reading" } else { "writing" };
        let button = egui::Button::new(format!("Allow {doing} {}", folder.display())).wrap();
        if ui.add(button).on_hover_text(help(one, has_file)).clicked() {
            allowed = Some(folder.to_path_buf());
        }
    }
    allowed
}

/// What is asked for, where it leads, and what follows from an answer.
fn help(refused: &Refused, has_file: bool) -> String {
    let asks = match &refused.node {
        Some(node) => format!("The node “{node}” asks to read"),
        None => "An output asks to write".into(),
    };
    let (path, leads_to) = (refused.path.display(), refused.outside.leads_to.display());
    let lasts = match has_file {
        true => "This is remembered for this document, by its path, and for no other.",
        false => "This lasts until the document is saved or closed; then it is asked again.",
    };
    format!(
        "{asks} {path}\nwhich leads to {leads_to}\n\nThat is outside of what this document may reach. Allow it if you trust \
         the document: it may then read and write in {} and all folders beneath. {lasts}",
        refused.outside.folder().display()
    )
}

/// Shows which folders documents were allowed, and takes them back; whether it stays open.
pub(crate) fn allowed_ui(editor: &mut Editor, context: &Context) -> bool {
    let state = editor.state();
    let own = state.session.file().map(whole);
    let mut others = editor.prompts.data().map(read).unwrap_or_default();
    others.retain(|(document, _)| Some(document) != own.as_ref());
    let mut asked = None;
    let mut closes = false;
    let modal = Modal::new("allowed".into()).show(context, |ui| {
        titled(ui, "Allowed folders");
        ui.label("What documents may read and write besides their own folders, because it was allowed here.");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            ui.strong(format!("{} (open)", state.session.title()));
            asked = folders_ui(ui, &editor.answers).map(|folder| Action::Forbid(None, folder));
            for (document, folders) in &others {
                ui.add_space(4.0);
                ui.strong(document.display().to_string());
                let taken = folders_ui(ui, folders).map(|folder| Action::Forbid(Some(document.clone()), folder));
                asked = asked.take().or(taken);
            }
        });
        ui.add_space(8.0);
        closes = ui.button("Close").clicked();
    });
    if let Some(action) = asked {
        editor.act(action, context);
    }
    !closes && !modal.should_close()
}

/// A row for each folder; gives the one that is taken back.
fn folders_ui(ui: &mut Ui, folders: &[PathBuf]) -> Option<PathBuf> {
    let mut taken = None;
    if folders.is_empty() {
        ui.weak("No folder besides its own.");
    }
    for folder in folders {
        ui.horizontal(|ui| {
            let remove = ui.button("Remove").on_hover_text("It is asked again when the document needs it next.");
            let named = format!("Remove {}", folder.display());
            remove.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, &named));
            if remove.clicked() {
                taken = Some(folder.clone());
            }
            ui.add(egui::Label::new(folder.display().to_string()).wrap());
        });
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_go_by_document_and_the_oldest_is_forgotten() {
        let data = tempfile::tempdir().unwrap();
        let document = |index: usize| data.path().join(format!("{index}.json"));
        for index in 0..=MOST {
            remember(data.path(), &document(index), Path::new("/one"));
        }
        remember(data.path(), &document(1), Path::new("/two"));
        remember(data.path(), &document(1), Path::new("/one"));
        assert_eq!(remembered(data.path(), &document(1)), [Path::new("/one"), Path::new("/two")]);
        assert_eq!(remembered(data.path(), &document(MOST)), [Path::new("/one")]);
        assert!(remembered(data.path(), &document(0)).is_empty());
        assert_eq!(read(data.path()).len(), MOST);
    }

    #[test]
    fn a_list_that_is_damaged_allows_nothing() {
        let data = tempfile::tempdir().unwrap();
        let document = data.path().join("a.json");
        remember(data.path(), &document, Path::new("/one"));
        let text = std::fs::read_to_string(list(data.path())).unwrap();
        std::fs::write(list(data.path()), &text[..text.len() / 2]).unwrap();
        assert!(remembered(data.path(), &document).is_empty());
    }
}

//! State of the modal prompts: file dialogs, questions about unsaved work, and the command palette. The window draws
//! them (`window/questions.rs`).

use crate::actions::After;
use crate::document::Session;
use crate::document::find::Entry;
use crate::document::keep::UnsavedCopy;
use crate::welcome::Welcome;
use egui_file_dialog::{FileDialog, Filter};
use serde_json::Value;
use std::path::{Path, PathBuf};
use trochoid::RefusedFile;

/// The open prompts.
pub(crate) struct Prompts {
    data: Option<PathBuf>,
    pub(crate) open: Option<Prompt>,
    pub(crate) dialog: FileDialog,
    /// Purpose of the open file dialog.
    pub(crate) asking: Option<FileQuestion>,
}

/// Purpose of a file dialog.
#[derive(Clone, Debug)]
pub(crate) enum FileQuestion {
    Open,
    /// Save, then perform this step.
    Save(Option<After>),
}

/// A modal question.
pub(crate) enum Prompt {
    Unsaved(After),
    /// Whether to overwrite a document of a newer format version; then the next step.
    Newer(Option<After>),
    /// Whether to keep the file's text or the editor's. If the text was being saved, also the step that follows saving.
    External(Option<Option<After>>),
    /// Whether to stop rendering; then the next step.
    Rendering(After),
    /// Whether to give the permissions that rendering needs.
    Reach(Vec<RefusedFile>),
    Recover(Vec<UnsavedCopy>),
    /// Whether to overwrite this file; then the next step.
    Replace(PathBuf, Option<After>),
    /// Permissions of all documents.
    Allowed,
    Palette {
        text: String,
        chosen: usize,
    },
    Find(Search),
    /// Templates and recent documents.
    Welcome(Welcome),
    /// What the user calls something that is kept.
    Name(Naming),
    /// What to do with the colors of a dropped file of this name.
    Colors(String, Vec<(String, Value)>),
}

/// A name that is being typed.
pub(crate) struct Naming {
    pub(crate) of: Named,
    pub(crate) text: String,
    /// Names that are taken: whatever has one of them would be replaced.
    pub(crate) taken: Vec<String>,
}

/// What is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Named {
    Preset,
    Layout,
}

/// An open search in the document.
pub(crate) struct Search {
    pub(crate) text: String,
    pub(crate) chosen: usize,
    /// Everything that can be found.
    pub(crate) entries: Vec<Entry>,
    /// Indices of what fits the text, best first.
    pub(crate) found: Vec<usize>,
}

impl Prompts {
    /// Creates prompts with none open; `data` is the folder for the program's data.
    pub(crate) fn new(data: Option<&Path>) -> Self {
        let json = Filter::new(|path: &Path| path.extension().is_some_and(|end| end == "json"));
        let dialog = crate::dialogs::dialog()
            .add_file_filter("Documents", json)
            .default_file_filter("Documents")
            .add_save_extension("Document", "json")
            .default_save_extension("Document");
        Self { data: data.map(Path::to_path_buf), open: None, dialog, asking: None }
    }

    /// Returns the folder for the program's data.
    pub(crate) fn data(&self) -> Option<&Path> {
        self.data.as_deref()
    }

    /// Returns whether a prompt blocks everything else.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some() || self.asking.is_some()
    }

    /// Asks what to do with unsaved work before the next step.
    pub(crate) fn unsaved(&mut self, after: After) {
        self.open = Some(Prompt::Unsaved(after));
    }

    /// Asks whether to overwrite a document of an unsupported newer version.
    pub(crate) fn newer(&mut self, after: Option<After>) {
        self.open = Some(Prompt::Newer(after));
    }

    /// Asks whether to keep the editor's text or take the one another program wrote. If the text was being saved,
    /// `saving` contains the step that follows.
    pub(crate) fn external(&mut self, saving: Option<Option<After>>) {
        if self.open.is_none() || saving.is_some() {
            self.open = Some(Prompt::External(saving));
        }
    }

    /// Asks whether to stop rendering before the next step.
    pub(crate) fn rendering(&mut self, after: After) {
        self.open = Some(Prompt::Rendering(after));
    }

    /// Asks for permission to access the files that rendering needs.
    pub(crate) fn reach(&mut self, refused: Vec<RefusedFile>) {
        self.open = Some(Prompt::Reach(refused));
    }

    /// Offers backups of editors that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: Vec<UnsavedCopy>) {
        self.open = Some(Prompt::Recover(kept));
    }

    /// Shows the permissions of all documents.
    pub(crate) fn allowed(&mut self) {
        self.open = Some(Prompt::Allowed);
    }

    /// Opens the command palette.
    pub(crate) fn palette(&mut self) {
        self.open = Some(Prompt::Palette { text: String::new(), chosen: 0 });
    }

    /// Shows templates and recent documents, unless something else is asked.
    pub(crate) fn welcome(&mut self, recent: &[PathBuf]) {
        if !self.is_open() {
            self.open = Some(Prompt::Welcome(Welcome::new(recent, self.data.as_deref())));
        }
    }

    /// Asks for a name.
    pub(crate) fn name(&mut self, of: Named, taken: Vec<String>) {
        self.open = Some(Prompt::Name(Naming { of, text: String::new(), taken }));
    }

    /// Opens the search in the document, which has these places.
    pub(crate) fn find(&mut self, entries: Vec<Entry>) {
        let found = crate::document::find::matching(&entries, "");
        self.open = Some(Prompt::Find(Search { text: String::new(), chosen: 0, entries, found }));
    }

    /// Asks what to do with the colors of a dropped file.
    pub(crate) fn take_palette(&mut self, file: String, colors: Vec<(String, Value)>) {
        self.open = Some(Prompt::Colors(file, colors));
    }

    /// Asks for a document to open.
    pub(crate) fn ask_open(&mut self, session: &Session) {
        self.dialog.config_mut().initial_directory = session.folder();
        self.dialog.pick_file();
        self.asking = Some(FileQuestion::Open);
    }

    /// Asks where to save.
    pub(crate) fn ask_save(&mut self, session: &Session, after: Option<After>) {
        let config = self.dialog.config_mut();
        config.initial_directory = session.folder();
        config.default_file_name = match session.file() {
            Some(_) => session.title(),
            None => "untitled.json".into(),
        };
        self.dialog.save_file();
        self.asking = Some(FileQuestion::Save(after));
    }
}

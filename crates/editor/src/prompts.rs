//! Questions: which file, what of unsaved work, which command. The window draws them (`window/questions.rs`).

use crate::actions::After;
use crate::document::Session;
use crate::document::keep::UnsavedCopy;
use egui_file_dialog::{FileDialog, Filter};
use std::path::{Path, PathBuf};
use trochoid::RefusedFile;

/// What is being asked.
pub(crate) struct Prompts {
    data: Option<PathBuf>,
    pub(crate) open: Option<Prompt>,
    pub(crate) dialog: FileDialog,
    /// What the file is for that the dialog asks for.
    pub(crate) asking: Option<FileQuestion>,
}

/// What a file is asked for.
#[derive(Clone, Debug)]
pub(crate) enum FileQuestion {
    Open,
    /// And what comes after it is saved.
    Save(Option<After>),
}

/// A question.
pub(crate) enum Prompt {
    Unsaved(After),
    /// Whether to write over a document of a newer version, and what comes after it.
    Newer(Option<After>),
    /// Which text counts: the file's, or the one here; whether that is to be saved, and what comes after it.
    External(Option<Option<After>>),
    /// Whether to end a run, and what comes after it.
    Rendering(After),
    /// Whether the document may reach further, so that it can be rendered.
    Reach(Vec<RefusedFile>),
    Recover(Vec<UnsavedCopy>),
    /// Whether to write over this file, and what comes after it.
    Replace(PathBuf, Option<After>),
    /// What documents were allowed.
    Allowed,
    Palette {
        text: String,
        chosen: usize,
    },
}

impl Prompts {
    /// No question; `data` is where the program keeps its own data.
    pub(crate) fn new(data: Option<&Path>) -> Self {
        let json = Filter::new(|path: &Path| path.extension().is_some_and(|end| end == "json"));
        let dialog = FileDialog::new()
            .add_file_filter("Documents", json)
            .default_file_filter("Documents")
            .add_save_extension("Document", "json")
            .default_save_extension("Document");
        Self { data: data.map(Path::to_path_buf), open: None, dialog, asking: None }
    }

    /// Where the program keeps its own data.
    pub(crate) fn data(&self) -> Option<&Path> {
        self.data.as_deref()
    }

    /// Whether an answer is needed before anything else.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some() || self.asking.is_some()
    }

    /// Asks what is to become of unsaved work before something else.
    pub(crate) fn unsaved(&mut self, after: After) {
        self.open = Some(Prompt::Unsaved(after));
    }

    /// Asks whether to write over a document of a version that is not known here.
    pub(crate) fn newer(&mut self, after: Option<After>) {
        self.open = Some(Prompt::Newer(after));
    }

    /// Asks what counts: what is here, or what another program wrote. Where what is here was to be saved, `saving` says what
    /// was to come after that.
    pub(crate) fn external(&mut self, saving: Option<Option<After>>) {
        if self.open.is_none() || saving.is_some() {
            self.open = Some(Prompt::External(saving));
        }
    }

    /// Asks whether to end a run before something else.
    pub(crate) fn rendering(&mut self, after: After) {
        self.open = Some(Prompt::Rendering(after));
    }

    /// Asks whether the document may reach files that it needs to be rendered.
    pub(crate) fn reach(&mut self, refused: Vec<RefusedFile>) {
        self.open = Some(Prompt::Reach(refused));
    }

    /// Offers work that was kept of editors that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: Vec<UnsavedCopy>) {
        self.open = Some(Prompt::Recover(kept));
    }

    /// Shows which folders documents were allowed, to take them back.
    pub(crate) fn allowed(&mut self) {
        self.open = Some(Prompt::Allowed);
    }

    /// Asks for a command.
    pub(crate) fn palette(&mut self) {
        self.open = Some(Prompt::Palette { text: String::new(), chosen: 0 });
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

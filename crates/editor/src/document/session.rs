//! An open document: its text, its undo history, and its interpretation.

use super::change::Edit;
use super::decor;
use super::history::{Change, History};
use super::json::{Misplaced, Splice};
use super::meaning::Meaning;
use super::relocate::{NoText, relocated};
use super::sheet::Sheet;
use super::{swatches, trial};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trochoid::{Access, Diagnostic, OutputError};

/// Counter for revisions: every text of every document gets a unique number.
static REVISIONS: AtomicU64 = AtomicU64::new(1);

/// Why a document is not saved.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// One of its paths leads nowhere from there.
    #[error(transparent)]
    Path(#[from] NoText),
    /// Its paths cannot be written anew.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
}

/// An open document. The text is the document; everything else is derived from it.
#[derive(Debug)]
pub struct Session {
    text: String,
    file: Option<PathBuf>,
    /// Folder that paths are relative to as long as there is no file; `None` is the current one.
    base: Option<PathBuf>,
    history: History,
    revision: u64,
    meaning: Meaning,
    /// The text in the file, as far as this session knows.
    stored: Option<String>,
    access: Access,
}

/// Document shown in a new window: a sea to start from.
pub const NEW: &str = include_str!("../../templates/new.json");

impl Session {
    /// Creates a session for a text and the file it came from. The path is made absolute, because backups and
    /// permissions stored under it must stay valid wherever the editor is started next.
    pub fn new(text: String, file: Option<PathBuf>) -> Self {
        let file = file.map(|file| std::path::absolute(&file).unwrap_or(file));
        let mut session = Self {
            stored: Some(text.clone()),
            access: Access::usual(&folder_of(file.as_deref())),
            text,
            file,
            base: None,
            history: History::default(),
            revision: 0,
            meaning: Meaning::default(),
        };
        session.understand();
        session
    }

    /// Creates a session for a document without a file, whose paths are relative to a folder until it is saved.
    pub fn based(text: String, folder: &Path) -> Self {
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
        let mut session = Self { access: Access::usual(&folder), base: Some(folder), ..Self::new(text, None) };
        session.understand();
        session
    }

    /// Opens a file. Any text file opens, even if the document is invalid.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is not text, or is too large.
    pub fn open(file: &Path) -> Result<Self, trochoid::io::Error> {
        Ok(Self::new(read(file)?, Some(file.into())))
    }

    fn understand(&mut self) {
        self.mean(self.meaning_of(&self.text));
    }

    /// Reads the files that are part of the document again, because they have changed.
    pub fn reread(&mut self) {
        self.understand();
    }

    /// Returns the other files that are part of the document: those that it includes, and that of its palette.
    pub fn parts(&self) -> BTreeSet<PathBuf> {
        let (sheet, folder) = (self.sheet(), self.folder());
        let palette = swatches::file(sheet).map(String::from);
        sheet.library.files().iter().cloned().chain(palette).map(|file| folder.join(file)).collect()
    }

    fn meaning_of(&self, text: &str) -> Meaning {
        Meaning::of(&self.name(), text, &self.folder(), &self.access)
    }

    fn mean(&mut self, meaning: Meaning) {
        self.revision = REVISIONS.fetch_add(1, Ordering::Relaxed);
        let before = std::mem::replace(&mut self.meaning, meaning);
        if !self.meaning.readable {
            // The last drawn sheet stays visible until the text can be parsed again.
            self.meaning.sheet = before.sheet;
        }
    }

    /// Returns the text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the document's file.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Returns the name used in messages.
    pub fn name(&self) -> String {
        self.file.as_ref().map_or_else(|| "untitled.json".into(), |file| file.display().to_string())
    }

    /// Returns the file name without its folder.
    pub fn title(&self) -> String {
        let name = self.file.as_ref().and_then(|file| file.file_name());
        name.map_or_else(|| "untitled".into(), |name| name.to_string_lossy().into_owned())
    }

    /// Returns the folder that paths in the document are relative to.
    pub fn folder(&self) -> PathBuf {
        match (&self.file, &self.base) {
            (None, Some(base)) => base.clone(),
            (file, _) => folder_of(file.as_deref()),
        }
    }

    /// Returns the files that the document may access; initially [`Access::usual`].
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Changes the files that the document may access, and reinterprets the document.
    pub fn set_access(&mut self, access: Access) {
        if self.access != access {
            self.access = access;
            self.understand();
        }
    }

    /// Returns the revision: a number unique to this text, which grows with every change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Returns the interpretation of the text.
    pub fn meaning(&self) -> &Meaning {
        &self.meaning
    }

    /// Returns the sheet that the canvas draws.
    pub fn sheet(&self) -> &Arc<Sheet> {
        &self.meaning.sheet
    }

    /// Returns the undo history.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Returns whether there are unsaved changes.
    pub fn is_changed(&self) -> bool {
        !self.history.is_saved() && self.stored.as_ref() != Some(&self.text)
    }

    /// Applies an edit as one step of undo.
    ///
    /// # Errors
    /// Fails if the edit names a place that does not exist; nothing changes then.
    pub fn edit(&mut self, edit: Edit) -> Result<(), Misplaced> {
        self.make(edit, |_, _, _| None).map(|_| ())
    }

    /// Applies an edit of one value like [`edit`](Self::edit), unless the value would cause a new fault: then the fault
    /// is returned, and nothing changes.
    ///
    /// # Errors
    /// Fails like [`edit`](Self::edit).
    pub fn give(&mut self, edit: Edit) -> Result<Option<Diagnostic>, Misplaced> {
        self.make(edit, trial::fault)
    }

    fn make(
        &mut self,
        edit: Edit,
        fault: impl FnOnce(&Edit, &Meaning, &Meaning) -> Option<Diagnostic>,
    ) -> Result<Option<Diagnostic>, Misplaced> {
        let edit = decor::following(self.sheet(), edit);
        let (text, splices) = edit.applied(&self.text)?;
        if splices.is_empty() {
            return Ok(None);
        }
        let meaning = self.meaning_of(&text);
        let fault = fault(&edit, &self.meaning, &meaning);
        if fault.is_none() {
            self.text = text;
            self.history.push(Change { label: edit.label, merge: edit.merge, splices });
            self.mean(meaning);
        }
        Ok(fault)
    }

    /// Replaces the whole text, as one step of undo.
    pub fn replace(&mut self, text: &str, label: &str) {
        let splice = Splice::between(&self.text, text);
        if splice.removed != splice.inserted {
            self.text = text.into();
            self.history.push(Change { label: label.into(), merge: None, splices: vec![splice] });
            self.understand();
        }
    }

    /// Returns the interpretation that the document would have after an edit, without applying it.
    ///
    /// # Errors
    /// Fails if the edit names a place that does not exist.
    pub fn after(&self, edit: &Edit) -> Result<Meaning, Misplaced> {
        Ok(self.meaning_of(&edit.applied(&self.text)?.0))
    }

    /// Ends a gesture: the next change becomes a step of its own.
    pub fn seal(&mut self) {
        self.history.seal();
    }

    /// Undoes the last step and returns its label.
    pub fn undo(&mut self) -> Option<String> {
        let label = self.history.undo(&mut self.text)?.to_string();
        self.understand();
        Some(label)
    }

    /// Redoes the last undone step and returns its label.
    pub fn redo(&mut self) -> Option<String> {
        let label = self.history.redo(&mut self.text)?.to_string();
        self.understand();
        Some(label)
    }

    /// Writes the document to a file atomically; it becomes the document's file. If the folder changes, relative paths
    /// are rewritten to keep referring to the same files, as one step of undo; returns their number. Permissions given
    /// under the old path do not carry over.
    ///
    /// # Errors
    /// Fails if the file cannot be written or a path cannot be rewritten; nothing changes then.
    pub fn save(&mut self, file: &Path) -> Result<usize, SaveError> {
        let moves = self.file.as_deref() != Some(file) && self.meaning.readable;
        let edit = match file.parent().filter(|_| moves) {
            Some(folder) => relocated(self.sheet(), &self.folder(), folder, self.file.is_some())?,
            None => Edit::new("Save", Vec::new()),
        };
        let (text, splices) = edit.applied(&self.text)?;
        trochoid::write_whole(file, text.as_bytes())?;
        self.stored = Some(text.clone());
        self.text = text;
        if !splices.is_empty() {
            self.history.seal();
            self.history.push(Change { label: edit.label, merge: None, splices });
        }
        self.history.mark_saved();
        if self.file.as_deref() != Some(file) {
            self.file = Some(file.into());
            self.access = Access::usual(&self.folder());
            self.understand();
        }
        Ok(edit.ops.len())
    }

    /// Returns whether the file's text differs from the one last read or written; `None` if it cannot be read.
    pub fn differs_on_disk(&self) -> Option<bool> {
        let there = read(self.file.as_deref()?).ok()?;
        Some(self.stored.as_ref() != Some(&there))
    }

    /// Reloads the text from the file, as one step of undo.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn reload(&mut self) -> Result<(), trochoid::io::Error> {
        let Some(file) = &self.file else { return Ok(()) };
        let text = read(file)?;
        self.replace(&text, "Reload the file");
        self.stored = Some(text);
        self.history.mark_saved();
        Ok(())
    }

    /// Keeps the text in the editor although the file has changed: the next save overwrites the file.
    pub fn keep_mine(&mut self) {
        if let Some(text) = self.file.as_deref().and_then(|file| read(file).ok()) {
            self.stored = Some(text);
        }
        self.history.mark_changed();
    }

    /// Restores a backup left by an editor that ended unexpectedly, as one step of undo. If the file was `overtaken`
    /// (changed by another program since), it counts as changed on disk, so that saving asks first.
    pub fn recover(&mut self, text: &str, overtaken: bool) {
        self.replace(text, "Recover unsaved work");
        if overtaken {
            self.stored = None;
        }
    }
}

fn folder_of(file: Option<&Path>) -> PathBuf {
    let folder = file.and_then(Path::parent).map(Path::to_path_buf);
    folder.unwrap_or_else(|| std::env::current_dir().unwrap_or_default())
}

/// Maximum size of a document, in bytes.
const MOST_BYTES: u64 = 64 << 20;

fn read(file: &Path) -> Result<String, trochoid::io::Error> {
    trochoid::io::read_text(file, MOST_BYTES)
}

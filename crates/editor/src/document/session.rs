//! One open document: its text, what became of it, and what it means.

use super::change::Edit;
use super::decor;
use super::history::{Change, History};
use super::json::{Misplaced, Splice};
use super::meaning::Meaning;
use super::relocate::{NoText, relocated};
use super::sheet::Sheet;
use super::trial;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trochoid::{Access, Diagnostic, OutputError};

/// Counts the texts of all documents: no two have one number.
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

/// An open document. Its text is the document; everything else here is read from it.
#[derive(Debug)]
pub struct Session {
    text: String,
    file: Option<PathBuf>,
    history: History,
    revision: u64,
    meaning: Meaning,
    /// The text that is in the file, as far as this session knows.
    stored: Option<String>,
    access: Access,
}

/// The document that a new window shows: a light on a ramp, so that there is something to play with.
pub const NEW: &str = r##"{
  "trochoid": 1,
  "format": { "width": 1280, "height": 720, "samples": 1 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 96, "fps": 24 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.6, "color": "#b98a63" }, { "at": 1, "color": "#f0cf8e" }
    ] }
  },
  "outputs": {
    "beauty": { "color": "sky", "file": "beauty.####.png", "require": { "guarantee": "hull" } }
  }
}
"##;

impl Session {
    /// A document of this text, from this file. Its path is made absolute: what is kept of the document must find it again from
    /// wherever the editor is started next.
    pub fn new(text: String, file: Option<PathBuf>) -> Self {
        let file = file.map(|file| std::path::absolute(&file).unwrap_or(file));
        let mut session = Self {
            stored: Some(text.clone()),
            access: Access::usual(&folder_of(file.as_deref())),
            text,
            file,
            history: History::default(),
            revision: 0,
            meaning: Meaning::default(),
        };
        session.understand();
        session
    }

    /// Opens a file. One with faults opens too, as long as it is text.
    ///
    /// # Errors
    /// It cannot be read, or is no text, or far too large.
    pub fn open(file: &Path) -> Result<Self, trochoid::io::Error> {
        Ok(Self::new(read(file)?, Some(file.into())))
    }

    fn understand(&mut self) {
        self.mean(self.meaning_of(&self.text));
    }

    fn meaning_of(&self, text: &str) -> Meaning {
        Meaning::of(&self.name(), text, &self.folder(), &self.access)
    }

    fn mean(&mut self, meaning: Meaning) {
        self.revision = REVISIONS.fetch_add(1, Ordering::Relaxed);
        let before = std::mem::replace(&mut self.meaning, meaning);
        if !self.meaning.readable {
            // What was drawn last stays in sight until the text can be read again.
            self.meaning.sheet = before.sheet;
        }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Where it is stored.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// What stands for it in messages.
    pub fn name(&self) -> String {
        self.file.as_ref().map_or_else(|| "untitled.json".into(), |file| file.display().to_string())
    }

    /// Its name without the folders.
    pub fn title(&self) -> String {
        let name = self.file.as_ref().and_then(|file| file.file_name());
        name.map_or_else(|| "untitled".into(), |name| name.to_string_lossy().into_owned())
    }

    /// What its paths are relative to.
    pub fn folder(&self) -> PathBuf {
        folder_of(self.file.as_deref())
    }

    /// Which files it may reach: at first the usual ones, see [`Access::usual`].
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Lets it reach other files than before. What was made of it is out of date then.
    pub fn set_access(&mut self, access: Access) {
        if self.access != access {
            self.access = access;
            self.understand();
        }
    }

    /// Grows with every change, so that what was made of an older text, or of another document, can be told.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// What the text means.
    pub fn meaning(&self) -> &Meaning {
        &self.meaning
    }

    /// What the canvas draws.
    pub fn sheet(&self) -> &Arc<Sheet> {
        &self.meaning.sheet
    }

    /// What was done.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Whether there is something to save.
    pub fn is_changed(&self) -> bool {
        !self.history.is_saved() && self.stored.as_ref() != Some(&self.text)
    }

    /// Makes a change, as one step of undo.
    ///
    /// # Errors
    /// It names a place that is not there; nothing changes then.
    pub fn edit(&mut self, edit: Edit) -> Result<(), Misplaced> {
        self.make(edit, |_, _, _| None).map(|_| ())
    }

    /// Makes a change of one value, as [`edit`](Self::edit) does, unless the value would be a fault where there was none:
    /// that fault is the result, and nothing changes.
    ///
    /// # Errors
    /// As for [`edit`](Self::edit).
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

    /// What the document would mean after a change, which is not made.
    ///
    /// # Errors
    /// It names a place that is not there.
    pub fn after(&self, edit: &Edit) -> Result<Meaning, Misplaced> {
        Ok(self.meaning_of(&edit.applied(&self.text)?.0))
    }

    /// Ends a gesture: what comes next is a step of its own.
    pub fn seal(&mut self) {
        self.history.seal();
    }

    /// Takes back the last change, and says what it was.
    pub fn undo(&mut self) -> Option<String> {
        let label = self.history.undo(&mut self.text)?.to_string();
        self.understand();
        Some(label)
    }

    /// Makes the change again that was taken back last, and says what it was.
    pub fn redo(&mut self) -> Option<String> {
        let label = self.history.redo(&mut self.text)?.to_string();
        self.understand();
        Some(label)
    }

    /// Writes the document to a file, whole or not at all, which is its file from then on. In another folder its relative
    /// paths are written anew, as one step of undo, so that they lead to the same files; how many is the result. What was
    /// allowed under the path before is not under another.
    ///
    /// # Errors
    /// The file cannot be written, or a path cannot lead on from there; all stays as it was.
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

    /// Whether the file holds another text than the one that this session read or wrote; `None` where it cannot be read.
    pub fn differs_on_disk(&self) -> Option<bool> {
        let there = read(self.file.as_deref()?).ok()?;
        Some(self.stored.as_ref() != Some(&there))
    }

    /// Takes what is in the file now, as one step of undo.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn reload(&mut self) -> Result<(), trochoid::io::Error> {
        let Some(file) = &self.file else { return Ok(()) };
        let text = read(file)?;
        self.replace(&text, "Reload the file");
        self.stored = Some(text);
        self.history.mark_saved();
        Ok(())
    }

    /// Keeps what is here although the file has changed: saving writes over it.
    pub fn keep_mine(&mut self) {
        if let Some(text) = self.file.as_deref().and_then(|file| read(file).ok()) {
            self.stored = Some(text);
        }
        self.history.mark_changed();
    }

    /// Takes back a text that was kept when the program ended unexpectedly, as one step of undo. Where the file was `overtaken`
    /// by another program since then, it counts as changed: saving must ask.
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

/// Most bytes of a document.
const MOST_BYTES: u64 = 64 << 20;

fn read(file: &Path) -> Result<String, trochoid::io::Error> {
    trochoid::io::read_text(file, MOST_BYTES)
}

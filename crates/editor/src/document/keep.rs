//! Backup copies of unsaved work, kept with the program's data until the document is saved or closed.
//!
//! Every running editor locks a copy of its own. A copy without a lock belongs to an editor that ended unexpectedly.

use serde_json::{Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// Maximum delay between a change and its backup.
pub const AFTER: Duration = Duration::from_millis(800);

/// Maximum size of a backup: a document in which JSON escapes every byte.
const MOST_BYTES: u64 = 512 << 20;

/// Writes the backup of one running editor.
#[derive(Debug)]
pub struct Keeper {
    path: PathBuf,
    lock: PathBuf,
    /// Lock file, open and locked while the editor runs.
    held: Option<File>,
    tasks: Option<Sender<Task>>,
    writer: Option<JoinHandle<()>>,
}

#[derive(Debug)]
enum Task {
    Keep(String),
    /// Take over from the copy of an ended editor: remove it once the new copy is written.
    Replace(UnsavedCopy),
    Drop,
}

/// A backup left by an ended editor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsavedCopy {
    /// File of the backup.
    pub path: PathBuf,
    /// File of the document; `None` if it was never saved.
    pub file: Option<PathBuf>,
    /// Text of the document.
    pub text: String,
    /// Time of the backup.
    pub when: SystemTime,
    /// Whether the document's file was changed after the backup.
    pub overtaken: bool,
}

impl UnsavedCopy {
    /// Returns whether the document's file already has this text, so that there is nothing to recover.
    pub fn is_saved(&self) -> bool {
        let text = self.file.as_ref().and_then(|file| trochoid::io::read_text(file, MOST_BYTES).ok());
        text.is_some_and(|text| text == self.text)
    }
}

impl Keeper {
    /// Starts a keeper in a folder, creating the folder if necessary.
    ///
    /// # Errors
    /// Fails if no files can be created in the folder.
    pub fn new(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        tidy(folder);
        let (path, lock, held) = (0..10_000)
            .find_map(|number| {
                let stem = format!("{}-{number}", std::process::id());
                if folder.join(format!("{stem}.json")).exists() {
                    // Written by an ended editor with the same process id: must not be overwritten.
                    return None;
                }
                let lock = folder.join(format!("{stem}.lock"));
                let file = File::create(&lock).ok()?;
                file.try_lock().ok()?;
                Some((folder.join(format!("{stem}.json")), lock, file))
            })
            .ok_or_else(|| std::io::Error::other(format!("{}: takes no locks", folder.display())))?;
        let (tasks, inbox) = channel();
        let target = path.clone();
        let writer = std::thread::Builder::new().name("keeper".into()).spawn(move || write(&target, &inbox))?;
        Ok(Self { path, lock, held: Some(held), tasks: Some(tasks), writer: Some(writer) })
    }

    fn send(&self, task: Task) {
        if let Some(tasks) = &self.tasks {
            // The writer thread ends only with the keeper.
            let _ = tasks.send(task);
        }
    }

    /// Saves a backup of a text without waiting for the disk. If the file's name is not Unicode, the backup counts as
    /// one of an unsaved document.
    pub fn keep(&self, file: Option<&Path>, text: &str) {
        let file = file.and_then(Path::to_str);
        self.send(Task::Keep(json!({ "file": file, "text": text }).to_string()));
    }

    /// Removes a recovered backup once the latest text is written to this editor's own.
    pub fn replace(&self, old: UnsavedCopy) {
        self.send(Task::Replace(old));
    }

    /// Removes the backup, because there is no unsaved work.
    pub fn forget(&self) {
        self.send(Task::Drop);
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.tasks = None;
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
        // Closing the window has already asked about unsaved work.
        if !std::thread::panicking() {
            let _ = std::fs::remove_file(&self.path);
        }
        // Released last, so that no other editor finds the copy without a lock.
        self.held = None;
        let _ = std::fs::remove_file(&self.lock);
    }
}

fn write(path: &Path, inbox: &Receiver<Task>) {
    // Recovered backups whose text is not yet written to the new copy.
    let mut old: Vec<UnsavedCopy> = Vec::new();
    while let Ok(first) = inbox.recv() {
        // Only the newest text is written.
        let mut newest = None;
        for task in std::iter::once(first).chain(inbox.try_iter()) {
            match task {
                Task::Keep(text) => newest = Some(Some(text)),
                Task::Drop => newest = Some(None),
                Task::Replace(kept) => old.push(kept),
            }
        }
        let is_done = match newest {
            // A full disk must not interrupt work; saving will report it.
            Some(Some(text)) => trochoid::write_whole(path, text.as_bytes()).is_ok(),
            Some(None) => {
                let _ = std::fs::remove_file(path);
                true
            }
            None => path.exists(),
        };
        if is_done {
            old.drain(..).for_each(|kept| discard(&kept));
        }
    }
}

/// Returns the backups of ended editors in a folder, newest first.
pub fn kept(folder: &Path) -> Vec<UnsavedCopy> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.flatten().map(|entry| entry.path());
    let mut found: Vec<UnsavedCopy> =
        paths.filter(|path| path.extension().is_some_and(|end| end == "json")).filter_map(read).collect();
    found.sort_by_key(|kept| std::cmp::Reverse(kept.when));
    found
}

fn read(path: PathBuf) -> Option<UnsavedCopy> {
    if let Ok(lock) = File::open(path.with_extension("lock"))
        && lock.try_lock().is_err()
    {
        return None;
    }
    let when = std::fs::metadata(&path).ok()?.modified().ok()?;
    let value: Value = serde_json::from_str(&trochoid::io::read_text(&path, MOST_BYTES).ok()?).ok()?;
    // A relative path is useless: its base folder is unknown.
    let file = value.get("file").and_then(Value::as_str).map(PathBuf::from).filter(|file| file.is_absolute());
    let changed = file.as_ref().and_then(|file| std::fs::metadata(file).ok()?.modified().ok());
    let overtaken = changed.is_some_and(|changed| changed > when);
    Some(UnsavedCopy { file, text: value.get("text")?.as_str()?.into(), when, overtaken, path })
}

/// Minimum age of an unheld lock file before it is removed; a younger one may be about to be locked.
const YOUNG: Duration = Duration::from_secs(60);

/// Removes lock files of ended editors that left no backup.
fn tidy(folder: &Path) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let is_lock = path.extension().is_some_and(|end| end == "lock") && !path.with_extension("json").exists();
        let Ok(lock) = File::open(&path) else { continue };
        let age = lock.metadata().and_then(|data| data.modified()).ok().and_then(|when| when.elapsed().ok());
        if is_lock && age.is_some_and(|age| age > YOUNG) && lock.try_lock().is_ok() {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Deletes a backup and its lock file.
pub fn discard(kept: &UnsavedCopy) {
    let _ = std::fs::remove_file(&kept.path);
    let _ = std::fs::remove_file(kept.path.with_extension("lock"));
}

//! Copies of unsaved work, kept beside the program's other data until the document is saved or closed.
//!
//! Every running editor has a copy of its own and holds a lock on it. A copy without a lock is of one that ended
//! unexpectedly.

use serde_json::{Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// How long after a change its copy is kept at the latest.
pub const AFTER: Duration = Duration::from_millis(800);

/// Most bytes of a copy: a document, of which JSON may escape every byte.
const MOST_BYTES: u64 = 512 << 20;

/// Keeps the copy of one running editor.
#[derive(Debug)]
pub struct Keeper {
    path: PathBuf,
    lock: PathBuf,
    /// Open and locked as long as the editor runs.
    held: Option<File>,
    tasks: Option<Sender<Task>>,
    writer: Option<JoinHandle<()>>,
}

#[derive(Debug)]
enum Task {
    Keep(String),
    /// Take the place of a copy whose editor has ended, as soon as our own is there.
    Replace(UnsavedCopy),
    Drop,
}

/// A copy whose editor has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsavedCopy {
    /// The copy.
    pub path: PathBuf,
    /// The document that it is of; `None` for one never saved.
    pub file: Option<PathBuf>,
    /// The document's text.
    pub text: String,
    /// When it was kept.
    pub when: SystemTime,
    /// Whether the document's file was changed after that.
    pub overtaken: bool,
}

impl UnsavedCopy {
    /// Whether its document has the text by now: there is nothing to recover then.
    pub fn is_saved(&self) -> bool {
        let text = self.file.as_ref().and_then(|file| trochoid::io::read_text(file, MOST_BYTES).ok());
        text.is_some_and(|text| text == self.text)
    }
}

impl Keeper {
    /// Starts keeping in a folder, which is made.
    ///
    /// # Errors
    /// The folder takes no files.
    pub fn new(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        tidy(folder);
        let (path, lock, held) = (0..10_000)
            .find_map(|number| {
                let stem = format!("{}-{number}", std::process::id());
                if folder.join(format!("{stem}.json")).exists() {
                    // Kept by one of the same number that has ended: not ours to write over.
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
            // The writer ends with the keeper only.
            let _ = tasks.send(task);
        }
    }

    /// Keeps a text, without waiting for the disk; that of a file whose name is no Unicode as of one never saved.
    pub fn keep(&self, file: Option<&Path>, text: &str) {
        let file = file.and_then(Path::to_str);
        self.send(Task::Keep(json!({ "file": file, "text": text }).to_string()));
    }

    /// Removes a copy that was recovered, as soon as what was kept here last is on the disk.
    pub fn replace(&self, old: UnsavedCopy) {
        self.send(Task::Replace(old));
    }

    /// Takes the copy away: there is nothing that could be lost.
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
        // A window that closes has asked what is to become of unsaved work.
        if !std::thread::panicking() {
            let _ = std::fs::remove_file(&self.path);
        }
        // Last, so that nobody finds the copy without its lock.
        self.held = None;
        let _ = std::fs::remove_file(&self.lock);
    }
}

fn write(path: &Path, inbox: &Receiver<Task>) {
    // What was recovered and is not on the disk anew.
    let mut old: Vec<UnsavedCopy> = Vec::new();
    while let Ok(first) = inbox.recv() {
        // Only the newest text counts.
        let mut newest = None;
        for task in std::iter::once(first).chain(inbox.try_iter()) {
            match task {
                Task::Keep(text) => newest = Some(Some(text)),
                Task::Drop => newest = Some(None),
                Task::Replace(kept) => old.push(kept),
            }
        }
        let is_done = match newest {
            // A full disk must not stop the work; saving will say so.
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

/// The copies in a folder whose editors have ended, the newest first.
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
    // A relative path says nothing: nobody knows from where.
    let file = value.get("file").and_then(Value::as_str).map(PathBuf::from).filter(|file| file.is_absolute());
    let changed = file.as_ref().and_then(|file| std::fs::metadata(file).ok()?.modified().ok());
    let overtaken = changed.is_some_and(|changed| changed > when);
    Some(UnsavedCopy { file, text: value.get("text")?.as_str()?.into(), when, overtaken, path })
}

/// How old a lock must be that nobody holds: a younger one may be about to be taken.
const YOUNG: Duration = Duration::from_secs(60);

/// Removes locks of editors that have ended and left no copy.
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

/// Removes a copy for good.
pub fn discard(kept: &UnsavedCopy) {
    let _ = std::fs::remove_file(&kept.path);
    let _ = std::fs::remove_file(kept.path.with_extension("lock"));
}

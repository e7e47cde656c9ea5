//! Watches files for changes by other programs: the document's, and those that are part of it.

use egui::Context;
use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time without further changes after which changed files are told: programs write a file in several steps.
const SETTLED: Duration = Duration::from_millis(100);

/// Watcher for the document and for the files that are part of it.
#[derive(Default)]
pub(crate) struct Watcher {
    watcher: Option<RecommendedWatcher>,
    seen: Arc<Mutex<Seen>>,
}

/// What is watched, and what has happened to it.
#[derive(Default)]
struct Seen {
    document: Option<PathBuf>,
    parts: BTreeSet<PathBuf>,
    is_changed: bool,
    changed: BTreeSet<PathBuf>,
    /// Time of the last change of a part.
    since: Option<Instant>,
}

fn locked(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watcher {
    /// Watches a document and the files that are part of it instead of any others.
    pub(crate) fn watch(&mut self, document: Option<&Path>, parts: &BTreeSet<PathBuf>, context: &Context) {
        // Links are resolved, because saving writes to their target.
        let document = document.map(trochoid::resolved);
        let parts: BTreeSet<PathBuf> = parts.iter().map(|part| trochoid::resolved(part)).collect();
        let known = locked(&self.seen);
        if self.watcher.is_some() && (&known.document, &known.parts) == (&document, &parts) {
            return;
        }
        // What has happened to the same document is not forgotten.
        let is_changed = known.is_changed && known.document == document;
        drop(known);
        // The folders are watched, because programs often replace files instead of writing to them.
        let folders: BTreeSet<PathBuf> =
            document.iter().chain(&parts).filter_map(|file| file.parent().map(Path::to_path_buf)).collect();
        self.watcher = None;
        self.seen = Arc::new(Mutex::new(Seen { document, parts, is_changed, ..Seen::default() }));
        if folders.is_empty() {
            return;
        }
        let (seen, context) = (self.seen.clone(), context.clone());
        let tell = move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            if !event.kind.is_access() && locked(&seen).hear(&event.paths) {
                context.request_repaint();
            }
        };
        // If watching fails, saving still checks the file. Folders that do not exist have nothing to watch.
        self.watcher = notify::recommended_watcher(tell).ok();
        for folder in folders {
            let _ = self.watcher.as_mut().map(|watcher| watcher.watch(&folder, RecursiveMode::NonRecursive));
        }
    }

    /// Returns whether the document's file may have changed since the last call.
    pub(crate) fn changed(&mut self) -> bool {
        std::mem::take(&mut locked(&self.seen).is_changed)
    }

    /// Returns the other files that may have changed since the last call, once they are at rest.
    pub(crate) fn changed_parts(&mut self, context: &Context) -> BTreeSet<PathBuf> {
        let mut seen = locked(&self.seen);
        let Some(since) = seen.since else { return BTreeSet::new() };
        match SETTLED.checked_sub(since.elapsed()) {
            Some(left) if !left.is_zero() => {
                context.request_repaint_after(left);
                BTreeSet::new()
            }
            _ => {
                seen.since = None;
                std::mem::take(&mut seen.changed)
            }
        }
    }
}

impl Seen {
    /// Notes files that have changed; returns whether any of them is watched.
    fn hear(&mut self, files: &[PathBuf]) -> bool {
        let mut is_ours = false;
        for file in files {
            if self.document.as_ref() == Some(file) {
                (self.is_changed, is_ours) = (true, true);
            }
            if self.parts.contains(file) {
                self.changed.insert(file.clone());
                (self.since, is_ours) = (Some(Instant::now()), true);
            }
        }
        is_ours
    }
}

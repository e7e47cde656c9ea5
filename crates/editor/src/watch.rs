//! Watches the document's file for changes by other programs.

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Watcher for one file.
#[derive(Default)]
pub(crate) struct Watcher {
    watcher: Option<RecommendedWatcher>,
    changed: Arc<AtomicBool>,
}

impl Watcher {
    /// Watches this file instead of any other.
    pub(crate) fn watch(&mut self, file: Option<&Path>, context: &egui::Context) {
        self.watcher = None;
        self.changed = Arc::default();
        // Links are resolved, because saving writes to their target.
        let Some(file) = file.map(trochoid::resolved) else { return };
        // The folder is watched, because programs often replace files instead of writing to them.
        let Some(folder) = file.parent().map(Path::to_path_buf) else { return };
        let (changed, context) = (self.changed.clone(), context.clone());
        let name = file.file_name().map(std::ffi::OsStr::to_os_string);
        let tell = move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            let ours = event.paths.iter().any(|path| path.file_name() == name.as_deref());
            if ours && !event.kind.is_access() {
                changed.store(true, Ordering::Relaxed);
                context.request_repaint();
            }
        };
        let watcher = notify::recommended_watcher(tell).and_then(|mut watcher| {
            watcher.watch(&folder, RecursiveMode::NonRecursive)?;
            Ok(watcher)
        });
        // If watching fails, saving still checks the file.
        self.watcher = watcher.ok();
    }

    /// Returns whether the file may have changed since the last call.
    pub(crate) fn changed(&mut self) -> bool {
        self.changed.swap(false, Ordering::Relaxed)
    }
}

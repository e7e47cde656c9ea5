//! Tells when the document's file is changed by another program.

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Watches one file.
#[derive(Default)]
pub(crate) struct Watcher {
    watcher: Option<RecommendedWatcher>,
    changed: Arc<AtomicBool>,
}

impl Watcher {
    /// Watches this file and no other.
    pub(crate) fn watch(&mut self, file: Option<&Path>, context: &egui::Context) {
        self.watcher = None;
        self.changed = Arc::default();
        // Where it leads: that is what is written to.
        let Some(file) = file.map(trochoid::resolved) else { return };
        // Files are often replaced and not written to, so their folder is watched.
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
        // Where nothing can be watched, saving looks at the file.
        self.watcher = watcher.ok();
    }

    /// Whether it may have changed since this was asked last.
    pub(crate) fn changed(&mut self) -> bool {
        self.changed.swap(false, Ordering::Relaxed)
    }
}

//! Files that are part of the document, such as those that it includes: a change by another program is taken at once.

use super::Editor;
use crate::document::edit;
use egui::Context;
use std::path::Path;

impl Editor {
    /// Watches the files that the document has by now, and takes their changes.
    pub(super) fn hear_files(&mut self, context: &Context) {
        let revision = self.state.session.revision();
        if self.watched != revision {
            self.watched = revision;
            self.watcher.watch(self.state.session.file(), &self.state.session.parts(), context);
        }
        if self.watcher.changed() && self.state.session.differs_on_disk() == Some(true) {
            self.prompts.external(None);
        }
        let changed = self.watcher.changed_parts(context);
        if changed.is_empty() {
            return;
        }
        self.state.session.reread();
        self.changed();
        let names: Vec<&str> =
            changed.iter().filter_map(|file| file.file_name()).filter_map(|name| name.to_str()).collect();
        let what = match names[..] {
            [name] => format!("{name} has changed and was read again"),
            _ => format!("{} have changed and were read again: {}", edit::count(names.len(), "file"), names.join(", ")),
        };
        self.notices.info(what);
    }

    /// Watches another file as the document's.
    pub(super) fn watch(&mut self, file: Option<&Path>, context: &Context) {
        self.watched = self.state.session.revision();
        self.watcher.watch(file, &self.state.session.parts(), context);
    }
}

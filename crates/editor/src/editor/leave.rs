//! Leaving the open document, and saving it first.

use super::Editor;
use crate::actions::After;
use crate::document::keep::UnsavedCopy;
use crate::document::{Session, VersionStatus, edit};
use egui::Context;
use std::path::Path;

/// Outcome reported if pending text that is not JSON prevents saving.
const NOT_SAVED: &str = "Nothing was saved";

impl Editor {
    /// Leaves the document for another step. If there is unsaved work, or closing would end a rendering, a prompt comes
    /// first.
    pub(crate) fn leave(&mut self, after: After, context: &Context) {
        if self.renderer.is_some() && matches!(after, After::Close) {
            self.prompts.rendering(after);
        } else if self.is_unsaved() {
            self.prompts.unsaved(after);
        } else {
            self.go(after, context);
        }
    }

    /// Performs the next step, discarding unsaved work.
    pub(crate) fn go(&mut self, after: After, context: &Context) {
        match after {
            After::New => self.start_new(context),
            After::Template(name) => self.start_template(name, context),
            After::Ask => self.prompts.ask_open(&self.state.session),
            After::Open(file) => match Session::open(&file) {
                Ok(session) => {
                    self.start(session, context);
                    self.offer();
                }
                Err(error) => {
                    self.notices.error(error);
                    self.offer_lost(&file);
                }
            },
            After::Render => self.render(context),
            After::Close => {
                self.keep_recent_picture();
                self.closing = true;
                context.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// Saves to the document's file, or asks for one; then performs the next step.
    pub(crate) fn store(&mut self, after: Option<After>, context: &Context) {
        if !self.settle(NOT_SAVED) {
            return;
        }
        let session = &self.state.session;
        let newer = VersionStatus::of(&session.sheet().value).is_newer();
        match session.file().map(Path::to_path_buf) {
            // Checked even if the file could not be watched.
            Some(_) if session.differs_on_disk() == Some(true) => self.prompts.external(Some(after)),
            Some(_) if newer && session.is_changed() => self.prompts.newer(after),
            Some(file) => self.save(&file, after, context),
            None => self.prompts.ask_save(session, after),
        }
    }

    /// Saves to a file and, on success, performs the next step.
    pub(crate) fn save(&mut self, file: &Path, after: Option<After>, context: &Context) {
        let moves = self.state.session.file() != Some(file);
        // The watcher reports this write too, but by then the text is known.
        match self.state.session.save(file) {
            Ok(paths) => {
                self.notices.success(format!("Saved {}", file.display()));
                if paths > 0 {
                    let what = edit::count(paths, "relative path");
                    let (were, they) = if paths == 1 { ("was", "it leads") } else { ("were", "they lead") };
                    let text = format!("{what} {were} rewritten so that {they} to the same files as before");
                    self.notices.info(text);
                }
                if moves {
                    self.watch(Some(file), context);
                    self.remember();
                    self.changed();
                }
                if let Some(data) = self.prompts.data() {
                    self.recent = crate::recent::add(data, file);
                }
                if let Some(after) = after {
                    self.go(after, context);
                }
            }
            Err(error) => {
                self.notices.error(error);
            }
        }
    }

    /// Restores a backup of an editor that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: &UnsavedCopy, context: &Context) {
        let session = kept.file.as_deref().and_then(|file| Session::open(file).ok());
        let mut session = session.unwrap_or_else(|| Session::new(String::new(), kept.file.clone()));
        session.recover(&kept.text, kept.overtaken);
        self.start(session, context);
        // The recovered text is in no file yet, so it is backed up again before the old backup is deleted.
        self.copy();
        if let Some(keeper) = &self.keeper {
            keeper.replace(kept.clone());
        }
    }

    /// Asks where to save.
    pub(super) fn save_as(&mut self) {
        if self.settle(NOT_SAVED) {
            self.prompts.ask_save(&self.state.session, None);
        }
    }

    /// Reloads the document from its file.
    pub(super) fn reload(&mut self) {
        self.settle("The typed text was kept");
        match self.state.session.reload() {
            Ok(()) => self.changed(),
            Err(error) => {
                self.notices.error(error);
            }
        }
    }
}

//! Templates and recent documents.

use super::Editor;
use crate::document::Session;
use crate::state::State;
use crate::welcome::templates;
use egui::Context;
use std::path::Path;

impl Editor {
    /// Shows templates and recent documents.
    pub fn welcome(&mut self) {
        self.panels.canvas.close_search();
        self.keep_recent_picture();
        self.prompts.welcome(&self.recent);
    }

    /// Keeps the picture of the document for the list of recent ones, if there is one by now.
    pub(super) fn keep_recent_picture(&self) {
        let sheet = self.state.session.sheet();
        let seen = State::first_output(sheet).and_then(|(node, _)| self.state.evaluated.thumbnails.get(&node));
        if let (Some(data), Some(file), Some(screen)) = (self.prompts.data(), self.state.session.file(), seen) {
            crate::recent::keep_picture(data, file, screen);
        }
    }

    /// Starts a new document from a template.
    pub(super) fn start_template(&mut self, name: &str, context: &Context) {
        let Some(template) = templates::ALL.iter().find(|known| known.name == name) else { return };
        match template.open() {
            Ok(session) => self.start(session, context),
            Err(why) => self.notices.error(format!("The template “{name}” cannot be opened: {why}")),
        }
    }

    /// Removes a document from the list of recent ones.
    pub(super) fn forget_recent(&mut self, file: &Path) {
        self.recent.retain(|known| known != file);
        if let Some(data) = self.prompts.data() {
            self.recent = crate::recent::remove(data, file);
        }
    }

    /// Starts the document of a new window.
    pub(super) fn start_new(&mut self, context: &Context) {
        self.start(Session::new(crate::document::session::NEW.into(), None), context);
    }
}

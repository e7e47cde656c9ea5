//! Layouts of the panels that the user keeps under names.

use super::Editor;
use egui::Context;

impl Editor {
    /// Arranges the panels as they were kept.
    pub(super) fn own_layout(&mut self, name: &str) {
        match self.layouts.panels(name) {
            Ok(panels) => self.tree = panels,
            Err(why) => self.notices.error(why),
        }
    }

    /// Keeps the arrangement of the panels.
    pub(super) fn keep_layout(&mut self, name: String, context: &Context) {
        match self.layouts.keep(name.clone(), &self.tree) {
            Ok(()) => self.notices.success(format!("The layout “{name}” is kept: find it in Window > Layout")),
            Err(why) => self.notices.error(why),
        }
        context.request_repaint();
    }

    /// Deletes a kept arrangement.
    pub(super) fn forget_layout(&mut self, name: &str) {
        match self.layouts.forget(name) {
            Ok(()) => self.notices.plain(format!("Deleted the layout “{name}”")),
            Err(why) => self.notices.error(why),
        }
    }
}

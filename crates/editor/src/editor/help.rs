//! Showing pages of the help, and adding the nodes that they are about.

use super::Editor;
use crate::actions::{HelpPage, Pane};
use crate::layout;

impl Editor {
    /// Shows a page of the help.
    pub(super) fn help(&mut self, page: HelpPage) {
        self.panels.help.turn(page, None);
        layout::bring(&mut self.tree, Pane::Help);
    }

    /// Adds a node of a type, connected to the selected one.
    pub(super) fn add_type(&mut self, name: String) {
        layout::bring(&mut self.tree, Pane::Canvas);
        self.panels.canvas.add_type(name);
    }
}

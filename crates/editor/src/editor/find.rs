//! Finding places in the document, and going there. Nothing of it changes the document.

use super::Editor;
use crate::actions::Pane;
use crate::document::find::{Target, entries};
use crate::document::{Path, Step};
use crate::layout;

impl Editor {
    /// Opens the search in the document.
    pub(super) fn find(&mut self) {
        self.panels.canvas.close_search();
        self.prompts.find(entries(self.state.sheet(), &self.state.swatches()));
    }

    /// Selects a place in the document, brings it into view, and shows its properties.
    pub(super) fn go_to_target(&mut self, target: Target) {
        match target {
            Target::Node(name) => self.show_node(name),
            Target::Color(key) => {
                self.state.colors.chosen = Some(key);
                layout::bring(&mut self.tree, Pane::Palette);
            }
            Target::Knob(path) => {
                self.show_owner(&path);
                self.panels.properties.seek(path);
            }
            Target::Notes(path) => {
                self.show_owner(&path);
                self.panels.properties.seek(path.to("notes"));
            }
            Target::Output(name) => self.show_output(name),
            Target::Backdrop(name) => {
                layout::bring(&mut self.tree, Pane::Canvas);
                self.panels.canvas.frame_backdrop(name);
            }
        }
    }

    /// Shows the node or output that a path leads into, or else the document.
    fn show_owner(&mut self, path: &Path) {
        match path.0.as_slice() {
            [Step::Key(nodes), Step::Key(name), ..] if nodes == "nodes" => self.show_node(name.clone()),
            [Step::Key(outputs), Step::Key(name), ..] if outputs == "outputs" => self.show_output(name.clone()),
            _ => {
                self.choose_output(None);
                layout::bring(&mut self.tree, Pane::Properties);
            }
        }
    }

    fn show_node(&mut self, name: String) {
        if self.state.sheet().find(&name).is_some() {
            self.visit(self.state.whole_name(&name));
            layout::bring(&mut self.tree, Pane::Properties);
        }
    }

    fn show_output(&mut self, name: String) {
        self.choose_output(Some(name));
        layout::bring(&mut self.tree, Pane::Properties);
    }
}

//! Actions on groups: entering, making, unpacking, and promoting knobs.

use super::Editor;
use crate::actions::Pane;
use crate::document::{Edit, Path, Sheet, group};
use crate::layout;

impl Editor {
    /// Shows the inside of a use; nothing is written.
    pub(super) fn enter(&mut self, names: Vec<String>) {
        let state = &mut self.state;
        state.session.seal();
        let came_from = state.scope.get(names.len()).cloned().filter(|_| state.scope.starts_with(&names));
        state.scope = names;
        state.read_insides();
        state.dropper = None;
        state.output = None;
        // Whoever leaves a use has it selected.
        let selected = came_from.filter(|name| state.sheet().find(name).is_some());
        state.selection = selected.into_iter().collect();
        layout::bring(&mut self.tree, Pane::Canvas);
    }

    /// Returns the sheet that the canvas draws, with all nodes in the places where they are drawn, which is what the document
    /// says once wires change.
    fn drawn(&self) -> Sheet {
        let mut sheet = Sheet::clone(&crate::canvas::placed(self.state.sheet()));
        sheet.nodes.iter_mut().for_each(|node| node.placed = true);
        sheet
    }

    /// Makes a group of the selected nodes, and selects the use of it.
    pub(super) fn group(&mut self) {
        let sheet = self.drawn();
        match group::grouped(&sheet, &self.state.selection) {
            Ok((edit, name)) => self.make_nodes(edit, [name].into()),
            Err(why) => self.notices.warning(why.to_string()),
        }
    }

    /// Puts the nodes of the selected use in its place, and selects them.
    pub(super) fn unpack(&mut self) {
        let Some(name) = self.state.chosen().map(String::from) else { return };
        if self.state.session.meaning().graph.is_none() {
            // What stands for what is known of valid documents only.
            return self.notices.warning("The document has errors: correct them before you unpack a group");
        }
        let sheet = self.drawn();
        match group::unpacked(&sheet, &name) {
            Ok((edit, names)) => self.make_nodes(edit, names),
            Err(why) => self.notices.warning(why.to_string()),
        }
    }

    fn make_nodes(&mut self, edit: Edit, names: std::collections::BTreeSet<String>) {
        let viewed = self.state.look.node.clone();
        self.panels.canvas.forget_cursor();
        self.state.session.seal();
        self.rewire(edit);
        self.state.session.seal();
        self.state.selection = names;
        let sheet = self.state.sheet().clone();
        self.state.selection.retain(|name| sheet.find(name).is_some());
        self.view_again(viewed);
    }

    /// Views a node again that is now elsewhere: in the group that was made of it, or outside of the one that had it.
    fn view_again(&mut self, viewed: Option<(String, usize)>) {
        let Some((name, output)) = viewed else { return };
        let (prefix, sheet) = (self.state.sheet().prefix(), self.state.sheet().clone());
        let root = self.state.session.sheet().clone();
        if group::is_node(&root, &name) {
            return;
        }
        let Some(own) = name.strip_prefix(&prefix) else { return };
        let (first, rest) = own.split_once('/').map_or((own, None), |(first, rest)| (first, Some(rest)));
        let candidates = self.state.selection.iter().map(|chosen| match rest {
            // Unpacked: the node is beside the others now, perhaps by another name.
            Some(rest) if sheet.find(first).is_none() => format!("{prefix}{rest}"),
            _ => format!("{prefix}{chosen}/{own}"),
        });
        if let Some(now) = candidates.into_iter().find(|name| group::is_node(&root, name)) {
            self.lost = None;
            self.state.look.node = Some((now, output));
            self.state.read_insides();
        }
    }

    /// Makes the value at a place a knob of the entered group, or of the document.
    pub(super) fn promote(&mut self, place: &Path) {
        let sheet = self.state.sheet().clone();
        let name = match place.0.get(1) {
            Some(crate::document::Step::Key(name)) => name.as_str(),
            _ => "",
        };
        let items = sheet.node(name).and_then(|node| node.declaration).map_or(&[][..], |known| known.items);
        let declared = group::declared_at(items, place.0.get(2..).unwrap_or_default());
        let is_inside = sheet.within.is_some();
        let promoted = match is_inside {
            true => group::promoted(&sheet, place, declared),
            false => group::promoted_to_document(&sheet, place, declared),
        };
        match promoted {
            Ok((edit, knob)) if !is_inside => {
                self.state.session.seal();
                self.edit(edit);
                self.state.session.seal();
                self.notices.info(format!("\"{knob}\" is a knob of the document now: select nothing to see it"));
            }
            Ok((edit, knob)) => {
                self.state.session.seal();
                self.edit(edit);
                self.state.session.seal();
                let group = sheet.within.as_ref().map_or("", |within| within.group());
                self.notices.info(format!("\"{knob}\" is a knob of {group} now: each of its uses can set it"));
            }
            Err(why) => self.notices.warning(why.to_string()),
        }
    }

    /// Copies the group of an included file into the document.
    pub(super) fn make_local(&mut self) {
        let Some(name) = self.state.foreign().map(String::from) else { return };
        match group::made_local(self.state.session.sheet(), &name) {
            Ok((edit, copy)) => {
                self.state.session.seal();
                self.edit_document(edit);
                self.state.session.seal();
                self.notices.info(format!("{copy} is a copy of {name} in this document, which its uses here use now"));
            }
            Err(why) => self.notices.warning(why.to_string()),
        }
    }
}

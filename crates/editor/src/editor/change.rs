//! Actions that edit the document, and the updates that follow an edit.

use super::Editor;
use crate::actions::Line;
use crate::document::json::Misplaced;
use crate::document::{Edit, Point, Session, Sheet, edit, group, output, relocate};
use crate::refusal;
use crate::state::State;
use egui::{Context, Id};
use std::time::{Duration, Instant};

impl Editor {
    /// Applies an edit of a value, unless the document rejects the value: then the field shows the reason.
    pub(super) fn give(&mut self, edit: Edit, field: Id, context: &Context) {
        if let Some(fault) = self.make(edit, Session::give).flatten() {
            self.forgive(context);
            // What to do is shown where it names something else to type.
            let near =
                if fault.remedy.starts_with("did you mean") { format!("; {}", fault.remedy) } else { String::new() };
            refusal::refuse(context, field, &format_args!("found {}; expected {}{near}", fault.found, fault.expected));
        }
    }

    /// Applies an edit of wires; nodes keep the places where they are drawn.
    pub(super) fn rewire(&mut self, edit: Edit) {
        self.edit(crate::canvas::freezing(self.state.sheet(), edit));
    }

    pub(super) fn rewrite(&mut self, text: &str) {
        self.state.session.replace(text, "Edit the text");
        self.panels.text.take();
        self.changed();
    }

    pub(super) fn undo(&mut self) {
        if self.settle("Nothing was undone")
            && let Some(label) = self.state.session.undo()
        {
            self.notices.plain(format!("Undo: {label}"));
            self.changed();
        }
    }

    pub(super) fn redo(&mut self) {
        if self.settle("Nothing was redone")
            && let Some(label) = self.state.session.redo()
        {
            self.notices.plain(format!("Redo: {label}"));
            self.changed();
        }
    }

    pub(super) fn copy_nodes(&mut self, context: &Context) {
        let text = edit::copied(&crate::canvas::placed(self.state.sheet()), &self.chosen());
        context.copy_text(text.clone());
        self.copied = Some((text, self.state.session.folder()));
    }

    pub(super) fn ask_paste(&mut self, context: &Context) {
        self.panels.canvas.await_paste();
        context.send_viewport_cmd(egui::ViewportCommand::RequestPaste);
    }

    pub(super) fn paste(&mut self, text: String, at: Point) {
        match edit::pasted(self.state.sheet(), &self.carried(text), at) {
            Some((edit, names)) => {
                self.rewire(edit);
                self.state.selection = names.into_iter().collect();
            }
            None => {
                self.notices.warning("The clipboard contains no nodes: copy nodes from a graph, or their JSON");
            }
        }
    }

    pub(super) fn duplicate(&mut self) {
        let (sheet, names) = (crate::canvas::placed(self.state.sheet()), self.chosen());
        let text = edit::copied(&sheet, &names);
        let corner = names.iter().filter_map(|name| sheet.node(name)).map(|node| node.at);
        let corner = corner.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]).unwrap_or_default();
        self.paste(text, [corner[0] + 40.0, corner[1] + 40.0]);
    }

    pub(super) fn delete(&mut self) {
        self.panels.canvas.forget_cursor();
        self.edit(crate::canvas::deleting(self.state.sheet(), &self.chosen()));
        self.state.selection.clear();
    }

    pub(super) fn arrange(&mut self) {
        let sheet = self.state.sheet().clone();
        let places = crate::canvas::arrange(&sheet, &self.state.selection);
        self.edit(edit::laid_out(&sheet, &places));
    }

    pub(super) fn line_up(&mut self, line: Line) {
        self.edit(crate::canvas::lined_up(self.state.sheet(), &self.state.selection, line));
        self.state.session.seal();
    }

    pub(super) fn add_dot(&mut self) {
        if let Some(edit) = self.state.chosen().and_then(|name| self.panels.canvas.dotted(name)) {
            self.edit(edit);
        }
    }

    pub(super) fn add_backdrop(&mut self) {
        if let Some((edit, name, text)) = crate::canvas::backdrop(self.state.sheet(), &self.state.selection) {
            self.edit(edit);
            self.panels.canvas.write_on(name, text);
        }
    }

    pub(super) fn write_backdrop(&mut self) {
        let sheet = self.state.sheet();
        if let Some(name) = crate::canvas::backdrop_of(sheet, &self.state.selection) {
            self.panels.canvas.write_on(name.clone(), &sheet.backdrops[name].text);
        }
    }

    pub(super) fn add_note(&mut self) {
        let (edit, name, text) = self.panels.canvas.note(self.state.sheet());
        self.edit(edit);
        self.panels.canvas.write_on(name, text);
    }

    /// Adds an output that renders the selected node: its viewed result, or the first one that a file can hold.
    pub(super) fn make_output(&mut self) {
        let sheet = self.state.sheet().clone();
        if sheet.within.is_some() {
            // Outputs of the document are outside.
            return self
                .notices
                .warning("Outputs of the document are made outside of groups: leave the group first (Esc)");
        }
        let Some(node) = self.state.chosen().and_then(|name| sheet.find(name)) else { return };
        let looked = self.state.look.node.as_ref().filter(|(name, _)| *name == sheet.nodes[node].name);
        let index = looked.map(|(_, index)| *index).or_else(|| output::renderable(&sheet, node)).unwrap_or(0);
        match output::made(&sheet, (node, index)) {
            Some((edit, _)) => {
                self.edit(edit);
                self.state.session.seal();
            }
            None => self.notices.warning(output::unfit(&sheet, (node, index))),
        }
    }

    /// Rewrites the paths in pasted text if the nodes were copied from a document in another folder.
    fn carried(&self, text: String) -> String {
        let folder = self.state.session.folder();
        let from = self.copied.as_ref().filter(|(copied, from)| copied.trim() == text.trim() && *from != folder);
        from.and_then(|(_, from)| relocate::carried(&text, from, &folder)).unwrap_or(text)
    }

    pub(super) fn edit(&mut self, edit: Edit) {
        self.make(edit, Session::edit);
    }

    /// Applies an edit of the document as a whole, whatever use is entered.
    pub(super) fn edit_document(&mut self, edit: Edit) {
        self.make_whole(edit, Session::edit);
    }

    /// Clears a refusal once the document or the selection has changed.
    pub(super) fn forgive(&mut self, context: &Context) {
        let (state, known) = (&self.state, &self.refusing);
        let revision = state.session.revision();
        if (revision, &state.selection, &state.output) != (known.0, &known.1, &known.2) {
            refusal::forget(context);
            self.refusing = (revision, state.selection.clone(), state.output.clone());
        }
    }

    /// Applies a change if the text is JSON; returns its result if it was made.
    pub(super) fn make<T>(
        &mut self,
        edit: Edit,
        change: impl FnOnce(&mut Session, Edit) -> Result<T, Misplaced>,
    ) -> Option<T> {
        if !self.state.session.meaning().readable {
            // At most one notice per 5 seconds, however fast the user types.
            if self.complained.is_none_or(|since| since.elapsed() > Duration::from_secs(5)) {
                self.notices.error("The text is not JSON: correct it in the Text panel first");
                self.complained = Some(Instant::now());
            }
            return None;
        }
        match self.state.in_document(edit) {
            Ok(edit) => self.make_whole(edit, change),
            Err(why) => {
                self.notices.warning(why.to_string());
                None
            }
        }
    }

    /// Does the same with a change of the document as a whole.
    fn make_whole<T>(
        &mut self,
        edit: Edit,
        change: impl FnOnce(&mut Session, Edit) -> Result<T, Misplaced>,
    ) -> Option<T> {
        let sheet = self.state.session.sheet().clone();
        if !self.settle("Nothing else was changed") {
            return None;
        }
        if !edit.fits(&sheet.value, &self.state.session.sheet().value) {
            self.notices.warning(
                "The changes typed in the Text panel were applied and affect the same place. Check them, then repeat \
                 your edit",
            );
            return None;
        }
        let before = self.state.session.revision();
        match change(&mut self.state.session, edit) {
            Ok(made) => {
                if self.state.session.revision() != before {
                    self.changed();
                }
                Some(made)
            }
            Err(error) => {
                self.notices.error(error.to_string());
                None
            }
        }
    }

    /// Applies pending text of the text panel before another operation on the document. If it is not JSON, shows an
    /// error that begins with `outcome` and returns false.
    pub(super) fn settle(&mut self, outcome: &str) -> bool {
        let Some(text) = self.panels.text.pending() else { return true };
        if let Err(error) = serde_json::from_str::<serde_json::Value>(text) {
            let why = "the text in the Text panel is not JSON";
            self.notices.error(format!("{outcome}: {why}: {error}. Correct it there, or revert it"));
            return false;
        }
        if let Some(text) = self.panels.text.take() {
            self.state.session.replace(&text, "Edit the text");
            self.changed();
        }
        true
    }

    /// Updates everything that depends on the document after a change.
    pub(super) fn changed(&mut self) {
        let sheet = self.state.session.sheet().clone();
        let before = std::mem::replace(&mut self.known, sheet.clone());
        if before.value.is_null() {
            // This is the first text that can be parsed.
            self.state.begin();
        }
        // A range of all frames stays one.
        let frames = |sheet: &Sheet| (sheet.frames.0, sheet.frames.1);
        if self.state.range == frames(&before) {
            self.state.range = frames(&sheet);
        }
        let inside = self.state.sheet().clone();
        self.state.rename(&sheet.renamed(&before), "");
        self.state.rename_scope(&sheet.renamed(&before));
        self.state.read_insides();
        if inside.within.is_some() && self.state.sheet().prefix() == inside.prefix() {
            let renamed = self.state.sheet().renamed(&inside);
            self.state.rename(&renamed, &inside.prefix());
            self.state.read_insides();
        }
        let shown = self.state.sheet().clone();
        self.state.selection.retain(|name| shown.find(name).is_some());
        if let Some(gone) = self.state.output.take_if(|name| output::find(&sheet, name).is_none()) {
            self.state.output = output::now(&sheet, &before, &gone);
        }
        self.forget_frames();
        self.look_again();
        self.on_second(Self::look_again);
        self.state.read_insides();
    }

    /// Views the first output while the viewed node is gone.
    fn look_again(&mut self) {
        let sheet = self.state.session.sheet();
        if let Some(lost) = self.lost.take_if(|(name, _)| group::is_node(sheet, name)) {
            self.state.look.node = Some(lost);
        }
        if let Some(gone) = self.state.look.node.take_if(|(name, _)| !group::is_node(sheet, name)) {
            self.lost.get_or_insert(gone);
            self.state.look.node = State::first_output(sheet);
        }
    }
}

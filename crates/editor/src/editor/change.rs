//! Changes of the document, and what follows from them.

use super::Editor;
use crate::actions::Line;
use crate::document::json::Misplaced;
use crate::document::{Edit, Point, Session, edit, output, relocate};
use crate::refusal;
use crate::state::State;
use egui::{Context, Id};
use std::time::{Duration, Instant};

impl Editor {
    /// Changes a value, unless the document does not bear it: then the field says why.
    pub(super) fn give(&mut self, edit: Edit, field: Id, context: &Context) {
        if let Some(fault) = self.make(edit, Session::give).flatten() {
            self.forgive(context);
            refusal::refuse(context, field, &format_args!("found {}; expected {}", fault.found, fault.expected));
        }
    }

    /// Changes wires; nodes stay where they are seen.
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
            self.notices.plain(format!("Undone: {label}"));
            self.changed();
        }
    }

    pub(super) fn redo(&mut self) {
        if self.settle("Nothing was done again")
            && let Some(label) = self.state.session.redo()
        {
            self.notices.plain(format!("Redone: {label}"));
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
                self.notices.warning("The clipboard holds no nodes: copy some from a graph, or their JSON");
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

    /// Renders what the chosen node makes: what is looked at of it, or the first that a file can hold.
    pub(super) fn make_output(&mut self) {
        let sheet = self.state.sheet().clone();
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

    /// A text to be pasted; paths of nodes that were copied from a document in another folder lead to the same files.
    fn carried(&self, text: String) -> String {
        let folder = self.state.session.folder();
        let from = self.copied.as_ref().filter(|(copied, from)| copied.trim() == text.trim() && *from != folder);
        from.and_then(|(_, from)| relocate::carried(&text, from, &folder)).unwrap_or(text)
    }

    pub(super) fn edit(&mut self, edit: Edit) {
        self.make(edit, Session::edit);
    }

    /// Says no more of a refused value once the document is another, or something else of it is chosen.
    pub(super) fn forgive(&mut self, context: &Context) {
        let (state, known) = (&self.state, &self.refusing);
        let revision = state.session.revision();
        if (revision, &state.selection, &state.output) != (known.0, &known.1, &known.2) {
            refusal::forget(context);
            self.refusing = (revision, state.selection.clone(), state.output.clone());
        }
    }

    /// Makes a change of a text that can be read; what came of it, where it can be made.
    fn make<T>(&mut self, edit: Edit, change: impl FnOnce(&mut Session, Edit) -> Result<T, Misplaced>) -> Option<T> {
        if !self.state.session.meaning().readable {
            // Once, however fast one types.
            if self.complained.is_none_or(|since| since.elapsed() > Duration::from_secs(5)) {
                self.notices.error("The text is not JSON: correct it in the panel \"Text\" first");
                self.complained = Some(Instant::now());
            }
            return None;
        }
        let sheet = self.state.sheet().clone();
        if !self.settle("Nothing else was changed") {
            return None;
        }
        if !edit.fits(&sheet.value, &self.state.sheet().value) {
            self.notices.warning(
                "What was typed in the panel \"Text\" was applied, and changes the same place: look at it, and do that \
                 once more",
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

    /// Applies what is typed in the panel of the text, before something else is done with the document. Where that is no
    /// JSON, says so, with what became of it; false then.
    pub(super) fn settle(&mut self, outcome: &str) -> bool {
        let Some(text) = self.panels.text.pending() else { return true };
        if let Err(error) = serde_json::from_str::<serde_json::Value>(text) {
            let why = "the text typed in the panel \"Text\" is no JSON";
            self.notices.error(format!("{outcome}: {why}: {error}. Correct it there, or revert it"));
            return false;
        }
        if let Some(text) = self.panels.text.take() {
            self.state.session.replace(&text, "Edit the text");
            self.changed();
        }
        true
    }

    /// What follows from a change of the document.
    pub(super) fn changed(&mut self) {
        let sheet = self.state.session.sheet().clone();
        let before = std::mem::replace(&mut self.known, sheet.clone());
        if before.value.is_null() {
            // The first text that can be read.
            self.state.begin();
        }
        self.state.rename(&sheet.renamed(&before));
        self.state.selection.retain(|name| sheet.find(name).is_some());
        if let Some(gone) = self.state.output.take_if(|name| output::find(&sheet, name).is_none()) {
            self.state.output = output::now(&sheet, &before, &gone);
        }
        self.forget_frames();
        if let Some(lost) = self.lost.take_if(|(name, _)| sheet.find(name).is_some()) {
            self.state.look.node = Some(lost);
        }
        if let Some(gone) = self.state.look.node.take_if(|(name, _)| sheet.find(name).is_none()) {
            self.lost.get_or_insert(gone);
            self.state.look.node = State::first_output(&sheet);
        }
    }
}

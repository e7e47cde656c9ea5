//! What is asked for is done.

use super::Editor;
use crate::actions::{Action, After, Pane};
use crate::document::json::Misplaced;
use crate::document::keep::Kept;
use crate::document::sheet::FAR;
use crate::document::{Edit, Session, Standing, edit, output, relocate};
use crate::layout;
use crate::refusal;
use crate::render::{Obstacle, Renderer};
use crate::state::State;
use egui::Context;
use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

/// What became of saving a text that is no JSON.
const NOT_SAVED: &str = "Nothing was saved";

impl Editor {
    /// Does what was asked for.
    pub fn act(&mut self, action: Action, context: &Context) {
        let state = &mut self.state;
        let names: Vec<String> = state.selection.iter().cloned().collect();
        let sheet = state.sheet().clone();
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::Give(edit, field) => {
                if let Some(fault) = self.make(edit, Session::give).flatten() {
                    let why = format!("found {}; expected {}", fault.found, fault.expected);
                    self.forgive(context);
                    refusal::refuse(context, field, why);
                }
            }
            Action::Rewire(edit) => self.edit(crate::canvas::freezing(&sheet, edit)),
            Action::Seal => state.session.seal(),
            Action::Rewrite(text) => {
                state.session.replace(&text, "Edit the text");
                self.panels.source.take();
                self.changed();
            }
            Action::Undo => {
                if self.settle("Nothing was undone")
                    && let Some(label) = self.state.session.undo()
                {
                    self.notices.plain(format!("Undone: {label}"));
                    self.changed();
                }
            }
            Action::Redo => {
                if self.settle("Nothing was done again")
                    && let Some(label) = self.state.session.redo()
                {
                    self.notices.plain(format!("Redone: {label}"));
                    self.changed();
                }
            }
            Action::Select(mut names) => {
                let asked = names.len();
                names.retain(|name| sheet.find(name).is_some());
                if names.is_empty() && asked > 0 {
                    // What was to be chosen could not be made.
                    return;
                }
                if state.selection != names {
                    // The field that waits for a color is not to be seen any more.
                    state.dropper = None;
                }
                state.selection = names;
                state.output = None;
            }
            Action::Output(Some(name)) if output::find(&sheet, &name).is_none() => {}
            Action::Output(name) => {
                state.selection.clear();
                state.dropper = None;
                state.output = name;
            }
            Action::Visit(name) => {
                state.selection = [name].into();
                state.dropper = None;
                state.output = None;
                layout::bring(&mut self.tree, Pane::Canvas);
                self.panels.canvas.frame();
            }
            Action::Look(node, output) => {
                state.look.node = Some((node, output));
                self.lost = None;
            }
            Action::Slot(slot) => {
                if let Some(name) = state.chosen().map(String::from) {
                    state.look.slots[slot] = Some(name);
                }
                if let Some(name) = state.look.slots[slot].clone().filter(|name| sheet.find(name).is_some()) {
                    state.look.node = Some((name, 0));
                    self.lost = None;
                }
            }
            Action::Display(display) => state.look.display = display,
            Action::Proxy(proxy) => state.look.proxy = proxy.clamp(1, 8),
            Action::Region(region) => state.look.region = region,
            Action::Pick(pick) => state.look.pick = pick,
            Action::Dropper(place) => state.dropper = place,
            Action::Frame(frame) => {
                state.frame = frame.clamp(-FAR, FAR);
                self.playback = Default::default();
            }
            Action::Play(playing) => {
                state.playing = playing;
                self.playback = Default::default();
                self.asked.ahead = None;
                // What was missing may be there by now.
                self.asked.failed.clear();
                if !playing {
                    self.worker.ahead([]);
                }
            }
            Action::Range(first, last) => state.range = (first.min(last), first.max(last)),
            Action::New => self.leave(After::New, context),
            Action::Open => self.leave(After::Ask, context),
            Action::OpenFile(file) => self.leave(After::Open(file), context),
            Action::Quit => self.leave(After::Close, context),
            Action::Save => self.store(None, context),
            Action::SaveAs => {
                if self.settle(NOT_SAVED) {
                    self.prompts.ask_save(&self.state.session, None);
                }
            }
            Action::Reload => {
                self.settle("It stays there");
                match self.state.session.reload() {
                    Ok(()) => self.changed(),
                    Err(error) => {
                        self.notices.error(error);
                    }
                }
            }
            Action::Copy | Action::Cut => {
                let text = edit::copied(&crate::canvas::placed(&sheet), &names);
                context.copy_text(text.clone());
                self.copied = Some((text, self.state.session.folder()));
                if action == Action::Cut {
                    self.edit(crate::canvas::deleting(&sheet, &names));
                }
            }
            Action::Paste(text, at) => match edit::pasted(&sheet, &self.carried(text), at) {
                Some((edit, names)) => {
                    self.edit(crate::canvas::freezing(&sheet, edit));
                    self.state.selection = names.into_iter().collect();
                }
                None => {
                    self.notices.warning("The clipboard holds no nodes: copy some from a graph, or their JSON");
                }
            },
            Action::Duplicate => {
                let sheet = crate::canvas::placed(&sheet);
                let text = edit::copied(&sheet, &names);
                let corner = names.iter().filter_map(|name| sheet.node(name)).map(|node| node.at);
                let corner = corner.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]).unwrap_or_default();
                self.act(Action::Paste(text, [corner[0] + 40.0, corner[1] + 40.0]), context);
            }
            Action::Delete => {
                self.panels.canvas.forget_cursor();
                self.edit(crate::canvas::deleting(&sheet, &names));
                self.state.selection.clear();
            }
            Action::Disable => self.edit(edit::disabled(&sheet, &names)),
            Action::SelectAll => state.selection = sheet.nodes.iter().map(|node| node.name.clone()).collect(),
            Action::Arrange => {
                let places = crate::canvas::arrange(&sheet, &state.selection);
                self.edit(edit::laid_out(&sheet, &places));
            }
            Action::Line(line) => {
                let edit = crate::canvas::lined_up(&sheet, &state.selection, line);
                self.edit(edit);
                self.state.session.seal();
            }
            Action::Replace => self.panels.canvas.replace(),
            Action::Extract => self.edit(crate::canvas::freezing(&sheet, edit::extracted(&sheet, &names))),
            Action::Dot => {
                if let Some(edit) = state.chosen().and_then(|name| self.panels.canvas.dotted(name)) {
                    self.edit(edit);
                }
            }
            Action::MakeOutput => self.make_output(),
            Action::Backdrop => {
                if let Some((edit, name, text)) = crate::canvas::backdrop(&sheet, &state.selection) {
                    self.edit(edit);
                    self.panels.canvas.write_on(name, text);
                }
            }
            Action::WriteBackdrop => {
                if let Some(name) = crate::canvas::backdrop_of(&sheet, &state.selection) {
                    self.panels.canvas.write_on(name.clone(), &sheet.backdrops[name].text);
                }
            }
            Action::Note => {
                let (edit, name, text) = self.panels.canvas.note(&sheet);
                self.edit(edit);
                self.panels.canvas.write_on(name, text);
            }
            Action::AskPaste => {
                self.panels.canvas.await_paste();
                context.send_viewport_cmd(egui::ViewportCommand::RequestPaste);
            }
            Action::Frames => self.panels.canvas.frame(),
            Action::AddNode => self.panels.canvas.search(),
            Action::Render => self.render(context),
            Action::Allow(grant) => self.allow(grant),
            Action::ShowAllowed => self.prompts.allowed(),
            Action::Forbid(document, grant) => self.forbid(document.as_deref(), &grant),
            Action::CancelRender => {
                if let Some(renderer) = &self.renderer {
                    renderer.cancel();
                }
            }
            Action::Palette => {
                self.panels.canvas.close_search();
                self.prompts.palette();
            }
            Action::Viewer(switch) => self.panels.viewer.switch(switch, &self.state),
            Action::Panel(pane) => layout::bring(&mut self.tree, pane),
            Action::ResetPanels => self.tree = layout::first(),
            Action::Theme => {
                let dark = context.theme() == egui::Theme::Dark;
                context.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
            Action::Notice(text) => {
                self.notices.info(text);
            }
        }
    }

    /// Renders what the chosen node makes: what is looked at of it, or the first that a file can hold.
    fn make_output(&mut self) {
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
    fn settle(&mut self, outcome: &str) -> bool {
        let Some(text) = self.panels.source.pending() else { return true };
        if let Err(error) = serde_json::from_str::<serde_json::Value>(text) {
            let why = "the text typed in the panel \"Text\" is no JSON";
            self.notices.error(format!("{outcome}: {why}: {error}. Correct it there, or revert it"));
            return false;
        }
        if let Some(text) = self.panels.source.take() {
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

    /// Leaves this document for something else, unless there is unsaved work, or a run would end with the window: then a
    /// question comes first.
    pub(crate) fn leave(&mut self, after: After, context: &Context) {
        if self.renderer.is_some() && matches!(after, After::Close) {
            self.prompts.rendering(after);
        } else if self.is_unsaved() {
            self.prompts.unsaved(after);
        } else {
            self.go(after, context);
        }
    }

    /// Goes on to something else, whatever is unsaved.
    pub(crate) fn go(&mut self, after: After, context: &Context) {
        match after {
            After::New => self.start(Session::new(crate::document::session::NEW.into(), None), context),
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
                self.closing = true;
                context.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// Saves to the document's file, or asks where to; goes on to something else then.
    pub(crate) fn store(&mut self, after: Option<After>, context: &Context) {
        if !self.settle(NOT_SAVED) {
            return;
        }
        let session = &self.state.session;
        let newer = Standing::of(&session.sheet().value).is_newer();
        match session.file().map(Path::to_path_buf) {
            // Also where nobody could watch the file.
            Some(_) if session.differs_on_disk() == Some(true) => self.prompts.external(Some(after)),
            Some(_) if newer && session.is_changed() => self.prompts.newer(after),
            Some(file) => self.save(&file, after, context),
            None => self.prompts.ask_save(session, after),
        }
    }

    /// Saves to a file, and goes on to something else where that worked.
    pub(crate) fn save(&mut self, file: &Path, after: Option<After>, context: &Context) {
        let moves = self.state.session.file() != Some(file);
        // The watcher tells of this write too; it is what we know already then.
        match self.state.session.save(file) {
            Ok(paths) => {
                self.notices.success(format!("Saved {}", file.display()));
                if paths > 0 {
                    let what = edit::count(paths, "relative path");
                    let (were, they) = if paths == 1 { ("was", "it leads") } else { ("were", "they lead") };
                    let text = format!("{what} {were} rewritten so that {they} to the same files from the new folder");
                    self.notices.info(text);
                }
                if moves {
                    self.watcher.watch(Some(file), context);
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

    /// Takes what was kept of an editor that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: &Kept, context: &Context) {
        let session = kept.file.as_deref().and_then(|file| Session::open(file).ok());
        let mut session = session.unwrap_or_else(|| Session::new(String::new(), kept.file.clone()));
        session.recover(&kept.text, kept.overtaken);
        self.start(session, context);
        // It is not in the file yet, so it is kept again before the old copy goes.
        self.copy();
        if let Some(keeper) = &self.keeper {
            keeper.replace(kept.clone());
        }
    }

    pub(super) fn render(&mut self, context: &Context) {
        if !self.settle("Nothing was rendered") {
            return;
        }
        let Some(graph) = self.state.session.meaning().graph.clone() else {
            self.notices.warning("The document has errors: correct them before rendering");
            return;
        };
        if self.state.session.file().is_none() {
            self.notices.info("Save the document first: the names of its outputs are relative to its folder");
            return self.prompts.ask_save(&self.state.session, Some(After::Render));
        }
        match Renderer::start(graph, self.state.range, context.clone()) {
            Ok(renderer) => {
                self.state.render = Some(renderer.progress());
                self.renderer = Some(renderer);
            }
            Err(Obstacle::Refused(refused)) => self.prompts.reach(refused),
            Err(Obstacle::Because(why)) => {
                self.notices.error(why);
            }
        }
    }

    /// Ends the run that goes on, as soon as it hears of it.
    pub(crate) fn end_render(&mut self) {
        (self.renderer, self.state.render) = (None, None);
    }

    pub(super) fn hear_render(&mut self, context: &Context) {
        let Some(renderer) = &mut self.renderer else { return };
        self.state.render = Some(renderer.progress());
        let Some(outcome) = renderer.outcome() else {
            return context.request_repaint_after(Duration::from_millis(200));
        };
        self.renderer = None;
        self.state.render = None;
        match outcome {
            Ok(message) => {
                self.notices.success(message);
            }
            Err(message) => {
                self.notices.error(message);
            }
        }
    }

    /// Chooses nodes; what tests and prompts use.
    pub fn select(&mut self, names: &[&str]) {
        self.state.selection = names.iter().map(|name| (*name).to_string()).collect::<BTreeSet<String>>();
        self.state.output = None;
    }
}

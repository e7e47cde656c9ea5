//! Dispatch of actions, and those that concern selection, viewing, and playback. Edits of the document are in `change`,
//! leaving and saving in `leave`, rendering in `rendering`.

use super::Editor;
use crate::actions::{Action, After, Pane};
use crate::document::sheet::{FAR, Side};
use crate::document::{edit, group, output};
use crate::layout;
use crate::prompts::Named;
use egui::Context;
use std::collections::BTreeSet;

impl Editor {
    /// Performs an action.
    pub fn act(&mut self, action: Action, context: &Context) {
        let state = &mut self.state;
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::Whole(edit) => self.edit_document(edit),
            Action::Give(edit, field) => self.give(edit, field, context),
            Action::Rewire(edit) => self.rewire(edit),
            Action::Seal => state.session.seal(),
            Action::TakeBack => self.take_back(),
            Action::Rewrite(text) => self.rewrite(&text),
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
            Action::Select(names) => self.choose(names),
            Action::Output(name) => self.choose_output(name),
            Action::Visit(name) => self.visit(name),
            Action::Find => self.find(),
            Action::GoTo(target) => self.go_to_target(target),
            Action::Look(node, output) => self.look_at(node, output),
            Action::Slot(slot) => self.view_slot(slot),
            Action::Display(display) => state.look.display = display,
            Action::Proxy(proxy) => state.look.proxy = proxy.clamp(1, 8),
            Action::Region(region) => state.look.region = region,
            Action::Pick(pick) => state.look.pick = pick,
            Action::Hover(at) => state.colors.hover = at,
            Action::Dropper(place) => state.dropper = place,
            Action::Weigh => self.painting.weighs = true,
            Action::Swatch(chosen) => state.colors.chosen = chosen,
            Action::Tint(tint) => self.tint(tint),
            Action::SettleTint(edit) => self.settle_tint(edit),
            Action::Spot(spot) => state.colors.spot = spot,
            Action::ComparePalette(compared) => state.colors.compared = compared,
            Action::AddColor => self.add_color(),
            Action::TakePalette(entries, file) => self.take_palette(&entries, &file),
            Action::JoinPalette(entries) => self.join_palette(&entries),
            Action::NameColors => self.name_colors(),
            Action::BringPalette => self.bring_palette(),
            Action::Frame(frame) => self.go_to(frame),
            Action::Play(playing) => self.set_playing(playing),
            Action::Onion(on) => state.look.onion = on,
            Action::Range(first, last) => state.range = (first.min(last), first.max(last)),
            Action::New => self.leave(After::New, context),
            Action::Template(name) => self.leave(After::Template(name), context),
            Action::Welcome => self.welcome(),
            Action::ForgetRecent(file) => self.forget_recent(&file),
            Action::Open => self.leave(After::Ask, context),
            Action::OpenFile(file) => self.leave(After::Open(file), context),
            Action::Quit => self.leave(After::Close, context),
            Action::Save => self.store(None, context),
            Action::SaveAs => self.save_as(),
            Action::Reload => self.reload(),
            Action::Copy => self.copy_nodes(context),
            Action::Cut => {
                self.copy_nodes(context);
                self.edit(crate::canvas::deleting(self.state.sheet(), &self.chosen()));
            }
            Action::Paste(text, at) => self.paste(text, at),
            Action::Duplicate => self.duplicate(),
            Action::Delete => self.delete(),
            Action::Disable => self.edit(edit::disabled(self.state.sheet(), &self.chosen())),
            Action::SelectAll => self.choose_all(),
            Action::Arrange => self.arrange(),
            Action::Enter(names) => self.enter(names),
            Action::Group => self.group(),
            Action::Unpack => self.unpack(),
            Action::MakeLocal => self.make_local(),
            Action::Promote(place) => self.promote(&place),
            Action::Line(line) => self.line_up(line),
            Action::Replace => self.panels.canvas.replace(),
            Action::Extract => self.rewire(edit::extracted(self.state.sheet(), &self.chosen())),
            Action::Dot => self.add_dot(),
            Action::MakeOutput => self.make_output(),
            Action::Backdrop => self.add_backdrop(),
            Action::WriteBackdrop => self.write_backdrop(),
            Action::Note => self.add_note(),
            Action::AskPaste => self.ask_paste(context),
            Action::Frames => self.panels.canvas.frame(),
            Action::AddNode => self.panels.canvas.search(),
            Action::AddType(name) => self.add_type(name),
            Action::Help(page) => self.help(page),
            Action::Render => self.render(context),
            Action::Allow(grant) => self.allow(grant),
            Action::ShowAllowed => self.prompts.allowed(),
            Action::Forbid(document, grant) => self.forbid(document.as_deref(), &grant),
            Action::CancelRender => self.cancel_render(),
            Action::Palette => self.show_palette(),
            Action::Viewer(switch) => self.panels.viewer.switch(switch, &self.state),
            Action::Second(action) => self.on_second(|editor| editor.act(*action, context)),
            Action::Panel(pane) => layout::bring(&mut self.tree, pane),
            Action::Layout(layout) => self.tree = layout::arranged(layout),
            Action::OwnLayout(name) => self.own_layout(&name),
            Action::NameLayout => self.prompts.name(Named::Layout, self.layouts.names()),
            Action::KeepLayout(name) => self.keep_layout(name, context),
            Action::ForgetLayout(name) => self.forget_layout(&name),
            Action::NamePreset => self.name_preset(),
            Action::KeepPreset(name) => self.keep_preset(&name),
            Action::Preset(name) => self.apply_preset(&name),
            Action::ForgetPreset(ty, name) => self.forget_preset(&ty, &name),
            Action::Theme => switch_theme(context),
            Action::Notice(text) => {
                self.notices.info(text);
            }
        }
    }

    /// Returns the names of the selected nodes.
    pub(super) fn chosen(&self) -> Vec<String> {
        self.state.selection.iter().cloned().collect()
    }

    fn choose(&mut self, mut names: BTreeSet<String>) {
        let state = &mut self.state;
        let asked = names.len();
        names.retain(|name| state.sheet().find(name).is_some());
        if names.is_empty() && asked > 0 {
            // The nodes to select could not be created.
            return;
        }
        if state.selection != names {
            // The field that waits for a picked color is no longer visible.
            state.dropper = None;
        }
        state.selection = names;
        state.output = None;
    }

    fn choose_all(&mut self) {
        self.state.selection = self.state.sheet().nodes.iter().map(|node| node.name.clone()).collect();
    }

    pub(super) fn choose_output(&mut self, name: Option<String>) {
        let state = &mut self.state;
        if name.as_ref().is_some_and(|name| output::find(state.sheet(), name).is_none()) {
            return;
        }
        state.selection.clear();
        state.dropper = None;
        state.output = name;
    }

    pub(super) fn visit(&mut self, name: String) {
        let state = &mut self.state;
        // A node of a group is shown inside the use that has it.
        let (path, own) = name.rsplit_once('/').map_or(("", name.as_str()), |(path, own)| (path, own));
        let path: Vec<String> = path.split('/').filter(|name| !name.is_empty()).map(String::from).collect();
        if path != state.scope {
            state.scope = path;
            state.read_insides();
        }
        state.selection = Some(own.to_string()).filter(|own| state.sheet().find(own).is_some()).into_iter().collect();
        state.dropper = None;
        state.output = None;
        layout::bring(&mut self.tree, Pane::Canvas);
        self.panels.canvas.frame();
    }

    fn look_at(&mut self, node: String, output: usize) {
        // What a group's output shows is what the use makes.
        let (node, output) = match node.rsplit_once('/') {
            Some((path, own)) if own.starts_with(group::OUTPUT) => {
                let outputs = self.state.sheet().nodes.iter().filter(|node| node.side == Some(Side::Output));
                (path.to_string(), outputs.map(|node| &node.name).position(|name| name == own).unwrap_or(0))
            }
            _ => (node, output),
        };
        self.state.look.node = Some((node, output));
        self.state.read_insides();
        self.lost = None;
    }

    fn view_slot(&mut self, slot: usize) {
        let state = &mut self.state;
        if let Some(name) = state.chosen() {
            state.look.slots[slot] = Some(state.whole_name(name));
        }
        if let Some(name) = state.look.slots[slot].clone()
            && crate::document::group::is_node(state.session.sheet(), &name)
        {
            self.look_at(name, 0);
        }
    }

    fn go_to(&mut self, frame: i64) {
        self.state.frame = frame.clamp(-FAR, FAR);
        self.playback = Default::default();
    }

    fn set_playing(&mut self, playing: bool) {
        self.state.playing = playing;
        self.playback = Default::default();
        self.asked.ahead = None;
        // Files that were missing may exist by now.
        self.asked.failed.clear();
        if !playing {
            self.worker.ahead([]);
        }
    }

    fn show_palette(&mut self) {
        self.panels.canvas.close_search();
        self.prompts.palette();
    }

    /// Selects nodes, for tests and prompts.
    pub fn select(&mut self, names: &[&str]) {
        self.state.selection = names.iter().map(|name| (*name).to_string()).collect::<BTreeSet<String>>();
        self.state.output = None;
    }
}

fn switch_theme(context: &Context) {
    let dark = context.theme() == egui::Theme::Dark;
    context.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
}

//! Presets of nodes.

use super::Editor;
use crate::document::{Node, Session};
use crate::presets::{self, NoPreset};
use crate::prompts::Named;
use std::sync::Arc;

impl Editor {
    /// Reads the names of the presets, which the graph offers.
    pub(super) fn read_presets(&mut self) {
        let presets = self.prompts.data().map(presets::list).unwrap_or_default();
        self.panels.canvas.offer_presets(Arc::new(presets));
    }

    /// Asks for a name under which the knobs of the selected node are kept.
    pub(super) fn name_preset(&mut self) {
        let Some(ty) = self.preset_type() else {
            return self.notices.warning("Select one node, whose knobs the preset has");
        };
        let taken = self.prompts.data().and_then(|data| presets::list(data).remove(&ty)).unwrap_or_default();
        self.prompts.name(Named::Preset, taken);
    }

    /// Returns the type of the selected node, if exactly one is selected and its type is known.
    fn preset_type(&self) -> Option<String> {
        let node = self.state.chosen().and_then(|name| self.state.sheet().node(name))?;
        node.declaration.filter(|_| node.side.is_none()).map(|known| known.name.into())
    }

    /// Keeps the knobs of the selected node.
    pub(super) fn keep_preset(&mut self, name: &str) {
        let sheet = self.state.sheet().clone();
        let Some(node) = self.state.chosen().and_then(|name| sheet.node(name)) else { return };
        let (knobs, left_out) = presets::knobs(&sheet, node);
        let kept = self.prompts.data().ok_or(NoPreset::NoFolder);
        match kept.and_then(|data| presets::keep(data, &node.ty, name, &knobs).map(|()| data)) {
            Ok(data) => {
                let place = presets::file(data, &node.ty, name);
                self.notices.success(format!("Saved the preset “{name}” of {} in {}", node.ty, place.display()));
            }
            Err(why) => return self.notices.error(why),
        }
        if !left_out.is_empty() {
            self.notices
                .info(format!("Not part of the preset, because they follow other nodes: {}", left_out.join(", ")));
        }
        self.read_presets();
    }

    /// Gives the selected nodes the knobs of a preset of their type.
    pub(super) fn apply_preset(&mut self, name: &str) {
        let sheet = self.state.sheet().clone();
        let nodes: Vec<&Node> = self.state.selection.iter().filter_map(|name| sheet.node(name)).collect();
        let Some(known) = nodes.first().and_then(|node| node.declaration) else { return };
        if nodes.iter().any(|node| node.ty != known.name) {
            return self
                .notices
                .warning(format!("“{name}” is a preset of {}: select only nodes of that type", known.name));
        }
        let read = self.prompts.data().ok_or(NoPreset::NoFolder);
        let knobs = match read.and_then(|data| presets::read(data, known, name)) {
            Ok(knobs) => knobs,
            Err(why) => return self.notices.error(why),
        };
        self.state.session.seal();
        let edit = presets::applied(&sheet, &nodes, name, &knobs);
        if let Some(fault) = self.make(edit, Session::give).flatten() {
            let port = fault.port.as_deref().unwrap_or_default();
            let text =
                format!("The preset “{name}” does not fit: {port}: found {}; expected {}", fault.found, fault.expected);
            self.notices.error(text);
        }
        self.state.session.seal();
    }

    /// Deletes a preset.
    pub(super) fn forget_preset(&mut self, ty: &str, name: &str) {
        let Some(data) = self.prompts.data() else { return };
        match std::fs::remove_file(presets::file(data, ty, name)) {
            Ok(()) => self.notices.plain(format!("Deleted the preset “{name}” of {ty}")),
            Err(why) => self.notices.error(format!("The preset “{name}” cannot be deleted: {why}")),
        }
        self.read_presets();
    }
}

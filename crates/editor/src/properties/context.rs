//! Where a widget stands, and what the panel holds for all of them.

use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::evaluate::Screen;
use crate::field::Gesture;
use crate::prose::explained;
use crate::state::State;
use egui::{RichText, Ui};
use serde_json::Value;
use std::collections::HashSet;

/// What the panel holds besides what all see.
#[derive(Default)]
pub(crate) struct Properties {
    /// Places whose curves are open.
    pub(super) curves: HashSet<Path>,
    /// A painting to take colors from.
    pub(crate) reference: Option<(String, Screen)>,
    pub(super) texture: Option<egui::TextureHandle>,
    pub(super) dialog: Option<egui_file_dialog::FileDialog>,
}

/// What a widget needs to know of where it stands.
pub(super) struct WidgetContext<'p> {
    pub(super) state: &'p State,
    pub(super) path: Path,
    /// What the document writes there.
    pub(super) value: Option<&'p Value>,
}

impl WidgetContext<'_> {
    /// This value at this place; changes during one gesture are one step of undo.
    pub(super) fn set(&self, value: &Value) -> Edit {
        Edit::set(self.path.clone(), value).merging(self.path.to_string())
    }

    /// Asks for the default.
    pub(super) fn reset(&self, gesture: Gesture, actions: &mut Vec<Action>) {
        if self.value.is_some() {
            gesture.edit(Edit::reset(self.path.clone()), actions);
        }
    }
}

/// A label with what it means.
pub(super) fn label_ui(ui: &mut Ui, name: &str, help: &str, set: bool) -> egui::Response {
    let text = name.replace('_', " ");
    let text = if set { RichText::new(text).strong() } else { RichText::new(text) };
    // In a narrow panel, what is set needs the room more.
    let width = (0.4 * ui.available_size_before_wrap().x).clamp(56.0, 96.0);
    let size = egui::vec2(width, ui.spacing().interact_size.y);
    let label = ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_width(width);
        ui.add(egui::Label::new(text).truncate().sense(egui::Sense::click()))
    });
    explained(label.inner, help)
}

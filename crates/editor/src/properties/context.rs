//! Context shared by the widgets of the properties panel.

use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::evaluate::Screen;
use crate::field::Gesture;
use crate::prose::explained;
use crate::state::State;
use egui::{RichText, Ui};
use serde_json::Value;
use std::collections::HashSet;

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Properties {
    /// Paths whose curves are shown.
    pub(super) curves: HashSet<Path>,
    /// Reference painting to pick colors from.
    pub(crate) reference: Option<(String, Screen)>,
    pub(super) texture: Option<egui::TextureHandle>,
    pub(super) dialog: Option<egui_file_dialog::FileDialog>,
}

/// Path and value that a widget edits.
pub(super) struct WidgetContext<'p> {
    pub(super) state: &'p State,
    pub(super) path: Path,
    /// Value in the document.
    pub(super) value: Option<&'p Value>,
}

impl WidgetContext<'_> {
    /// Creates an edit that sets the value; edits during one gesture merge into one undo step.
    pub(super) fn set(&self, value: &Value) -> Edit {
        Edit::set(self.path.clone(), value).merging(self.path.to_string())
    }

    /// Requests a reset to the default.
    pub(super) fn reset(&self, gesture: Gesture, actions: &mut Vec<Action>) {
        if self.value.is_some() {
            gesture.edit(Edit::reset(self.path.clone()), actions);
        }
    }
}

/// Draws a label with a tooltip.
pub(super) fn label_ui(ui: &mut Ui, name: &str, help: &str, set: bool) -> egui::Response {
    let text = name.replace('_', " ");
    let text = if set { RichText::new(text).strong() } else { RichText::new(text) };
    // In a narrow panel, the value gets more of the width.
    let width = (0.4 * ui.available_size_before_wrap().x).clamp(56.0, 96.0);
    let size = egui::vec2(width, ui.spacing().interact_size.y);
    let label = ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_width(width);
        ui.add(egui::Label::new(text).truncate().sense(egui::Sense::click()))
    });
    explained(label.inner, help)
}

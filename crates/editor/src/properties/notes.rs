//! Notes on a node, an output, or the document.

use super::context::{Properties, WidgetContext};
use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::field;
use crate::state::State;
use egui::Ui;
use serde_json::Value;

/// Draws the notes at a path, with a field to edit them.
pub(super) fn notes_ui(panel: &Properties, ui: &mut Ui, state: &State, path: &Path, actions: &mut Vec<Action>) {
    let place = WidgetContext::new(state, path.to("notes"), state.sheet().get(&path.to("notes")));
    let text = place.value.and_then(Value::as_str).unwrap_or_default();
    let told = field::text_ui(ui, text, |text| {
        egui::TextEdit::multiline(text).hint_text("Notes").desired_rows(2).desired_width(f32::INFINITY)
    });
    panel.mark(ui, &place.path, &told.response);
    told.edit(actions, |text| match text.as_str() {
        "" => Edit::reset(place.path.clone()).merging(place.path.to_string()),
        text => place.set(&text.into()),
    });
}

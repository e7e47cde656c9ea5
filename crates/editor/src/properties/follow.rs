//! Knobs that are dropped on others: these follow them.

use super::context::WidgetContext;
use crate::actions::Action;
use crate::field::{FieldResponse, Gesture};
use crate::follow::HeldKnob;
use crate::refusal::refusal_ui;
use egui::{Color32, Rect, Response, Stroke, StrokeKind, Ui, vec2};
use serde_json::Value;
use trochoid::Item;

/// Lets the row of a knob or constant take a knob that is dropped on it. If it cannot follow that one, its name says why.
pub(super) fn target_ui(
    ui: &Ui,
    row: Rect,
    name: &Response,
    item: &Item,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    refusal_ui(ui, name);
    let Some(held) = HeldKnob::held(ui.ctx()).filter(|held| ui.is_enabled() && held.path != place.path) else { return };
    let own = Rect::from_min_max(row.min, egui::pos2(ui.max_rect().right(), row.bottom()));
    if !ui.rect_contains_pointer(own) {
        return;
    }
    outline(ui, row, held.fits(item));
    if let Some(gesture) = Gesture::release(ui) {
        egui::DragAndDrop::clear_payload(ui.ctx());
        actions.push(Action::Seal);
        gesture.tried(name).edit(held.followed_by(place.places()), actions);
        actions.push(Action::Seal);
    }
}

/// Lets the field of a component take a number that is dropped on it.
pub(super) fn component_ui(ui: &Ui, mut own: FieldResponse<Value>, item: &Item) -> FieldResponse<Value> {
    let held = HeldKnob::held(ui.ctx()).filter(|held| ui.is_enabled() && held.fits_components(item));
    let Some(held) = held.filter(|_| ui.rect_contains_pointer(own.response.rect)) else { return own };
    outline(ui, own.response.rect, true);
    if let Some(gesture) = Gesture::release(ui) {
        egui::DragAndDrop::clear_payload(ui.ctx());
        own.given = Some((held.link.clone().into(), gesture.tried(&own.response)));
    }
    own
}

fn outline(ui: &Ui, area: Rect, fits: bool) {
    let visuals = ui.visuals();
    let color: Color32 = if fits { visuals.selection.stroke.color } else { crate::theme::error(visuals) };
    ui.painter().rect_stroke(area.expand2(vec2(2.0, 1.0)), 3.0, Stroke::new(1.5, color), StrokeKind::Outside);
}

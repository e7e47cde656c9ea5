//! What the viewer says in the place of a picture, and over it.

use crate::actions::Action;
use crate::document::VersionStatus;
use crate::state::State;
use egui::{Align2, Color32, FontId, Rect, RichText, Ui, UiBuilder, pos2, vec2};

/// Draws the message why there is no picture, with a button that goes to the node at fault.
pub(super) fn message_ui(ui: &mut Ui, area: Rect, state: &State, actions: &mut Vec<Action>) {
    let meaning = state.session.meaning();
    let (text, color) = match (&state.evaluated.failed, &state.look.node) {
        // What concerns the whole document stands at the top of the window.
        (Some(_), _) if !meaning.readable || VersionStatus::of(&meaning.sheet.value).notice().is_some() => {
            ("No picture: the message at the top says why.".into(), Color32::from_gray(190))
        }
        // A question of permission is no fault of the document.
        (Some(why), _) if !state.evaluated.refused.is_empty() => (why.clone(), Color32::from_gray(225)),
        (Some(why), _) => (why.clone(), Color32::from_rgb(0xf0, 0x90, 0x80)),
        (None, None) => ("Select a node in the graph and press 1 to view it.".into(), Color32::from_gray(190)),
        (None, Some(_)) => ("Evaluating …".into(), Color32::from_gray(150)),
    };
    let room =
        Rect::from_center_size(area.center(), vec2((area.width() - 32.0).clamp(40.0, 520.0), area.height() - 24.0));
    let galley = ui.painter().layout(text.clone(), FontId::proportional(14.0), color, room.width());
    // At the top if the last picture is visible below.
    let align = if state.evaluated.last.is_some() { Align2::CENTER_TOP } else { Align2::CENTER_CENTER };
    let place = align.align_size_within_rect(galley.size(), room);
    if state.evaluated.last.is_some() {
        ui.painter().rect_filled(place.expand2(vec2(10.0, 6.0)), 4.0, Color32::from_black_alpha(190));
    }
    ui.scope_builder(UiBuilder::new().max_rect(place.expand(2.0)).id_salt("message"), |ui| {
        ui.label(RichText::new(text).color(color).size(14.0));
    });
    if state.evaluated.failed.is_none() {
        return;
    }
    let below = Rect::from_min_max(pos2(place.left() - 2.0, place.bottom() + 8.0), area.max);
    if !state.evaluated.refused.is_empty() {
        ui.scope_builder(UiBuilder::new().max_rect(below).id_salt("refused"), |ui| {
            let has_file = state.session.file().is_some();
            actions.extend(crate::reach::buttons_ui(ui, &state.evaluated.refused, has_file).map(Action::Allow));
        });
        return;
    }
    // The node that the message is about: others may have errors, too.
    if let Some(culprit) = state.evaluated.culprit.clone() {
        ui.scope_builder(UiBuilder::new().max_rect(below).id_salt("culprit"), |ui| {
            if ui.button(format!("Show {culprit}")).on_hover_text("Select the node at fault").clicked() {
                actions.push(Action::Visit(culprit));
            }
        });
    }
}

/// Returns the note for a node that is not a picture itself.
pub(super) fn clay(state: &State) -> String {
    let kind = state.looked().and_then(|(sheet, node, output)| sheet.nodes[node].makes.get(output)?.1);
    let kind = kind.map_or_else(|| "node".into(), |kind| kind.to_string());
    format!("Clay shading: a {kind} is not a picture")
}

/// Draws a note in the picture's upper left corner.
pub(super) fn note(ui: &mut Ui, area: Rect, text: &str) {
    let galley = ui.painter().layout_no_wrap(text.into(), FontId::proportional(12.0), Color32::WHITE);
    let back = Rect::from_min_size(area.min + vec2(8.0, 8.0), galley.size() + vec2(12.0, 6.0));
    ui.painter().rect_filled(back, 4.0, Color32::from_black_alpha(150));
    ui.scope_builder(UiBuilder::new().max_rect(back.shrink2(vec2(6.0, 3.0))).id_salt("note"), |ui| {
        ui.label(RichText::new(text).size(12.0).color(Color32::WHITE));
    });
}

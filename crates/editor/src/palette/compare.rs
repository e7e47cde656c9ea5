//! Other palettes, in which the picture is shown without changing the document.

use super::Palette;
use crate::actions::{Action, OtherPalette};
use crate::document::palette_file;
use crate::document::swatches;
use crate::state::State;
use egui::{Align, Button, Color32, Layout, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, vec2};
use std::sync::Arc;

/// Height of a palette's strip of colors, in points.
const STRIP: f32 = 10.0;

/// Draws the palettes that are compared: a click shows the picture in one of them.
pub(super) fn compare_ui(panel: &mut Palette, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    if panel.others.is_empty() {
        return;
    }
    let compared = state.colors.compared.as_ref();
    ui.horizontal_wrapped(|ui| {
        let own = ui.selectable_label(compared.is_none(), "Document");
        if own.on_hover_text("Show the picture in the document's own palette").clicked() {
            actions.push(Action::ComparePalette(None));
        }
        if state.evaluated.mixture.is_none() && compared.is_some() {
            ui.weak("shown once the picture is weighed");
        }
    });
    let mut closed = None;
    for (index, other) in panel.others.iter().enumerate() {
        let is_shown = compared.is_some_and(|compared| Arc::ptr_eq(compared, other));
        let letter = char::from(b'A' + (index % 26) as u8);
        ui.horizontal(|ui| {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let close = ui.add(Button::new("×").small().frame(false));
                close.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Close {}", other.name)));
                if close.on_hover_text("Compare with this palette no more").clicked() {
                    closed = Some(index);
                }
                if is_shown {
                    let used = ui.button("Use this palette").on_hover_text("Write its colors into the document");
                    if used.clicked() {
                        actions.push(Action::TakePalette(other.entries.clone(), other.name.clone()));
                        actions.push(Action::ComparePalette(None));
                    }
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    let label = ui.add(Button::selectable(is_shown, format!("{letter}  {}", other.name)).truncate());
                    let help = "Show the picture in this palette; the document stays as it is";
                    if label.on_hover_text(help).clicked() {
                        actions.push(Action::ComparePalette((!is_shown).then(|| other.clone())));
                    }
                });
            });
        });
        strip_ui(ui, other, state);
    }
    if let Some(index) = closed {
        let gone = panel.others.remove(index);
        if compared.is_some_and(|compared| Arc::ptr_eq(compared, &gone)) {
            actions.push(Action::ComparePalette(None));
        }
    }
}

/// Draws the colors of a palette side by side.
fn strip_ui(ui: &mut Ui, other: &OtherPalette, state: &State) {
    let colors = palette_file::displayed(&other.entries, swatches::space(state.sheet()), state.frame);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), STRIP), Sense::hover());
    let width = rect.width() / colors.len().max(1) as f32;
    for (index, color) in colors.iter().enumerate() {
        let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
        let piece = Rect::from_min_size(rect.min + vec2(index as f32 * width, 0.0), vec2(width, rect.height()));
        ui.painter().rect_filled(piece, 0.0, Color32::from_rgb(r, g, b));
    }
    let rim = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    ui.painter().rect_stroke(rect, 1.0, rim, StrokeKind::Inside);
}

//! Other palettes, in which the picture is shown without changing the document.

use super::Palette;
use crate::actions::{Action, OtherPalette};
use crate::document::palette_file;
use crate::document::swatches;
use crate::state::State;
use egui::{Color32, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, vec2};
use std::sync::Arc;

/// Colors of a palette that are drawn on its button.
const COLORS: usize = 10;
/// Width and height of a palette's strip of colors, in points.
const STRIP: [f32; 2] = [120.0, 12.0];

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
        ui.horizontal(|ui| {
            let letter = char::from(b'A' + (index % 26) as u8);
            let label = ui.selectable_label(is_shown, format!("{letter}  {}", other.name));
            if label.on_hover_text("Show the picture in this palette; the document stays as it is").clicked() {
                actions.push(Action::ComparePalette((!is_shown).then(|| other.clone())));
            }
            strip_ui(ui, other, state);
            if is_shown {
                let used = ui.button("Use this palette").on_hover_text("Write its colors into the document");
                if used.clicked() {
                    actions.push(Action::TakePalette(other.entries.clone(), other.name.clone()));
                    actions.push(Action::ComparePalette(None));
                }
            }
            let close = ui.add(egui::Button::new("×").small().frame(false));
            close.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Close {}", other.name)));
            if close.on_hover_text("Compare with this palette no more").clicked() {
                closed = Some(index);
            }
        });
    }
    if let Some(index) = closed {
        let gone = panel.others.remove(index);
        if compared.is_some_and(|compared| Arc::ptr_eq(compared, &gone)) {
            actions.push(Action::ComparePalette(None));
        }
    }
}

/// Draws the first colors of a palette side by side.
fn strip_ui(ui: &mut Ui, other: &OtherPalette, state: &State) {
    let colors = palette_file::displayed(&other.entries, swatches::space(state.sheet()), state.frame);
    let (rect, _) = ui.allocate_exact_size(vec2(STRIP[0].min(ui.available_width()), STRIP[1]), Sense::hover());
    let count = colors.len().clamp(1, COLORS);
    let width = rect.width() / count as f32;
    for (index, color) in colors.iter().take(COLORS).enumerate() {
        let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
        let piece = Rect::from_min_size(rect.min + vec2(index as f32 * width, 0.0), vec2(width, rect.height()));
        ui.painter().rect_filled(piece, 0.0, Color32::from_rgb(r, g, b));
    }
    let rim = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    ui.painter().rect_stroke(rect, 1.0, rim, StrokeKind::Inside);
}

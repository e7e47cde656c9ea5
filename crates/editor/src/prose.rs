//! Texts with knob names and values in backticks, as in nodes' declarations; and messages adapted to the editor.

use egui::text::{LayoutJob, TextFormat};
use egui::{FontFamily, FontId, TextStyle, Ui};

/// Size of monospace letters beside others, which look smaller at the same size.
pub(crate) const MONOSPACE: f32 = 0.94;

/// Lays out a text with the parts in backticks in a monospace font.
pub(crate) fn prose(ui: &Ui, text: &str, style: &TextStyle, is_weak: bool) -> LayoutJob {
    let font = style.resolve(ui.style());
    let visuals = ui.visuals();
    let color = if is_weak { visuals.weak_text_color() } else { visuals.text_color() };
    let mut job = LayoutJob::default();
    job.wrap.max_width = ui.available_width();
    for (index, part) in text.split('`').enumerate() {
        let family = if index % 2 == 1 { FontFamily::Monospace } else { font.family.clone() };
        let size = if index % 2 == 1 { MONOSPACE * font.size } else { font.size };
        job.append(part, 0.0, TextFormat::simple(FontId::new(size, family), color));
    }
    job
}

/// Draws such a text as a wrapped label.
pub(crate) fn prose_ui(ui: &mut Ui, text: &str) {
    let job = prose(ui, text, &TextStyle::Body, false);
    ui.add(egui::Label::new(job).wrap());
}

/// Shows such a text as a tooltip.
pub(crate) fn explained(response: egui::Response, text: &str) -> egui::Response {
    response.on_hover_ui(|ui| {
        ui.set_max_width(ui.spacing().tooltip_width);
        prose_ui(ui, text);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backticks_become_code() {
        egui::__run_test_ui(|ui| {
            let job = prose(ui, "0 below `min`, 1 above `max`.", &TextStyle::Body, false);
            assert_eq!(job.text, "0 below min, 1 above max.");
            let families = job.sections.iter().map(|section| section.format.font_id.family == FontFamily::Monospace);
            assert_eq!(families.collect::<Vec<_>>(), [false, true, false, true, false]);
        });
    }
}

//! Texts that name knobs and values in backticks, as nodes' declarations do.

use egui::text::{LayoutJob, TextFormat};
use egui::{FontFamily, FontId, TextStyle, Ui};

/// A text whose parts in backticks are drawn as code, of a style's size.
pub(crate) fn prose(ui: &Ui, text: &str, style: &TextStyle, is_weak: bool) -> LayoutJob {
    let font = style.resolve(ui.style());
    let visuals = ui.visuals();
    let color = if is_weak { visuals.weak_text_color() } else { visuals.text_color() };
    let mut job = LayoutJob::default();
    job.wrap.max_width = ui.available_width();
    for (index, part) in text.split('`').enumerate() {
        let family = if index % 2 == 1 { FontFamily::Monospace } else { font.family.clone() };
        // Letters of one width look larger than others.
        let size = if index % 2 == 1 { 0.94 * font.size } else { font.size };
        job.append(part, 0.0, TextFormat::simple(FontId::new(size, family), color));
    }
    job
}

/// A label of such a text.
pub(crate) fn prose_ui(ui: &mut Ui, text: &str) {
    let job = prose(ui, text, &TextStyle::Body, false);
    ui.add(egui::Label::new(job).wrap());
}

/// What such a text says when the pointer rests on something.
pub(crate) fn explained(response: egui::Response, text: &str) -> egui::Response {
    response.on_hover_ui(|ui| {
        ui.set_max_width(ui.spacing().tooltip_width);
        prose_ui(ui, text);
    })
}

/// Remedies of the command line, and what is done here instead; a `…` is whatever stands there.
const REMEDIES: [(&str, &str); 6] = [
    ("if you trust the document with this file: --allow …", "allow it here if you trust the document"),
    ("if you trust the document with these files: --allow …", "allow them here if you trust the document"),
    ("or replace it with --overwrite", "or move the file away that is there"),
    ("or say --overwrite", "or move the file away that is there"),
    (", or to try it by --set …", ""),
    ("; or allow more memory (--memory, or Settings::memory_limit)", ""),
];

/// A message of the library as the editor says it: with what is to be done here, and no options of the command line.
pub(crate) fn here(message: &str) -> String {
    let mut lines: Vec<String> = message.split('\n').map(String::from).collect();
    for line in &mut lines {
        for (there, here) in REMEDIES {
            let (begin, to_end) = there.strip_suffix('…').map_or((there, false), |begin| (begin, true));
            if let Some(at) = line.find(begin) {
                let end = if to_end { line.len() } else { at + begin.len() };
                line.replace_range(at..end, here);
            }
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::{AccessViolation, OutputError};

    #[test]
    fn messages_name_no_options_of_the_command_line() {
        let outside = AccessViolation { leads_to: "/plates/a.png".into(), allowed: vec!["/shots".into()] };
        let told = here(&outside.to_string());
        assert!(told.ends_with("/shots; allow it here if you trust the document"), "{told}");
        let told = here(&OutputError::Foreign { path: "/plates/a.png".into() }.to_string());
        assert!(told.ends_with("give another name, or move the file away that is there"), "{told}");
        assert_eq!(here("a plain\nmessage"), "a plain\nmessage");
    }

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

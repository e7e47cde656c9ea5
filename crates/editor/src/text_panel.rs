//! The text panel: the document as JSON text, which everything else is derived from.

use crate::actions::Action;
use crate::state::State;
use egui::{Label, Margin, RichText, ScrollArea, TextEdit, TextStyle, Ui};

/// State of the text panel.
#[derive(Debug, Default)]
pub(crate) struct TextPanel {
    draft: Option<Draft>,
    /// Incremented by every change of the draft.
    typings: u64,
}

#[derive(Debug)]
struct Draft {
    /// Revision of the document that the draft was last compared with.
    revision: u64,
    text: String,
    /// Whether the draft differs from that revision.
    typed: bool,
}

impl TextPanel {
    /// Returns the typed text that is not applied yet.
    pub(crate) fn pending(&self) -> Option<&str> {
        self.draft.as_ref().filter(|draft| draft.typed).map(|draft| draft.text.as_str())
    }

    /// Removes and returns the typed text, to apply it.
    pub(crate) fn take(&mut self) -> Option<String> {
        self.draft.take().filter(|draft| draft.typed).map(|draft| draft.text)
    }

    /// Returns a counter that every change of the draft increments.
    pub(crate) fn typings(&self) -> u64 {
        self.typings
    }
}

/// Margin of the field.
const FIELD: Margin = Margin::symmetric(4, 2);

/// Returns the numbers of the lines of a text, one below the other.
fn numbers(text: &str) -> String {
    let count = text.split('\n').count();
    let width = count.to_string().len();
    (1..=count).map(|line| format!("{line:>width$}")).collect::<Vec<String>>().join("\n")
}

/// Draws the text, with its faults and their places above.
pub(crate) fn text_panel_ui(panel: &mut TextPanel, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let session = &state.session;
    if let Some(draft) = panel.draft.as_mut().filter(|draft| draft.revision != session.revision()) {
        draft.revision = session.revision();
        // Typed text is kept whatever happens to the document in the meantime.
        if !draft.typed {
            draft.text = session.text().into();
        }
        draft.typed = draft.text != session.text();
    }
    let typed = panel.pending().is_some();
    ui.horizontal(|ui| {
        if ui
            .add_enabled(typed, egui::Button::new("Apply"))
            .on_hover_text("Replace the document with this text (one undo step)")
            .clicked()
            && let Some(text) = panel.take()
        {
            actions.push(Action::Rewrite(text));
        }
        if ui.add_enabled(typed, egui::Button::new("Revert")).clicked() {
            panel.draft = None;
            panel.typings += 1;
        }
        if typed {
            ui.weak("Not applied yet");
        }
    });
    for fault in session.meaning().diagnostics.iter().take(5) {
        let color = crate::faults::color(ui.visuals(), fault);
        let place = if fault.line > 0 { format!("{}:{}: ", fault.line, fault.column) } else { String::new() };
        let parts: Vec<&str> = [&fault.node, &fault.port].into_iter().flatten().map(String::as_str).collect();
        let parts = if parts.is_empty() { String::new() } else { format!("{}: ", parts.join(", ")) };
        ui.label(
            RichText::new(format!("{place}{parts}found {}; expected {}", fault.found, fault.expected)).color(color),
        )
        .on_hover_text(&fault.remedy);
    }
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let draft = panel.draft.get_or_insert_with(|| Draft {
            revision: session.revision(),
            text: session.text().into(),
            typed: false,
        });
        ui.horizontal_top(|ui| {
            let numbers = Label::new(RichText::new(numbers(&draft.text)).monospace().weak()).selectable(false);
            // As high as the first line of the field, which has a margin.
            ui.vertical(|ui| {
                ui.add_space(FIELD.top.into());
                ui.add(numbers.extend());
            });
            let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| {
                let font = TextStyle::Monospace.resolve(ui.style());
                ui.fonts_mut(|fonts| fonts.layout_no_wrap(text.as_str().into(), font, ui.visuals().text_color()))
            };
            let edit = TextEdit::multiline(&mut draft.text).code_editor().margin(FIELD).desired_width(f32::INFINITY);
            if ui.add(edit.layouter(&mut layout)).changed() {
                draft.typed = draft.text != session.text();
                panel.typings += 1;
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_has_its_number() {
        assert_eq!(numbers(""), "1");
        assert_eq!(numbers("{\n}"), "1\n2");
        assert_eq!(numbers(&"\n".repeat(9)), " 1\n 2\n 3\n 4\n 5\n 6\n 7\n 8\n 9\n10", "the last line is empty");
    }
}

//! The panel of the document's text: what everything else here is made of.

use crate::actions::Action;
use crate::state::State;
use egui::{RichText, ScrollArea, TextEdit, Ui};

/// The text while it is being edited.
#[derive(Debug, Default)]
pub(crate) struct Source {
    /// What is typed, and of which revision of the document it began.
    draft: Option<(u64, String)>,
}

/// Shows the text, and its faults with their places.
pub(crate) fn source_ui(source: &mut Source, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let session = &state.session;
    if source.draft.as_ref().is_some_and(|(revision, _)| *revision != session.revision()) {
        // Something else has changed the document; what was typed would undo that.
        source.draft = None;
    }
    let typed = source.draft.as_ref().is_some_and(|(_, text)| text != session.text());
    ui.horizontal(|ui| {
        if ui
            .add_enabled(typed, egui::Button::new("Apply"))
            .on_hover_text("Makes this the document (one step of undo).")
            .clicked()
            && let Some((_, text)) = source.draft.take()
        {
            actions.push(Action::Rewrite(text));
        }
        if ui.add_enabled(typed, egui::Button::new("Revert")).clicked() {
            source.draft = None;
        }
        if typed {
            ui.weak("Not applied yet");
        }
    });
    for fault in session.meaning().diagnostics.iter().take(5) {
        let color = match fault.severity {
            trochoid::Severity::Error => crate::theme::error(ui.visuals()),
            trochoid::Severity::Warning => ui.visuals().warn_fg_color,
        };
        let place = if fault.line > 0 { format!("{}:{}: ", fault.line, fault.column) } else { String::new() };
        let parts: Vec<&str> = [&fault.node, &fault.port].into_iter().flatten().map(String::as_str).collect();
        let parts = if parts.is_empty() { String::new() } else { format!("{}: ", parts.join(", ")) };
        ui.label(
            RichText::new(format!("{place}{parts}found {}; expected {}", fault.found, fault.expected)).color(color),
        )
        .on_hover_text(&fault.remedy);
    }
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let (_, text) = source.draft.get_or_insert_with(|| (session.revision(), session.text().to_string()));
        let edit = TextEdit::multiline(text).code_editor().desired_width(f32::INFINITY);
        ui.add(edit);
    });
}

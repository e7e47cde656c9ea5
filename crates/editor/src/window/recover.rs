//! The prompt that offers backups of editors that ended unexpectedly.

use super::modal::titled;
use crate::document::keep::{UnsavedCopy, discard};
use crate::editor::Editor;
use crate::prompts::Prompt;
use egui::{Context, Modal, RichText, ScrollArea};
use std::time::SystemTime;

/// Draws the prompt; each backup can be recovered or discarded.
pub(super) fn recover_ui(editor: &mut Editor, context: &Context, mut kept: Vec<UnsavedCopy>) -> Option<Prompt> {
    let (mut chosen, mut dropped, mut later) = (None, None, false);
    Modal::new("recover".into()).show(context, |ui| {
        titled(ui, "Recover unsaved work?");
        ui.label("The editor ended unexpectedly. These unsaved changes can be recovered:");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
            for (index, kept) in kept.iter().enumerate() {
                ui.horizontal(|ui| {
                    let name = kept
                        .file
                        .as_ref()
                        .and_then(|file| file.file_name())
                        .map_or_else(|| "untitled".into(), |name| name.to_string_lossy().into_owned());
                    let label = ui.label(RichText::new(name).strong());
                    if let Some(file) = &kept.file {
                        label.on_hover_text(file.display().to_string());
                    }
                    ui.label(ago(kept.when));
                    if kept.overtaken {
                        let help =
                            "Another program has changed the file since. Recovering does not touch it; saving asks first.";
                        let text = RichText::new("the file is newer").color(ui.visuals().warn_fg_color);
                        ui.label(text).on_hover_text(help);
                    }
                    if ui.button("Recover").clicked() {
                        chosen = Some(index);
                    }
                    if ui.button("Discard").on_hover_text("Delete this backup; this cannot be undone").clicked() {
                        dropped = Some(index);
                    }
                });
            }
        });
        ui.add_space(8.0);
        let again = if kept.iter().all(|kept| kept.file.is_none()) { "editor starts" } else { "document is opened" };
        later = ui.button("Later").on_hover_text(format!("Ask again the next time the {again}")).clicked();
    });
    if let Some(index) = dropped {
        discard(&kept.remove(index));
    }
    if let Some(index) = chosen {
        let kept = kept.swap_remove(index);
        editor.recover(&kept, context);
        return None;
    }
    (!later && !kept.is_empty()).then_some(Prompt::Recover(kept))
}

fn ago(when: SystemTime) -> String {
    let seconds = when.elapsed().map_or(0, |time| time.as_secs());
    match seconds {
        0..60 => "just now".into(),
        60..3600 => format!("{} ago", crate::document::edit::count(seconds as usize / 60, "minute")),
        3600..86_400 => format!("{} ago", crate::document::edit::count(seconds as usize / 3600, "hour")),
        _ => format!("{} ago", crate::document::edit::count(seconds as usize / 86_400, "day")),
    }
}

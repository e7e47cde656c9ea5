//! The dialog of permissions given to documents.

use super::modal::titled;
use crate::actions::{Action, Grant};
use crate::editor::Editor;
use crate::reach::{read, whole};
use egui::{Context, Modal, ScrollArea, Ui, WidgetInfo, WidgetType};

/// Draws the permissions of all documents and revokes them on request; returns whether the dialog stays open.
pub(super) fn allowed_ui(editor: &mut Editor, context: &Context) -> bool {
    let state = editor.state();
    let own = state.session.file().map(whole);
    let mut others = editor.prompts.data().map(read).unwrap_or_default();
    others.retain(|(document, _)| Some(document) != own.as_ref());
    let mut asked = None;
    let mut closes = false;
    let modal = Modal::new("allowed".into()).show(context, |ui| {
        titled(ui, "Allowed folders");
        ui.label("Folders outside their own that documents were allowed to read or write in.");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            ui.strong(format!("{} (open)", state.session.title()));
            asked = grants_ui(ui, &editor.answers).map(|grant| Action::Forbid(None, grant));
            for (document, grants) in &others {
                ui.add_space(4.0);
                ui.strong(document.display().to_string());
                let taken = grants_ui(ui, grants).map(|grant| Action::Forbid(Some(document.clone()), grant));
                asked = asked.take().or(taken);
            }
        });
        ui.add_space(8.0);
        closes = ui.button("Close").clicked();
    });
    if let Some(action) = asked {
        editor.act(action, context);
    }
    !closes && !modal.should_close()
}

/// Draws a row for each permission; returns the one to revoke.
fn grants_ui(ui: &mut Ui, grants: &[Grant]) -> Option<Grant> {
    let mut taken = None;
    if grants.is_empty() {
        ui.weak("No folders outside its own.");
    }
    for grant in grants {
        ui.horizontal(|ui| {
            let remove = ui.button("Remove").on_hover_text("Revoke this permission");
            remove.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Remove {grant}")));
            if remove.clicked() {
                taken = Some(grant.clone());
            }
            ui.add(egui::Label::new(grant.to_string()).wrap());
        });
    }
    taken
}

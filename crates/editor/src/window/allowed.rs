//! What documents were allowed.

use super::modal::titled;
use crate::actions::{Action, Grant};
use crate::editor::Editor;
use crate::reach::{read, whole};
use egui::{Context, Modal, ScrollArea, Ui, WidgetInfo, WidgetType};

/// Shows which folders documents were allowed, and takes them back; whether it stays open.
pub(super) fn allowed_ui(editor: &mut Editor, context: &Context) -> bool {
    let state = editor.state();
    let own = state.session.file().map(whole);
    let mut others = editor.prompts.data().map(read).unwrap_or_default();
    others.retain(|(document, _)| Some(document) != own.as_ref());
    let mut asked = None;
    let mut closes = false;
    let modal = Modal::new("allowed".into()).show(context, |ui| {
        titled(ui, "Allowed folders");
        ui.label("Where documents may read and write besides their own folders, because it was allowed here.");
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

/// A row for each folder, with what is allowed there; gives what is taken back.
fn grants_ui(ui: &mut Ui, grants: &[Grant]) -> Option<Grant> {
    let mut taken = None;
    if grants.is_empty() {
        ui.weak("No folder besides its own.");
    }
    for grant in grants {
        ui.horizontal(|ui| {
            let remove = ui.button("Remove").on_hover_text("It is asked again when the document needs it next.");
            remove.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Remove {grant}")));
            if remove.clicked() {
                taken = Some(grant.clone());
            }
            ui.add(egui::Label::new(grant.to_string()).wrap());
        });
    }
    taken
}

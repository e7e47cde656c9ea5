//! Prompts before a document is left or overwritten: about unsaved work, changes by another program, and rendering.

use super::modal::{answer_ui, titled};
use crate::actions::{Action, After};
use crate::editor::Editor;
use crate::prompts::Prompt;
use egui::{Context, Modal};
use std::path::Path;

pub(super) fn unsaved_ui(editor: &mut Editor, context: &Context, after: After) -> Option<Prompt> {
    let mut answer = None;
    let modal = Modal::new("unsaved".into()).show(context, |ui| {
        titled(ui, "Save changes?");
        let text = format!("“{}” has unsaved changes.", editor.state().session.title());
        ui.add(egui::Label::new(&text).truncate()).on_hover_text(&text);
        ui.add_space(8.0);
        answer = answer_ui(ui, &["Save", "Discard", "Cancel"]);
    });
    match answer {
        Some("Save") => {
            editor.store(Some(after), context);
            None
        }
        Some("Discard") => {
            editor.go(after, context);
            None
        }
        Some(_) => None,
        None if modal.should_close() => None,
        None => Some(Prompt::Unsaved(after)),
    }
}

pub(super) fn newer_ui(editor: &mut Editor, context: &Context, after: Option<After>) -> Option<Prompt> {
    let mut answer = None;
    let modal = Modal::new("newer".into()).show(context, |ui| {
        titled(ui, "Overwrite a newer document?");
        let session = &editor.state().session;
        ui.label(format!("“{}” uses a format version that this editor does not support.", session.title()));
        ui.label("Unsupported entries stay unchanged, but may be inconsistent with your changes.");
        ui.add_space(8.0);
        answer = answer_ui(ui, &["Save a copy …", "Overwrite", "Cancel"]);
    });
    match answer {
        Some("Save a copy …") => {
            let Editor { prompts, state, .. } = editor;
            prompts.ask_save(&state.session, after);
        }
        Some("Overwrite") => {
            if let Some(file) = editor.state().session.file().map(Path::to_path_buf) {
                editor.save(&file, after, context);
            }
        }
        Some(_) => {}
        None if modal.should_close() => {}
        None => return Some(Prompt::Newer(after)),
    }
    None
}

pub(super) fn external_ui(editor: &mut Editor, context: &Context, saving: Option<Option<After>>) -> Option<Prompt> {
    let mut answer = None;
    let changed = editor.is_unsaved();
    let words: &[&str] =
        if saving.is_some() { &["Reload", "Overwrite", "Cancel"] } else { &["Reload", "Keep my version"] };
    Modal::new("external".into()).show(context, |ui| {
        titled(ui, "The file has changed");
        ui.label(format!("Another program changed “{}”.", editor.state().session.title()));
        if changed {
            ui.label("You have unsaved changes. Reloading can be undone.");
        }
        ui.add_space(8.0);
        answer = answer_ui(ui, words);
    });
    match (answer, saving) {
        (None, saving) => return Some(Prompt::External(saving)),
        (Some("Reload"), _) => editor.act(Action::Reload, context),
        (Some("Cancel"), _) => {}
        (Some(_), saving) => {
            editor.state.session.keep_mine();
            if let Some(after) = saving {
                editor.store(after, context);
            }
        }
    }
    None
}

pub(super) fn rendering_ui(editor: &mut Editor, context: &Context, after: After) -> Option<Prompt> {
    // If rendering has ended in the meantime, there is nothing to ask; the window stays open and shows the outcome.
    let render = editor.state().render.clone()?;
    let mut answer = None;
    let modal = Modal::new("rendering".into()).show(context, |ui| {
        titled(ui, "Stop rendering?");
        let (done, total) = render.done;
        ui.label(format!("{done} of {total} frames are written and will be kept."));
        ui.add_space(8.0);
        answer = answer_ui(ui, &["Stop", "Keep rendering"]);
    });
    match answer {
        Some("Stop") => {
            editor.end_render();
            editor.leave(after, context);
            None
        }
        Some(_) => None,
        None if modal.should_close() => None,
        None => Some(Prompt::Rendering(after)),
    }
}

//! The question that is open: drawn, and its answer done.

use super::modal::titled;
use super::{allowed, leave, palette, recover};
use crate::actions::{Action, After};
use crate::editor::Editor;
use crate::prompts::{FileQuestion, Prompt};
use egui::{Context, Modal, ScrollArea};
use std::path::{Path, PathBuf};
use trochoid::RefusedFile;

/// Asks what there is to ask, and does what is answered.
pub(super) fn prompts_ui(editor: &mut Editor, context: &Context, actions: &mut Vec<Action>) {
    files_ui(editor, context);
    let Some(prompt) = editor.prompts.open.take() else { return };
    let next = match prompt {
        Prompt::Unsaved(after) => leave::unsaved_ui(editor, context, after),
        Prompt::Newer(after) => leave::newer_ui(editor, context, after),
        Prompt::External(saving) => leave::external_ui(editor, context, saving),
        Prompt::Rendering(after) => leave::rendering_ui(editor, context, after),
        Prompt::Reach(refused) => reach_ui(editor, context, refused),
        Prompt::Recover(kept) => recover::recover_ui(editor, context, kept),
        Prompt::Replace(file, after) => replace_ui(editor, context, file, after),
        Prompt::Allowed => allowed::allowed_ui(editor, context).then_some(Prompt::Allowed),
        Prompt::Palette { text, chosen } => palette::palette_ui(editor, context, text, chosen, actions),
    };
    // An answer may have led to another question.
    editor.prompts.open = next.or(editor.prompts.open.take());
}

fn files_ui(editor: &mut Editor, context: &Context) {
    let Some(asking) = editor.prompts.asking.clone() else { return };
    editor.prompts.dialog.update(context);
    if let Some(file) = editor.prompts.dialog.take_picked() {
        editor.prompts.asking = None;
        match asking {
            FileQuestion::Open => editor.go(After::Open(file), context),
            FileQuestion::Save(after) => {
                let whole = meant(&file, editor.prompts.dialog.selected_entry().map(|entry| entry.to_path_buf()));
                // The dialog has asked about the file that it named, and about no other.
                if whole != file && whole.exists() {
                    editor.prompts.open = Some(Prompt::Replace(whole, after));
                } else {
                    editor.save(&whole, after, context);
                }
            }
        }
    } else if !matches!(editor.prompts.dialog.state(), egui_file_dialog::DialogState::Open) {
        editor.prompts.asking = None;
    }
}

/// The file that is meant by one that the dialog names: in the folder that is highlighted there, and with the ending that
/// the dialog shows.
fn meant(file: &Path, highlighted: Option<PathBuf>) -> PathBuf {
    let folder = highlighted.filter(|entry| entry.is_dir() && entry.parent() == file.parent());
    let name = file.file_name().unwrap_or_default();
    let mut whole = folder.map_or_else(|| file.as_os_str().to_owned(), |folder| folder.join(name).into_os_string());
    if file.extension().is_none_or(|end| end != "json") {
        whole.push(".json");
    }
    whole.into()
}

fn replace_ui(editor: &mut Editor, context: &Context, file: PathBuf, after: Option<After>) -> Option<Prompt> {
    let (mut replace, mut cancel) = (false, false);
    let modal = Modal::new("replace".into()).show(context, |ui| {
        titled(ui, "Replace the file?");
        let text = format!("{} is there already.", file.display());
        ui.add(egui::Label::new(&text).truncate()).on_hover_text(&text);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            replace = ui.button("Replace").clicked();
            cancel = ui.button("Cancel").clicked();
        });
    });
    if replace {
        editor.save(&file, after, context);
        return None;
    }
    (!cancel && !modal.should_close()).then_some(Prompt::Replace(file, after))
}

fn reach_ui(editor: &mut Editor, context: &Context, refused: Vec<RefusedFile>) -> Option<Prompt> {
    let (mut allowed, mut cancel) = (None, false);
    let modal = Modal::new("reach".into()).show(context, |ui| {
        titled(ui, "Let the document reach further?");
        ui.label("It cannot be rendered without files outside of what it may reach:");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
            for refused in &refused {
                ui.label(crate::prose::here(&refused.diagnostic().to_string()));
            }
        });
        ui.add_space(8.0);
        allowed = crate::reach::buttons_ui(ui, &refused, editor.state().session.file().is_some());
        cancel = ui.button("Cancel").clicked();
    });
    if let Some(grant) = allowed {
        editor.act(Action::Allow(grant), context);
        editor.act(Action::Render, context);
        return None;
    }
    (!cancel && !modal.should_close()).then_some(Prompt::Reach(refused))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_saved_in_the_folder_that_is_highlighted_as_json() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new");
        std::fs::create_dir(&new).unwrap();
        let at = |name: &str| folder.path().join(name);
        assert_eq!(meant(&at("untitled"), None), at("untitled.json"));
        assert_eq!(meant(&at("shot.v2"), None), at("shot.v2.json"));
        assert_eq!(meant(&at("dusk.json"), None), at("dusk.json"));
        assert_eq!(meant(&at("dusk.json"), Some(new.clone())), new.join("dusk.json"));
        std::fs::write(at("dusk.json"), "").unwrap();
        assert_eq!(meant(&at("dusk.json"), Some(at("dusk.json"))), at("dusk.json"), "a file is no folder");
    }
}

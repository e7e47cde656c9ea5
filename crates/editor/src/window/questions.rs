//! Draws the open prompt and performs the answer.

use super::modal::titled;
use super::{allowed, find, leave, name, palette as commands, recover, welcome};
use crate::actions::{Action, After, Pane};
use crate::document::edit::count;
use crate::document::{palette, palette_file, swatches};
use crate::editor::Editor;
use crate::prompts::{FileQuestion, Prompt};
use egui::{Context, Modal, ScrollArea};
use serde_json::Value;
use std::path::{Path, PathBuf};
use trochoid::RefusedFile;

/// Draws the open prompt, if any, and performs the answer.
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
        Prompt::Palette { text, chosen } => commands::palette_ui(editor, context, text, chosen, actions),
        Prompt::Colors(file, colors) => colors_ui(editor, context, file, colors, actions),
        Prompt::Welcome(shown) => welcome::welcome_ui(context, shown, actions),
        Prompt::Name(naming) => name::name_ui(context, naming, actions),
        Prompt::Find(search) => find::find_ui(context, search, actions),
    };
    // An answer may have opened another prompt.
    editor.prompts.open = next.or(editor.prompts.open.take());
}

fn files_ui(editor: &mut Editor, context: &Context) {
    let Some(asking) = editor.prompts.asking.clone() else { return };
    crate::dialogs::show(&mut editor.prompts.dialog, context);
    if let Some(file) = editor.prompts.dialog.take_picked() {
        editor.prompts.asking = None;
        match asking {
            FileQuestion::Open => editor.go(After::Open(file), context),
            FileQuestion::Save(after) => {
                let whole = meant(&file, editor.prompts.dialog.selected_entry().map(|entry| entry.to_path_buf()));
                // The dialog asked about overwriting only for the name it returned.
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

/// Returns the file to save to: in the folder highlighted in the dialog, if any, and with the extension `.json`.
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
        let text = format!("{} already exists.", file.display());
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
        titled(ui, "Allow access to more folders?");
        ui.label("Rendering needs files that the document may not access:");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
            for refused in &refused {
                ui.label(refused.diagnostic().to_string());
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

fn colors_ui(
    editor: &Editor,
    context: &Context,
    file: String,
    colors: Vec<(String, Value)>,
    actions: &mut Vec<Action>,
) -> Option<Prompt> {
    let (mut all, mut known, mut cancel) = (false, false, false);
    let own = editor.state().swatches();
    let own: Vec<&str> = palette::names(&own).collect();
    let alike = colors.iter().filter(|(name, _)| own.contains(&name.as_str())).count();
    let modal = Modal::new("colors".into()).show(context, |ui| {
        titled(ui, "Use these colors?");
        let text = format!("“{file}” has {}. Names that the document has, too: {alike}.", count(colors.len(), "color"));
        ui.add(egui::Label::new(text).wrap());
        ui.add_space(4.0);
        let space = swatches::space(editor.state().sheet());
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
            for [r, g, b] in palette_file::displayed(&colors, space, editor.state().frame) {
                let [r, g, b] = [r, g, b].map(|channel| (255.0 * channel).round() as u8);
                let (spot, _) = ui.allocate_exact_size(egui::vec2(16.0, 16.0), egui::Sense::hover());
                ui.painter().rect_filled(spot, 2.0, egui::Color32::from_rgb(r, g, b));
            }
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let help = "Replace the document's colors of the same names, and add the others to its palette";
            all = ui.button("Take all").on_hover_text(help).clicked();
            let replace = ui.add_enabled(alike > 0, egui::Button::new("Only those of the same names"));
            known = replace.on_hover_text("Replace the document's colors of the same names").clicked();
            cancel = ui.button("Cancel").clicked();
        });
    });
    if all || known {
        actions.push(Action::Panel(Pane::Palette));
        actions.push(if all { Action::JoinPalette(colors) } else { Action::TakePalette(colors, file) });
        return None;
    }
    (!cancel && !modal.should_close()).then_some(Prompt::Colors(file, colors))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_saved_as_json_in_the_highlighted_folder() {
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

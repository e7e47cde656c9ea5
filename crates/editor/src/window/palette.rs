//! The command palette.

use crate::actions::Action;
use crate::choice::{matches, moved};
use crate::commands::{Command, commands};
use crate::editor::Editor;
use crate::prompts::Prompt;
use egui::{Context, Key, Modal, ScrollArea};

/// Draws the command palette and runs the chosen command.
pub(super) fn palette_ui(
    editor: &mut Editor,
    context: &Context,
    mut text: String,
    mut chosen: usize,
    actions: &mut Vec<Action>,
) -> Option<Prompt> {
    let state = editor.state();
    let mut run: Option<&Command> = None;
    let modal = Modal::new("palette".into()).show(context, |ui| {
        ui.set_width(420.0);
        let field = ui.add(egui::TextEdit::singleline(&mut text).hint_text("Command …").desired_width(f32::INFINITY));
        field.request_focus();
        if field.changed() {
            chosen = 0;
        }
        let all: Vec<&Command> = commands().collect();
        let found = matches(&text, all.iter().enumerate().map(|(index, command)| (index, command.name)));
        let found: Vec<&Command> =
            found.into_iter().map(|index| all[index]).filter(|command| (command.enabled)(state)).collect();
        chosen = moved(ui, chosen, found.len());
        ScrollArea::vertical().max_height(320.0).min_scrolled_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            for (index, command) in found.iter().enumerate() {
                let button = egui::Button::selectable(index == chosen, command.name)
                    .shortcut_text(command.written_keys(ui.ctx()))
                    .min_size(egui::vec2(ui.available_width(), 0.0));
                let row = ui.add(button).on_hover_text(command.whole_help());
                if index == chosen {
                    row.scroll_to_me(None);
                }
                if row.clicked() {
                    run = Some(command);
                }
            }
            if found.is_empty() {
                ui.weak("No command matches.");
            }
        });
        // Nothing is chosen before something is typed or marked.
        if ui.input(|input| input.key_pressed(Key::Enter)) && (chosen > 0 || !text.trim().is_empty()) {
            run = found.get(chosen).copied();
        }
    });
    if let Some(command) = run {
        actions.push((command.action)(editor.state()));
        return None;
    }
    (!modal.should_close()).then_some(Prompt::Palette { text, chosen })
}

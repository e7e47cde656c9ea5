//! The prompt for a name under which something is kept.

use super::modal::titled;
use crate::actions::Action;
use crate::prompts::{Named, Naming, Prompt};
use egui::{Button, Context, Key, Modal, TextEdit, WidgetInfo, WidgetType};

/// Draws the prompt, and keeps what was named.
pub(super) fn name_ui(context: &Context, mut naming: Naming, actions: &mut Vec<Action>) -> Option<Prompt> {
    let (mut done, mut cancelled) = (false, false);
    let modal = Modal::new("name".into()).show(context, |ui| {
        let (title, hint) = match naming.of {
            Named::Preset => ("Save the knobs as a preset", "Name of the preset"),
            Named::Layout => ("Save the layout of the panels", "Name of the layout"),
        };
        titled(ui, title);
        let field = ui.add(TextEdit::singleline(&mut naming.text).hint_text(hint).desired_width(f32::INFINITY));
        field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, hint));
        field.request_focus();
        let name = naming.text.trim();
        let fault = crate::presets::wrong_name(name);
        // The line stays, so that the buttons do not move.
        match &fault {
            Some(why) if !name.is_empty() => {
                ui.colored_label(crate::theme::error(ui.visuals()), why.to_string());
            }
            _ if naming.taken.iter().any(|taken| taken == name) => {
                ui.colored_label(ui.visuals().warn_fg_color, "This name is taken: what has it will be replaced.");
            }
            _ => drop(ui.label("")),
        }
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            done = ui.add_enabled(fault.is_none(), Button::new("Save")).clicked();
            cancelled = ui.button("Cancel").clicked();
        });
        done |= fault.is_none() && ui.input(|input| input.key_pressed(Key::Enter));
    });
    if done {
        let name = naming.text.trim().to_string();
        actions.push(match naming.of {
            Named::Preset => Action::KeepPreset(name),
            Named::Layout => Action::KeepLayout(name),
        });
        return None;
    }
    (!cancelled && !modal.should_close()).then_some(Prompt::Name(naming))
}

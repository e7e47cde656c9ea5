//! Presets in the menu of nodes.

use super::Canvas;
use crate::actions::Action;
use egui::Ui;

impl Canvas {
    /// Draws the menu of the presets of a type. The knobs of one node can be kept as a new one.
    pub(super) fn presets_menu(&self, ui: &mut Ui, ty: &str, is_one: bool, actions: &mut Vec<Action>) {
        let known = self.presets.get(ty).map_or(&[][..], Vec::as_slice);
        ui.menu_button("Presets", |ui| {
            for name in known {
                if ui.button(name).on_hover_text("Give the selected nodes these knobs.").clicked() {
                    actions.push(Action::Preset(name.clone()));
                }
            }
            if !known.is_empty() {
                ui.separator();
            }
            let save = ui.add_enabled(is_one, egui::Button::new("Save as preset …"));
            if save.on_hover_text("Keep the knobs of this node under a name.").clicked() {
                actions.push(Action::NamePreset);
            }
            if !known.is_empty() {
                ui.menu_button("Delete preset", |ui| {
                    for name in known {
                        if ui.button(name).clicked() {
                            actions.push(Action::ForgetPreset(ty.into(), name.clone()));
                        }
                    }
                });
            }
        });
    }
}

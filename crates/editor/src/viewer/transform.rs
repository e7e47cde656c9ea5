//! The choice of what a viewer makes of light for the screen.

use crate::actions::Action;
use crate::evaluate::Display;
use crate::state::State;
use crate::transform::{Takes, Transform};
use egui::{ComboBox, Context, Ui, WidgetInfo, WidgetType};
use egui_file_dialog::{DialogState, FileDialog, Filter};
use std::path::Path;

/// What is said wherever it is chosen.
const HELP: &str = "For viewing only: files are written without it, and the palette's guarantee is about the file.";

/// An open dialog for the file of a table.
#[derive(Default)]
pub(super) struct Opening(Option<FileDialog>);

impl Opening {
    /// Asks for a file.
    fn ask(&mut self, state: &State) {
        let cube = Filter::new(|path: &Path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("cube")));
        let mut dialog = crate::dialogs::dialog().add_file_filter("Tables", cube).default_file_filter("Tables");
        let display = &state.look.display;
        let last = if let Transform::Cube(file) = &display.transform { file.path.parent() } else { None };
        dialog.config_mut().initial_directory = last.map_or_else(|| state.session.folder(), Path::to_path_buf);
        dialog.pick_file();
        self.0 = Some(dialog);
    }

    /// Draws the open dialog, and uses the file that it gives.
    pub(super) fn ui(&mut self, context: &Context, state: &State, actions: &mut Vec<Action>) {
        let Some(dialog) = &mut self.0 else { return };
        crate::dialogs::show(dialog, context);
        if let Some(file) = dialog.take_picked() {
            self.0 = None;
            choose(Transform::read(&file, Takes::Light), &file, state, actions);
        } else if !matches!(dialog.state(), DialogState::Open) {
            self.0 = None;
        }
    }
}

/// Requests a conversion, or says why there is none.
fn choose<E: std::fmt::Display>(read: Result<Transform, E>, file: &Path, state: &State, actions: &mut Vec<Action>) {
    actions.push(match read {
        Ok(transform) => Action::Display(Display { transform, ..state.look.display.clone() }),
        Err(why) => Action::Notice(format!("{}: {why}", file.display())),
    });
}

/// Draws the choice in the toolbar.
pub(super) fn combo_ui(opening: &mut Opening, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let name = state.look.display.transform.name();
    let combo = ComboBox::from_id_salt("transform").width(64.0).truncate().selected_text(&name);
    let response = combo.show_ui(ui, |ui| choices_ui(opening, ui, state, actions)).response;
    response.widget_info(|| WidgetInfo::labeled(WidgetType::ComboBox, true, format!("Transform {name}")));
    response.on_hover_text(HELP);
}

/// Draws what can be chosen.
pub(super) fn choices_ui(opening: &mut Opening, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let display = &state.look.display;
    ui.weak("For viewing only");
    for (transform, name) in [(Transform::Srgb, "sRGB"), (Transform::Bt1886, "Rec.709 (BT.1886)")] {
        if ui.selectable_label(display.transform == transform, name).on_hover_text(HELP).clicked() {
            actions.push(Action::Display(Display { transform, ..display.clone() }));
            ui.close();
        }
    }
    if let Transform::Cube(file) = &display.transform {
        let _ = ui.selectable_label(true, display.transform.name()).on_hover_text(file.path.display().to_string());
        for (takes, name) in [(Takes::Light, "It takes light"), (Takes::Encoded, "It takes sRGB values")] {
            if ui.radio(file.takes == takes, name).clicked() && file.takes != takes {
                choose(Transform::read(&file.path, takes), &file.path, state, actions);
                ui.close();
            }
        }
    }
    if ui.button("Cube file …").on_hover_text("A table of a grading program, or of ociobakelut").clicked() {
        opening.ask(state);
        ui.close();
    }
}

impl super::Viewer {
    /// Draws the choice in a menu.
    pub(crate) fn transform_menu(&mut self, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
        ui.menu_button("Transform", |ui| choices_ui(&mut self.opening, ui, state, actions));
    }
}

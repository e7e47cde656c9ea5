//! The palette panel: all colors of the document, how much of the picture each is, and changes to them.

mod chosen;
mod compare;
mod files;
mod list;

use crate::actions::{Action, Grant, OtherPalette, Tint};
use crate::document::palette;
use crate::document::swatches::{self, Swatch};
use crate::picker::Picked;
use crate::state::State;
use egui::{ComboBox, Panel, RichText, ScrollArea, Ui};
use files::Dialog;
use list::Sort;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid::Means;

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Palette {
    sort: Sort,
    dialog: Option<Dialog>,
    /// Folder of the last file that was chosen.
    folder: Option<PathBuf>,
    /// Palettes to compare with the document's.
    others: Vec<Arc<OtherPalette>>,
}

impl Palette {
    /// Returns a panel that compares palettes.
    #[cfg(all(test, feature = "snapshots"))]
    pub(crate) fn comparing(others: Vec<Arc<OtherPalette>>) -> Self {
        Self { others, ..Self::default() }
    }

    /// Clears everything that belongs to the document being left.
    pub(crate) fn forget(&mut self) {
        (self.dialog, self.folder) = (None, None);
        self.others.clear();
    }
}

/// Draws the panel.
pub(crate) fn palette_ui(panel: &mut Palette, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    actions.push(Action::Weigh);
    files::dialog_ui(panel, ui, state, actions);
    if !state.session.meaning().readable {
        ui.disable();
        if state.sheet().value.is_null() {
            return;
        }
    }
    let all = state.swatches();
    tools_ui(panel, ui, state, &all, actions);
    file_ui(ui, state, actions);
    told_ui(ui, state, &all);
    compare::compare_ui(panel, ui, state, actions);
    ui.separator();
    let chosen = state.colors.chosen.as_ref().and_then(|key| all.iter().find(|swatch| swatch.key == *key));
    if let Some(swatch) = chosen {
        let below = Panel::bottom("chosen color").resizable(false).frame(egui::Frame::NONE);
        below.show(ui, |ui| {
            ui.add_space(4.0);
            chosen::chosen_ui(ui, state, swatch, &all, actions);
        });
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        list::list_ui(ui, state, &all, panel.sort, actions);
    });
}

/// Draws the buttons above the list.
fn tools_ui(panel: &mut Palette, ui: &mut Ui, state: &State, all: &[Swatch], actions: &mut Vec<Action>) {
    let is_filed = swatches::file(state.sheet()).is_some();
    ui.horizontal_wrapped(|ui| {
        let sorted = ComboBox::from_id_salt("sort").selected_text(panel.sort.name()).width(88.0);
        sorted
            .show_ui(ui, |ui| {
                for sort in Sort::ALL {
                    ui.selectable_value(&mut panel.sort, sort, sort.name());
                }
            })
            .response
            .on_hover_text("Order of the colors");
        ui.add_enabled_ui(!is_filed, |ui| {
            ui.menu_button("Add", |ui| {
                if ui.button("A gray").on_hover_text("Add a color to change").clicked() {
                    actions.push(Action::AddColor);
                }
                let pick = ui.button("From a picture …");
                let help = "Add the next color clicked in the picture, or in the reference painting of Properties";
                if pick.on_hover_text(help).clicked() {
                    let (_, name) = palette::added(state.sheet(), [0.5; 3], all);
                    actions.push(Action::Dropper(Some(swatches::entry(&name))));
                }
            });
        });
        ui.menu_button("More", |ui| {
            let name = ui.add_enabled(!is_filed, egui::Button::new("Name all colors"));
            if name.on_hover_text("Give every color without a name one, after the place that uses it").clicked() {
                actions.push(Action::NameColors);
            }
            files::menu_ui(panel, ui, state, actions);
        });
    });
}

/// Says that the palette is in a file, or that the file may not be read, with what can be done.
fn file_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let Some(file) = swatches::file(state.sheet()) else { return };
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("The named colors are in {file}."));
        let bring = ui.button("Bring into document");
        if bring.on_hover_text("Write them into the document, to change them here; the file stays as it is").clicked() {
            actions.push(Action::BringPalette);
        }
    });
    let refused = state.session.meaning().errors().filter_map(|fault| match &fault.means {
        Some(Means::Allow(outside)) if fault.port.as_deref() == Some("palette") => Some(outside),
        _ => None,
    });
    for outside in refused.flatten() {
        let grant = Grant::Read(outside.folder().to_path_buf());
        let button = ui.add(egui::Button::new(format!("Allow {grant}")).wrap());
        if button.on_hover_text("The document may then read in this folder and all folders below").clicked() {
            actions.push(Action::Allow(grant));
        }
    }
}

/// Says how many colors there are, and what is known of their shares.
fn told_ui(ui: &mut Ui, state: &State, all: &[Swatch]) {
    let named = palette::names(all).count();
    let text = match all.len() - named {
        0 => format!("{} with names", crate::document::edit::count(named, "color")),
        rest => format!("{} with names, {rest} without", crate::document::edit::count(named, "color")),
    };
    let seen = &state.evaluated;
    // One line whatever it says, so that no color moves under the pointer.
    ui.horizontal(|ui| {
        ui.set_height(ui.spacing().interact_size.y);
        ui.weak(text);
        if let Some(share) = seen.mixing {
            ui.add(egui::Spinner::new().size(12.0));
            let share = if share > 0.0 { format!(", {:.0} %", 100.0 * share) } else { String::new() };
            let weighing = RichText::new(format!("weighing the picture{share}")).weak();
            ui.add(egui::Label::new(weighing).truncate()).on_hover_text(
                "Once the picture's weights are known, it follows a dragged color at once; until then it is evaluated",
            );
        } else if let Some(why) = &seen.unmixed {
            let text = RichText::new("no shares").color(ui.visuals().warn_fg_color);
            ui.add(egui::Label::new(text).truncate()).on_hover_text(why);
        }
    });
}

/// Requests what a gesture made of a color.
fn recolor(picked: Picked, state: &State, swatch: &Swatch, actions: &mut Vec<Action>) {
    let edit = |color| palette::colored(state.sheet(), swatch, color, state.frame);
    let refused = |why| Action::Notice(format!("Changes need {why}"));
    match picked {
        Picked::Cancelled => actions.push(Action::Tint(None)),
        Picked::Moved(color, gesture) => match edit(color) {
            Ok(edit) => gesture.tint(Tint { controls: swatch.controls(), color, edit }, actions),
            Err(why) => actions.push(refused(why)),
        },
        Picked::Settled(color, gesture) => match edit(color) {
            Ok(edit) => gesture.settle(edit, actions),
            Err(why) => actions.push(refused(why)),
        },
    }
}

//! The properties panel: knobs and connections of the selected node, generated from its declaration.

mod color;
mod context;
mod document_knobs;
mod file;
mod follow;
mod group;
mod key;
mod knob;
mod link;
mod notes;
mod output;
mod port;
mod ramp;
mod record;
mod several;
mod surface;

use crate::actions::Action;
use crate::document::{Edit, Path, edit};
use crate::faults;
use crate::field::{self, Gesture, Number};
use crate::prose::{prose, prose_ui};
use crate::state::State;
pub(crate) use context::Properties;
use context::WidgetContext;
use egui::{RichText, ScrollArea, Ui};
use serde_json::Value;
use trochoid::Role;

/// Draws the properties of the selected node or output, or of the document if nothing is selected.
pub(crate) fn properties_ui(panel: &mut Properties, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    panel.pass(ui);
    color::reference_ui(panel, ui, state, actions);
    file::dialog_ui(panel, ui.ctx(), state, actions);
    if !state.session.meaning().readable {
        // Only the text can be edited.
        ui.disable();
        if state.sheet().value.is_null() {
            return;
        }
    }
    // Faults come and go during work: they are shown at the bottom, and the area above reserves their height, so that
    // no knob moves when they appear.
    let height = FAULTS.min(0.4 * ui.available_height());
    let faulty = state.chosen().filter(|name| is_faulty(state, name));
    if let Some(name) = faulty {
        let room = egui::Panel::bottom("faults").resizable(false).exact_size(height).show_separator_line(false);
        room.frame(egui::Frame::NONE).show(ui, |ui| {
            ui.separator();
            ScrollArea::vertical().id_salt(name).auto_shrink(false).show(ui, |ui| faults_ui(ui, state, name, actions));
        });
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        match state.chosen() {
            Some(name) => node_ui(panel, ui, state, name, actions),
            None if state.selection.is_empty() => match &state.output {
                Some(name) => output::output_ui(panel, ui, state, name, actions),
                None => match &state.sheet().within {
                    Some(within) => group::group_ui(panel, ui, state, within, actions),
                    None => document_ui(panel, ui, state, actions),
                },
            },
            None => several::several_ui(panel, ui, state, actions),
        }
        if state.chosen().is_some() && faulty.is_none() {
            ui.add_space(height - ui.spacing().item_spacing.y);
        }
    });
}

/// Returns whether there is a fault in a node or above it.
fn is_faulty(state: &State, name: &str) -> bool {
    let faults = &state.session.meaning().diagnostics;
    let above = || state.sheet().find(name).and_then(|node| state.fault_of(node));
    faults.iter().any(|fault| state.is_of(fault, name)) || above().is_some()
}

/// Height of the fault area, in points.
const FAULTS: f32 = 72.0;

/// Draws the faults of a node, and one above it.
fn faults_ui(ui: &mut Ui, state: &State, name: &str, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    for fault in state.session.meaning().diagnostics.iter().filter(|fault| state.is_of(fault, name)) {
        let told = ui.label(RichText::new(faults::told(fault)).color(faults::color(ui.visuals(), fault)));
        if faults::is_note(fault) {
            told.on_hover_text(&fault.remedy);
        } else if !fault.remedy.is_empty() {
            ui.label(RichText::new(&fault.remedy).italics());
        }
    }
    let above = sheet.find(name).and_then(|node| state.fault_of(node)).filter(|(culprit, _)| *culprit != name);
    if let Some((culprit, fault)) = above {
        let text = format!("Error above, in {culprit}: {}", faults::told(fault));
        let link = ui.link(RichText::new(text).color(crate::theme::error(ui.visuals())));
        if link.on_hover_text("Go to that node").clicked() {
            actions.push(Action::Visit(state.whole_name(culprit)));
        }
    }
}

fn node_ui(panel: &mut Properties, ui: &mut Ui, state: &State, name: &str, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let Some(node) = sheet.node(name) else { return };
    if let Some(side) = node.side {
        return group::side_ui(ui, state, node, side, actions);
    }
    ui.horizontal_wrapped(|ui| {
        let read = |typed: &str| wrong_name(typed.trim(), sheet).map_or_else(|| Ok(typed.trim().to_string()), Err);
        let named = field::draft_ui(ui, "name", name, read, |text| {
            egui::TextEdit::singleline(text).desired_width(150.0).font(egui::TextStyle::Heading)
        });
        named.response.on_hover_text("Name of the node; references to it are updated when it changes");
        if let Some((typed, gesture)) = named.given {
            gesture.edit(edit::renamed(sheet, name, &typed), actions);
        }
        ui.label(RichText::new(&node.ty).strong());
        if node.is_use && ui.button("Enter").on_hover_text("Show the inside of the group (Enter)").clicked() {
            actions.push(Action::Enter(state.scope.iter().cloned().chain([name.to_string()]).collect()));
        }
        let mut off = field::switch_ui(ui, node.disabled, "Disable");
        off.response = off.response.on_hover_text("Let the input of the node pass through unchanged (D)");
        off.edit(actions, |_| edit::disabled(sheet, &[name.into()]));
    });
    let Some(declaration) = node.declaration else {
        ui.label("Unknown node type. The node stays in the document unchanged.");
        return;
    };
    let summary = prose(ui, declaration.summary, &egui::TextStyle::Body, true);
    ui.add(egui::Label::new(summary).wrap()).on_hover_ui(|ui| {
        ui.set_max_width(420.0);
        prose_ui(ui, declaration.formula);
        prose_ui(ui, declaration.edge_cases);
        ui.weak(declaration.source);
    });
    ui.separator();
    let path = Path::node(name);
    panel.linking.take_if(|linking| !linking.path.0.starts_with(&path.0));
    let body = sheet.get(&path);
    // The field keeps the focus whatever widgets come and go above it.
    let own = egui::UiBuilder::new().id(ui.id().with(("knobs", name)));
    let is_foreign = sheet.within.as_ref().is_some_and(|within| within.file.is_some());
    ui.scope_builder(own, |ui| {
        if is_foreign {
            // The group belongs to another file.
            ui.disable();
        }
        if ramp::is_ramp(declaration.items) {
            ramp::ramp_ui(ui, state, &path, actions);
        }
        if node.is(Role::Patch) {
            surface::patch_ui(ui, state, &path, actions);
        }
        match node.is_use {
            true => group::use_ui(panel, ui, state, node, actions),
            false => record::items_ui(panel, ui, state, declaration.items, &path, body, actions),
        }
        ui.separator();
        notes::notes_ui(panel, ui, state, &path, actions);
    });
}

/// Returns what is expected instead of an invalid node name; `None` if the name is valid.
#[derive(Debug, thiserror::Error)]
enum WrongName {
    #[error("a name of a–z, A–Z, 0–9 and _ that does not start with a digit")]
    Illegal,
    #[error("another name: a node with this name already exists")]
    Taken,
}

fn wrong_name(name: &str, sheet: &crate::document::Sheet) -> Option<WrongName> {
    let legal = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !legal {
        return Some(WrongName::Illegal);
    }
    sheet.find(name).map(|_| WrongName::Taken)
}

/// Draws the properties of the document: format, frames, and working space.
fn document_ui(panel: &mut Properties, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    ui.label(RichText::new("Document").heading());
    ui.weak("Select a node to see its knobs.");
    ui.separator();
    let narrow = ui.available_width() < 280.0;
    let number = |ui: &mut Ui, label: &str, path: Path, number: Number<'_>, actions: &mut Vec<Action>| {
        ui.label(label);
        let place = WidgetContext::new(state, path, None);
        number.ui(ui).edit(actions, |number| place.set(&number.into()));
        if narrow {
            ui.end_row();
        }
    };
    let next_row = |ui: &mut Ui| {
        if !narrow {
            ui.end_row();
        }
    };
    let format = Path::default().to("format");
    egui::Grid::new("document").num_columns(if narrow { 2 } else { 4 }).show(ui, |ui| {
        let whole = |value: f64, min: f64, max: f64| Number::new(value).whole().range(min, max);
        let [width, height] = sheet.format.map(|side| whole(f64::from(side), 1.0, 65_536.0));
        number(ui, "Width", format.to("width"), width, actions);
        number(ui, "Height", format.to("height"), height, actions);
        next_row(ui);
        let frames = Path::default().to("frames");
        let [first, last] = [sheet.frames.0 as f64, sheet.frames.1 as f64];
        number(ui, "First frame", frames.to("first"), whole(first, -1e7, last), actions);
        number(ui, "Last frame", frames.to("last"), whole(last, first, 1e7), actions);
        next_row(ui);
        number(ui, "Frames per second", frames.to("fps"), Number::rate(sheet.frames.2), actions);
        next_row(ui);
    });
    // The label stands before the field, as everywhere.
    let choice = |ui: &mut Ui, label: &str, path: Path, shown: &str, values: &[Value], actions: &mut Vec<Action>| {
        let named = ui.label(label);
        let width = ui.available_width().clamp(48.0, 100.0);
        let combo = egui::ComboBox::from_id_salt(label).width(width).selected_text(shown);
        let combo = combo.show_ui(ui, |ui| {
            for value in values {
                let text = value.as_str().map_or_else(|| value.to_string(), String::from);
                if let Some(gesture) = Gesture::click(&ui.selectable_label(text == shown, &text)) {
                    // A document says nothing where something is off.
                    let edit = if value == "off" { Edit::reset(path.clone()) } else { Edit::set(path.clone(), value) };
                    gesture.edit(edit, actions);
                }
            }
        });
        combo.response.labelled_by(named.id);
        ui.end_row();
    };
    egui::Grid::new("choices").num_columns(2).show(ui, |ui| {
        let word = |path: &Path, default: &str| sheet.get(path).and_then(Value::as_str).unwrap_or(default).to_string();
        let (space, shading) = (Path::default().to("working_space"), format.to("shading"));
        let spaces = trochoid::WorkingSpace::ALL.map(|space| Value::from(space.name()));
        choice(ui, "Working space", space.clone(), &word(&space, "linear-srgb"), &spaces, actions);
        let shadings = trochoid::Shading::ALL.map(|shading| Value::from(shading.name()));
        choice(ui, "Shading", shading.clone(), &word(&shading, "sample"), &shadings, actions);
        let samples = sheet.get(&format.to("samples")).and_then(Value::as_u64).unwrap_or(1);
        let counts = [1, 4, 16].map(Value::from);
        choice(ui, "Samples per pixel", format.to("samples"), &samples.to_string(), &counts, actions);
        let adaptive = sheet.get(&format.to("adaptive")).and_then(Value::as_f64);
        let shown = adaptive.map_or_else(|| "off".into(), |tolerance| tolerance.to_string());
        let tolerances = ["off".into(), 0.008.into(), 0.016.into(), 0.03.into()];
        choice(ui, "Adaptive sampling", format.to("adaptive"), &shown, &tolerances, actions);
    });
    ui.separator();
    document_knobs::knobs_ui(panel, ui, state, actions);
    ui.separator();
    output::outputs_ui(ui, state, actions);
    ui.separator();
    notes::notes_ui(panel, ui, state, &Path::default(), actions);
}

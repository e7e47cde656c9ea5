//! Knobs of the document.

use super::context::{Properties, WidgetContext};
use super::{group as group_ui, knob};
use crate::actions::Action;
use crate::document::group::{self, NoGroup};
use crate::document::{Path, Sheet};
use crate::field::{self, Gesture, Number};
use crate::state::State;
use egui::{Popup, PopupCloseBehavior, RichText, TextEdit, Ui, WidgetInfo, WidgetType};
use serde_json::Value;
use trochoid::{Item, Knob, KnobType};

/// Draws the knobs of the document, each with a menu to rename, describe and delete it.
pub(super) fn knobs_ui(panel: &mut Properties, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Knobs of the document").strong());
        let add = ui.button("Add knob").on_hover_text("Add a knob that others can follow, by = knobs.NAME");
        if let Some(gesture) = Gesture::click(&add) {
            gesture.edit(group::added_knob(sheet).0, actions);
            actions.push(Action::Seal);
        }
    });
    let revision = state.session.revision();
    let items = match panel.document_knobs {
        Some((known, items)) if known == revision => items,
        _ => {
            let items = group::kept_items(group::document_knobs(sheet));
            panel.document_knobs = Some((revision, items));
            items
        }
    };
    for item in items {
        let Item::Knob(declared) = item else { continue };
        let Some((path, value)) = group::document_value(sheet, declared.name) else { continue };
        let place = WidgetContext::new(state, path, Some(value));
        ui.push_id(declared.name, |ui| {
            ui.horizontal_top(|ui| {
                menu_ui(ui, sheet, declared, actions);
                ui.vertical(|ui| match group_ui::is_plain(value) {
                    true => knob::knob_ui(panel, ui, declared, &place, actions),
                    false => group_ui::written_ui(ui, declared, value, &place, actions),
                });
            });
        });
    }
    if items.is_empty() {
        ui.weak("None so far. Right-click a knob of a node to make it one of the document.");
    }
}

/// Draws the button that opens the menu of a knob.
fn menu_ui(ui: &mut Ui, sheet: &Sheet, declared: &Knob, actions: &mut Vec<Action>) {
    let name = declared.name;
    let button = ui.small_button("…").on_hover_text("Rename, describe or delete this knob");
    button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Menu of {name}")));
    let popup = Popup::from_toggle_button_response(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    popup.width(240.0).show(|ui| {
        egui::Grid::new("described").num_columns(2).show(ui, |ui| {
            ui.label("Name");
            let is_taken = |new: &str| sheet.get(&group::document_knob(new)).is_some();
            let read = |typed: &str| group_ui::name_of(typed, is_taken);
            let named = field::draft_ui(ui, "name", name, read, |text| TextEdit::singleline(text).desired_width(150.0));
            let label = format!("Name of the knob {name}");
            named.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, &label));
            if let Some((new, gesture)) = named.given {
                gesture.edit(group::renamed_document_knob(sheet, name, &new), actions);
                actions.push(Action::Seal);
                ui.close();
            }
            ui.end_row();
            for key in ["help", "unit"] {
                text_ui(ui, sheet, name, key, actions);
            }
            if matches!(declared.takes, KnobType::Number { .. } | KnobType::Integer { .. }) {
                for key in ["min", "max"] {
                    end_ui(ui, sheet, name, key, actions);
                }
            }
        });
        ui.separator();
        let deleted: Result<_, NoGroup> = group::deleted_knob(sheet, name);
        let delete = ui.add_enabled(deleted.is_ok(), egui::Button::new("Delete"));
        match deleted {
            Ok(edit) => {
                if let Some(gesture) = Gesture::click(&delete) {
                    gesture.edit(edit, actions);
                    actions.push(Action::Seal);
                    ui.close();
                }
            }
            // Who follows it must be known to remove the links.
            Err(why) => drop(ui.add(egui::Label::new(RichText::new(sentence(&why)).weak().small()).wrap())),
        }
    });
}

fn sentence(why: &NoGroup) -> String {
    let text = why.to_string();
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Draws the field of the unit or the help of a knob.
fn text_ui(ui: &mut Ui, sheet: &Sheet, name: &str, key: &str, actions: &mut Vec<Action>) {
    ui.label(if key == "unit" { "Unit" } else { "Help" });
    let text = said(sheet, name, key).and_then(Value::as_str).unwrap_or_default();
    let told = field::text_ui(ui, text, |text| TextEdit::singleline(text).desired_width(150.0));
    told.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, format!("{key} of the knob {name}")));
    told.edit(actions, |text| {
        let text = Some(Value::from(text)).filter(|text| text != "");
        group::described(sheet, name, key, text.as_ref())
    });
    ui.end_row();
}

/// Draws an end of the range of a knob.
fn end_ui(ui: &mut Ui, sheet: &Sheet, name: &str, key: &str, actions: &mut Vec<Action>) {
    ui.label(if key == "min" { "Smallest" } else { "Largest" });
    ui.horizontal(|ui| {
        let set = said(sheet, name, key).and_then(Value::as_f64);
        match set {
            Some(end) => {
                let told = Number::new(end).ui(ui);
                let label = format!("{key} of the knob {name}");
                told.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, &label));
                told.edit(actions, |end| group::described(sheet, name, key, Some(&Value::from(end))));
                if let Some(gesture) = Gesture::click(&ui.small_button("×").on_hover_text("Remove this end")) {
                    gesture.edit(group::described(sheet, name, key, None), actions);
                    actions.push(Action::Seal);
                }
            }
            None => {
                let add = ui.small_button("Limit").on_hover_text("Set this end of the range");
                if let Some(gesture) = Gesture::click(&add) {
                    let value = group::document_value(sheet, name).and_then(|(_, value)| value.as_f64()).unwrap_or(0.0);
                    gesture.edit(group::described(sheet, name, key, Some(&Value::from(value))), actions);
                    actions.push(Action::Seal);
                }
            }
        }
    });
    ui.end_row();
}

/// Returns what is said about a knob beside its value.
fn said<'s>(sheet: &'s Sheet, name: &str, key: &str) -> Option<&'s Value> {
    let path: Path = group::document_knob(name);
    sheet.get(&path)?.get("value").and(sheet.get(&path.to(key)))
}

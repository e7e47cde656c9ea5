//! A list of records, such as a ramp's stops or the waves of a sea.

use super::{Place, Properties, items_ui};
use crate::actions::Action;
use crate::document::{Edit, Op, edit};
use crate::field::Gesture;
use egui::{CollapsingHeader, RichText, Ui};
use serde_json::Value;
use trochoid::List;

/// Draws a list: its records, each to be opened, removed and duplicated.
pub(super) fn list_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    list: &'static List,
    place: &Place<'_>,
    actions: &mut Vec<Action>,
) {
    let records = place.value.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let title = format!("{} ({})", list.name.replace('_', " "), records.len());
    let header = CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(place.path.to_string())
        .default_open(records.len() <= 6);
    let shown = header.show(ui, |ui| {
        for (index, record) in records.iter().enumerate() {
            let path = place.path.to(index);
            ui.push_id(index, |ui| {
                ui.horizontal_wrapped(|ui| {
                    ui.weak(format!("{}[{index}]", list.name.replace('_', " ")));
                    if let Some(gesture) = Gesture::click(&ui.small_button("Duplicate")) {
                        let op = Op::Insert(path.clone(), edit::style(record));
                        gesture.edit(Edit::new(format!("Duplicate {}", list.name), vec![op]), actions);
                    }
                    let removable = records.len() > list.min;
                    let remove = ui.add_enabled(removable, egui::Button::new("Remove").small());
                    if let Some(gesture) = Gesture::click(&remove) {
                        let ops = vec![Op::Remove(path.clone())];
                        gesture.edit(Edit::new(format!("Remove from {}", list.name), ops), actions);
                    }
                });
                ui.indent("record", |ui| {
                    items_ui(panel, ui, place.state, (list.items, &path, Some(record)), actions);
                });
            });
        }
        if records.len() < list.max
            && let Some(gesture) = Gesture::click(&ui.button("Add"))
        {
            let value = edit::style(&edit::record(list.items, records.len()));
            let op = Op::Set(place.path.to(records.len()), value);
            gesture.edit(Edit::new(format!("Add to {}", list.name), vec![op]), actions);
        }
    });
    crate::prose::explained(shown.header_response, list.help);
}

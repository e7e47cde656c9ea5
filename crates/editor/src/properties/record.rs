//! Widgets for the items of a node, including the records of its lists, such as the stops of a ramp or the waves of a
//! sea.

use super::context::{Properties, WidgetContext};
use super::{knob, port};
use crate::actions::Action;
use crate::document::{Edit, Op, Path, change, edit};
use crate::field::Gesture;
use crate::state::State;
use egui::{CollapsingHeader, RichText, Ui};
use serde_json::Value;
use trochoid::{Item, List};

/// Draws a list; each record can be opened, removed, and duplicated.
pub(super) fn list_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    list: &'static List,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let records = place.value.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let title = format!("{} ({})", list.name.replace('_', " "), records.len());
    let header = CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(place.path.to_string())
        .default_open(records.len() <= 6)
        .open(panel.opens(ui, &place.path));
    let shown = header.show(ui, |ui| {
        for (index, record) in records.iter().enumerate() {
            let path = place.path.to(index);
            ui.push_id(index, |ui| {
                ui.horizontal_wrapped(|ui| {
                    ui.weak(format!("{}[{index}]", list.name.replace('_', " ")));
                    if let Some(gesture) = Gesture::click(&ui.small_button("Duplicate")) {
                        let op = Op::Insert(path.clone(), change::style(record));
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
                    items_ui(panel, ui, place.state, list.items, &path, Some(record), actions);
                });
            });
        }
        if records.len() < list.max
            && let Some(gesture) = Gesture::click(&ui.button("Add"))
        {
            let value = change::style(&edit::record(list.items, records.len()));
            let op = Op::Set(place.path.to(records.len()), value);
            gesture.edit(Edit::new(format!("Add to {}", list.name), vec![op]), actions);
        }
    });
    crate::prose::explained(shown.header_response, list.help);
}

/// Draws the widgets of some items, in the order of their declaration.
pub(super) fn items_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    state: &State,
    items: &'static [Item],
    path: &Path,
    body: Option<&Value>,
    actions: &mut Vec<Action>,
) {
    for item in items {
        let place = WidgetContext::new(state, path.to(item.name()), body.and_then(|body| body.get(item.name())));
        match item {
            Item::Knob(knob) => knob::knob_ui(panel, ui, knob, &place, actions),
            Item::Port(port) => port::port_ui(panel, ui, port, &place, actions),
            Item::List(list) => list_ui(panel, ui, list, &place, actions),
        }
    }
}

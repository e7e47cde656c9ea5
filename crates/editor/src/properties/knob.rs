//! A knob: a widget for what it takes.

use super::{Place, Properties, color, key, label_ui};
use crate::actions::Action;
use crate::document::edit::default_value;
use egui::{ComboBox, DragValue, Response, Slider, TextEdit, Ui};
use serde_json::{Value, json};
use trochoid::{Knob, Takes, expected};

/// Draws a knob, with its keys where it may have some.
pub(super) fn knob_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    knob: &'static Knob,
    place: &Place<'_>,
    actions: &mut Vec<Action>,
) {
    let keyed = place.value.and_then(key::Keyed::read);
    let default = default_value(knob);
    let at = |frame: f64| match &keyed {
        Some(keyed) => keyed.at(frame),
        None => place.value.cloned().unwrap_or_else(|| default.clone()),
    };
    let shown = at(place.state.frame as f64);
    ui.horizontal_wrapped(|ui| {
        let label = label_ui(ui, knob.name, &help(knob, &default), place.value.is_some());
        label.context_menu(|ui| menu_ui(ui, knob, place, &shown, actions));
        let unset = place.value.is_none() && matches!(knob.default, Some(trochoid::KnobDefault::Unset));
        let (field, (value, before), frame) = key::typed_ui(ui, place, |ui, frame| {
            let before = at(frame);
            let mut value = before.clone();
            (widget_ui(ui, knob, &mut value, unset, place, actions), (value, before))
        });
        if field.changed() || value != before {
            match &keyed {
                Some(keyed) => place.set(&keyed.with(frame, &value).write(), actions),
                None => place.set(&value, actions),
            }
        }
        if field.drag_stopped() || field.lost_focus() {
            actions.push(Action::Seal);
        }
        if knob.animated {
            key::button_ui(panel, ui, keyed.as_ref(), &shown, place, actions);
        }
    });
    if let Some(keyed) = keyed.filter(|_| panel.curves.contains(&place.path)) {
        key::curve_ui(ui, &keyed, knob.unit, place, actions);
    }
}

/// What is to be known of a knob: meaning, range, unit, default.
fn help(knob: &Knob, default: &Value) -> String {
    let unit = if knob.unit.is_empty() { String::new() } else { format!(", in {}", knob.unit) };
    let default = match knob.default {
        None => "required".into(),
        Some(trochoid::KnobDefault::Unset) => "unset by default".into(),
        Some(_) => format!("{} by default", crate::document::edit::style(default)),
    };
    format!("{}\n\n{}{unit}; {default}.", knob.help, expected(&knob.takes))
}

fn menu_ui(ui: &mut Ui, knob: &'static Knob, place: &Place<'_>, shown: &Value, actions: &mut Vec<Action>) {
    let has_default = knob.default.is_some();
    if ui.add_enabled(has_default && place.value.is_some(), egui::Button::new("Reset to default")).clicked() {
        place.reset(actions);
        ui.close();
    }
    if ui.button("Copy value").clicked() {
        ui.ctx().copy_text(crate::document::edit::style(shown));
        ui.close();
    }
}

/// The widget of what a knob takes.
fn widget_ui(
    ui: &mut Ui,
    knob: &Knob,
    value: &mut Value,
    unset: bool,
    place: &Place<'_>,
    actions: &mut Vec<Action>,
) -> Response {
    if unset {
        let button = ui.button("Set").on_hover_text("It has no value: the node finds one itself.");
        if button.clicked() {
            place.set(value, actions);
        }
        return ui.weak("unset") | button;
    }
    let suffix = unit(knob.unit);
    let is_keyed = place.value.is_some_and(Value::is_object);
    match knob.takes {
        Takes::Number { min, max } => number_ui(ui, value, (min, max), &suffix, is_keyed),
        Takes::Integer { min, max } => {
            let mut number = value.as_i64().unwrap_or_default();
            let speed = (number.unsigned_abs() as f64 * 0.01).max(0.1);
            let field = ui.add(
                DragValue::new(&mut number)
                    .range(min..=max)
                    .speed(speed)
                    .suffix(suffix)
                    .update_while_editing(!is_keyed),
            );
            if field.changed() {
                *value = json!(number);
            }
            field
        }
        Takes::Bool => {
            let mut on = value.as_bool().unwrap_or_default();
            let field = ui.checkbox(&mut on, "");
            if field.changed() {
                *value = json!(on);
            }
            field
        }
        Takes::Choice(words) => {
            let chosen = value.as_str().unwrap_or_default().to_string();
            let combo = ComboBox::from_id_salt(place.path.to_string())
                .width((ui.available_size_before_wrap().x - 8.0).clamp(40.0, 100.0))
                .truncate()
                .selected_text(&chosen);
            combo
                .show_ui(ui, |ui| {
                    for word in words {
                        if ui.selectable_label(*word == chosen, *word).clicked() {
                            *value = json!(word);
                        }
                    }
                })
                .response
        }
        Takes::Color => color::color_ui(ui, value, place, actions),
        Takes::Vector(count) => {
            let mut field: Option<Response> = None;
            for index in 0..count {
                let Some(component) = value.get_mut(index) else { break };
                let own = number_ui(ui, component, (f64::NEG_INFINITY, f64::INFINITY), "", is_keyed);
                field = Some(field.map_or(own.clone(), |all| all | own));
            }
            field.unwrap_or_else(|| ui.weak("—"))
        }
        Takes::Text | Takes::Path => {
            let mut text = value.as_str().unwrap_or_default().to_string();
            let field = ui.add(TextEdit::singleline(&mut text).desired_width(180.0));
            if field.changed() {
                *value = json!(text);
            }
            field
        }
        Takes::Numbers { .. } | Takes::Texts { .. } => {
            // As it is written: it becomes the value as soon as it can be read.
            let id = ui.id().with(("list", place.path.to_string()));
            let written = crate::document::edit::style(value);
            let mut text = ui.data_mut(|data| data.get_temp::<String>(id)).unwrap_or_else(|| written.clone());
            let field = ui.add(TextEdit::singleline(&mut text).desired_width(180.0));
            if field.has_focus() {
                ui.data_mut(|data| data.insert_temp(id, text.clone()));
            } else {
                ui.data_mut(|data| data.remove_temp::<String>(id));
            }
            if field.changed()
                && let Ok(read @ Value::Array(_)) = serde_json::from_str::<Value>(&text)
            {
                *value = read;
            }
            field
        }
    }
}

/// A unit as it stands behind a number.
fn unit(unit: &str) -> String {
    match unit {
        "" => String::new(),
        "degrees" => "°".into(),
        "pixels" => " px".into(),
        unit => format!(" {unit}"),
    }
}

/// A number: a slider where its range is one that a hand can cover, else a field to drag. Shift drags finely. What is
/// typed for a key counts when it is entered or left: until then frames may go on.
pub(super) fn number_ui(
    ui: &mut Ui,
    value: &mut Value,
    (min, max): (f64, f64),
    suffix: &str,
    is_keyed: bool,
) -> Response {
    let mut number = value.as_f64().unwrap_or_default();
    // The number and the button for keys stand behind a slider.
    let room = ui.available_size_before_wrap().x - 84.0;
    let spans = min >= -1.0 && max <= 4.0 && max > min;
    let field = if spans && room >= 40.0 {
        ui.spacing_mut().slider_width = room.min(120.0);
        ui.add(Slider::new(&mut number, min..=max).suffix(suffix).max_decimals(4).update_while_editing(!is_keyed))
    } else {
        let speed = if spans { (max - min) / 200.0 } else { (number.abs() * 0.005).max(0.01) };
        let field = DragValue::new(&mut number).range(min..=max).speed(speed).max_decimals(4).suffix(suffix);
        ui.add(field.update_while_editing(!is_keyed))
    };
    if field.changed() {
        *value = json!(rounded(number));
    }
    field
}

/// Without digits that come from dragging alone.
pub(super) fn rounded(number: f64) -> f64 {
    let digits = (5.0 - number.abs().max(1e-3).log10().floor()).clamp(0.0, 9.0);
    let scale = 10f64.powf(digits);
    (number * scale).round() / scale
}

//! Knob fields: a widget for each type of value.

use super::color::NoColor;
use super::context::{Linking, Properties, WidgetContext, label_ui};
use super::{color, file, follow, key, link};
use crate::actions::Action;
use crate::document::curve::Curve;
use crate::document::edit::default_value;
use crate::field::{self, FieldResponse, Gesture, NoNumber, Number};
use crate::format;
use egui::{ComboBox, TextEdit, Ui};
use serde_json::{Value, json};
use trochoid::{Item, Knob, KnobDefault, KnobType, expected};

/// Draws a knob, with its keys if it can be animated.
pub(super) fn knob_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    knob: &'static Knob,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let keyed = place.value.and_then(Curve::read);
    let default = default_value(knob);
    let at = |frame: f64| match &keyed {
        Some(keyed) => keyed.at(frame),
        None => place.value.cloned().unwrap_or_else(|| default.clone()),
    };
    let shown = at(place.state.frame as f64);
    let item = Item::Knob(*knob);
    let row = ui.horizontal_wrapped(|ui| {
        let label = label_ui(ui, knob.name, &help(knob, &default), place.value.is_some());
        label.context_menu(|ui| menu_ui(panel, ui, knob, place, &shown, actions));
        panel.mark(ui, &place.path, &label);
        if place.also.is_empty() {
            crate::follow::source_ui(&label, &place.path, &item);
        }
        if link::of(place.value).is_some() || panel.links(&place.path) {
            let present = link::present(place.state, &place.path);
            link::link_ui(panel, ui, place, present, |typed| typed_value(typed, knob), actions);
            return label;
        }
        let unset = place.value.is_none() && matches!(knob.default, Some(KnobDefault::Unset));
        let (mut told, frame) =
            key::typed_ui(ui, place, |ui, frame| widget_ui(ui, knob, &at(frame), unset, place, actions));
        // Each letter of a text takes effect, but a link only when it is complete.
        if matches!(knob.takes, KnobType::Text | KnobType::Path)
            && let Some((Value::String(typed), _)) = told.given.take_if(|(value, _)| link::of(Some(value)).is_some())
        {
            panel.linking = Some(Linking { path: place.path.clone(), typed: Some(typed) });
        }
        key::tell(told, keyed.as_ref(), frame, place, actions);
        if matches!(knob.takes, KnobType::Path) && !unset {
            file::button_ui(panel, ui, knob.name, place);
        }
        if matches!(knob.default, Some(KnobDefault::Unset))
            && place.value.is_some()
            && let Some(gesture) = Gesture::click(&ui.small_button("×").on_hover_text("Remove this value"))
        {
            place.reset(gesture, actions);
        }
        if knob.animated {
            key::button_ui(panel, ui, keyed.as_ref(), &shown, place, actions);
        }
        label
    });
    follow::target_ui(ui, row.response.rect, &row.inner, &item, place, actions);
    if let Some(keyed) = keyed.filter(|_| panel.curves.contains(&place.path)) {
        key::curve_ui(ui, &keyed, knob.unit, place, actions);
    }
}

/// Returns the tooltip of a knob: help, range, unit, and default.
pub(super) fn help(knob: &Knob, default: &Value) -> String {
    let default = match knob.default {
        None => "required".into(),
        Some(KnobDefault::Unset) => "unset by default".into(),
        Some(_) => format!("{} by default", crate::document::change::style(default)),
    };
    format!("{}\n\n{}; {default}.", knob.help, knob.takes_in_words())
}

/// Draws the entry of a value's menu that makes it a knob of the group that is entered, or of the document.
pub(super) fn promote_ui(ui: &mut Ui, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    let (name, help) = match place.state.sheet().within {
        Some(_) => ("Make it a knob of the group", "Each use of the group can set it then; this value is the default"),
        None => (
            "Make it a knob of the document",
            "It is set in the document's properties then, and other knobs can follow it",
        ),
    };
    if ui.button(name).on_hover_text(help).clicked() {
        actions.push(Action::Promote(place.path.clone()));
        ui.close();
    }
}

fn menu_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    knob: &'static Knob,
    place: &WidgetContext<'_>,
    shown: &Value,
    actions: &mut Vec<Action>,
) {
    let has_default = knob.default.is_some();
    let reset = ui.add_enabled(has_default && place.value.is_some(), egui::Button::new("Reset to default"));
    if let Some(gesture) = Gesture::click(&reset) {
        place.reset(gesture, actions);
        ui.close();
    }
    if knob.animated {
        key::menu_ui(ui, shown, place, actions);
    }
    link::menu_ui(panel, ui, place);
    if place.path.0.first() == Some(&"nodes".into()) {
        promote_ui(ui, place, actions);
    }
    if ui.button("Copy value").clicked() {
        ui.ctx().copy_text(crate::document::change::style(shown));
        ui.close();
    }
}

/// Draws the widget for a knob's type of value. A value of another type is shown as JSON.
fn widget_ui(
    ui: &mut Ui,
    knob: &Knob,
    value: &Value,
    unset: bool,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) -> FieldResponse<Value> {
    if unset {
        let button = ui.button(format!("Add {}", knob.name.replace('_', " ")));
        let button = button.on_hover_text("Not set: the node works without a value or determines one itself");
        let given = Gesture::click(&button).map(|gesture| (value.clone(), gesture));
        return FieldResponse { response: button, given };
    }
    let suffix = format::unit(knob.unit);
    match (&knob.takes, value) {
        (KnobType::Number { min, max }, Value::Number(_)) => number_ui(ui, value, (*min, *max), &suffix),
        (KnobType::Integer { min, max }, Value::Number(number)) => {
            ui.spacing_mut().interact_size.x = NUMBER;
            let number = Number::new(number.as_f64().unwrap_or_default()).whole();
            number.range(*min as f64, *max as f64).suffix(&suffix).value_ui(ui).map(whole)
        }
        (KnobType::Bool, Value::Bool(on)) => field::switch_ui(ui, *on, "").map(Value::from),
        (KnobType::Choice(words), Value::String(chosen)) => choice_ui(ui, words, chosen, place),
        (KnobType::Color, _) => color::color_ui(ui, value, place, actions),
        (KnobType::Vector(count), Value::Array(items)) if items.len() == *count && items.iter().all(is_number) => {
            vector_ui(ui, items, &Item::Knob(*knob), place)
        }
        (KnobType::Text | KnobType::Path, Value::String(text)) => {
            let width = text_width(ui);
            field::text_ui(ui, text, |text| TextEdit::singleline(text).desired_width(width)).map(Value::from)
        }
        (takes, value) => {
            let width = text_width(ui);
            field::value_ui(ui, &place.path.to_string(), value, width, |text| read(text, takes))
        }
    }
}

/// Returns the width of a text field, which leaves room for the key button.
fn text_width(ui: &Ui) -> f32 {
    (ui.available_size_before_wrap().x - 36.0).clamp(180.0, 420.0)
}

/// Error in a typed value: what the knob expects.
#[derive(Debug, thiserror::Error)]
#[error("{}", expected(.0))]
pub(super) struct Unfit<'t>(&'t KnobType);

/// Error in a typed value of a knob or a port: what was expected.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoValue<'t> {
    #[error("{}", .0.expected)]
    Number(NoNumber),
    #[error("{0}")]
    Color(NoColor),
    #[error("{0}")]
    Other(Unfit<'t>),
}

/// Parses typed text as a value of a knob.
fn read<'t>(text: &str, takes: &'t KnobType) -> Result<Value, Unfit<'t>> {
    let wanted = || Unfit(takes);
    if let Some(link) = crate::document::link::written(text) {
        return Ok(link.into());
    }
    match takes {
        KnobType::Text | KnobType::Path | KnobType::Choice(_) => Ok(text.into()),
        _ => {
            let value: Value = serde_json::from_str(text).map_err(|_| wanted())?;
            let fits = match takes {
                KnobType::Numbers { .. } => value.as_array().is_some_and(|items| items.iter().all(is_number)),
                KnobType::Texts { .. } => value.as_array().is_some_and(|items| items.iter().all(Value::is_string)),
                KnobType::Vector(count) => value.as_array().is_some_and(|items| items.len() == *count),
                KnobType::Bool => value.is_boolean(),
                KnobType::Number { .. } | KnobType::Integer { .. } => value.is_number(),
                _ => true,
            };
            fits.then_some(value).ok_or_else(wanted)
        }
    }
}

/// Returns whether a value is a number, or a link to one.
fn is_number(value: &Value) -> bool {
    value.is_number() || link::of(Some(value)).is_some()
}

/// Returns a value with whole numbers in the form documents store.
fn whole(value: Value) -> Value {
    match value.as_f64() {
        Some(number) if number.abs() < 9e15 => json!(number as i64),
        _ => value,
    }
}

/// Parses a value of a knob that is typed as text; numbers may be formulas.
///
/// # Errors
/// It is none; the error is what was expected.
pub(super) fn typed_value<'k>(text: &str, knob: &'k Knob) -> Result<Value, NoValue<'k>> {
    let suffix = format::unit(knob.unit);
    let number = |number: Number<'_>| number.suffix(&suffix).read(text).map_err(NoValue::Number);
    match &knob.takes {
        KnobType::Number { min, max } => number(Number::new(0.0).range(*min, *max)).map(Value::from),
        KnobType::Integer { min, max } => {
            number(Number::new(0.0).whole().range(*min as f64, *max as f64)).map(|number| whole(number.into()))
        }
        KnobType::Color => color::read_color(text).map_err(NoValue::Color),
        takes => read(text, takes).map_err(NoValue::Other),
    }
}

fn choice_ui(ui: &mut Ui, words: &[&str], chosen: &str, place: &WidgetContext<'_>) -> FieldResponse<Value> {
    let mut given = None;
    let combo = ComboBox::from_id_salt(place.path.to_string())
        .width((ui.available_size_before_wrap().x - 8.0).clamp(40.0, 100.0))
        .truncate()
        .selected_text(chosen);
    let response = combo.show_ui(ui, |ui| {
        for word in words {
            let entry = ui.selectable_label(*word == chosen, *word);
            given = given.take().or(Gesture::click(&entry).map(|gesture| (json!(word), gesture)));
        }
    });
    FieldResponse { response: response.response, given }
}

fn vector_ui(ui: &mut Ui, items: &[Value], knob: &Item, place: &WidgetContext<'_>) -> FieldResponse<Value> {
    let mut all: Option<FieldResponse<Value>> = None;
    for (index, item) in items.iter().enumerate() {
        // Each component has its own id, so that widgets that come and go nearby do not disturb typing.
        let own = ui.push_id(("component", index), |ui| match link::of(Some(item)) {
            Some(_) => link::component_ui(ui, &place.path.to(index), item),
            None => Number::new(item.as_f64().unwrap_or_default()).value_ui(ui),
        });
        let own = follow::component_ui(ui, own.inner, knob).map(|component| {
            let mut items = items.to_vec();
            items[index] = component;
            Value::Array(items)
        });
        all = Some(match all {
            Some(all) => {
                FieldResponse { response: field::joined(all.response, own.response), given: all.given.or(own.given) }
            }
            None => own,
        });
    }
    all.unwrap_or_else(|| FieldResponse::nothing(ui.weak("—")))
}

/// Least width of a number that stands alone, in points: as wide as most, so that they form a column.
const NUMBER: f32 = 64.0;

/// Greatest width of a slider, in points.
const SLIDER: f32 = 260.0;

/// Draws a number field: with a slider if the range is small enough, otherwise without. Shift drags finely.
pub(super) fn number_ui(ui: &mut Ui, value: &Value, (min, max): (f64, f64), suffix: &str) -> FieldResponse<Value> {
    let mut number = Number::new(value.as_f64().unwrap_or_default()).range(min, max).suffix(suffix);
    ui.spacing_mut().interact_size.x = NUMBER;
    // The number and the key button follow the slider.
    let room = ui.available_size_before_wrap().x - NUMBER - 44.0;
    let spans = min >= -1.0 && max <= 4.0 && max > min;
    if spans {
        number = number.speed((max - min) / 200.0);
    }
    if spans && room >= 40.0 {
        ui.spacing_mut().slider_width = room.min(SLIDER);
        number = number.slider(min..=max, false);
    }
    number.value_ui(ui)
}

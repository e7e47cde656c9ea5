//! Port fields: the connection, or the constant used in its place.

use super::context::{Properties, WidgetContext, label_ui};
use super::knob::NoValue;
use super::{color, follow, key, knob, link};
use crate::actions::Action;
use crate::document::color::is_color;
use crate::document::curve::Curve;
use crate::document::link::is_link;
use crate::document::{Edit, Path, edit};
use crate::field::{Gesture, Number};
use egui::{Button, RichText, Ui};
use serde_json::{Value, json};
use trochoid::{Arity, Item, Port};

/// Draws a port with all of its connections.
pub(super) fn port_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    port: &'static Port,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let many = matches!(port.arity, Arity::Many { .. });
    if !many {
        return source_ui(panel, ui, port, port.name, place, actions);
    }
    let elements = place.value.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    if elements.is_empty() && !port.accepts.takes_color() {
        // Without a place of its own, nobody would know that there is such a list.
        ui.horizontal_wrapped(|ui| {
            label_ui(ui, port.name, &format!("{}\n\nAccepts a {}.", port.help, port.accepts), false);
            ui.weak(format!("none yet: connect a {}", port.accepts));
        });
    }
    for (index, element) in elements.iter().enumerate() {
        let own = WidgetContext::new(place.state, place.path.to(index), Some(element));
        source_ui(panel, ui, port, &format!("{}[{index}]", port.name), &own, actions);
    }
    let Arity::Many { max, .. } = port.arity else { return };
    if elements.len() < max
        && port.accepts.takes_color()
        && let Some(gesture) = Gesture::click(&ui.small_button(format!("Add to {}", port.name)))
    {
        let value = elements.last().cloned().unwrap_or_else(|| json!("#808080"));
        let ops = vec![crate::document::Op::Set(place.path.to(elements.len()), crate::document::change::style(&value))];
        gesture.edit(Edit::new(format!("Add to {}", port.name), ops), actions);
    }
}

fn source_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    port: &'static Port,
    name: &str,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let sheet = place.state.sheet();
    let connected = place.value.and_then(Value::as_str).filter(|text| !is_color(text));
    let mut curve = None;
    let item = Item::Port(*port);
    let row = ui.horizontal_wrapped(|ui| {
        let label = label_ui(ui, name, &format!("{}\n\nAccepts a {}.", port.help, port.accepts), place.value.is_some());
        label.context_menu(|ui| {
            if let Some(gesture) = Gesture::click(&ui.add_enabled(place.value.is_some(), Button::new("Remove"))) {
                place.reset(gesture, actions);
                ui.close();
            }
            if port.accepts.takes_color() || port.accepts.takes_number() {
                link::menu_ui(panel, ui, place);
            }
            let is_literal = connected.is_none() && place.value.is_some();
            if is_literal {
                knob::promote_ui(ui, place, actions);
            }
        });
        panel.mark(ui, &place.path, &label);
        if connected.is_none_or(is_link) && place.value.is_some() && place.also.is_empty() {
            crate::follow::source_ui(&label, &place.path, &item);
        }
        if link::of(place.value).is_some() || panel.links(&place.path) {
            let present = link::present(place.state, &place.path);
            link::link_ui(panel, ui, place, present, |typed| constant(typed, port), actions);
            return label;
        }
        match (connected, place.value) {
            (Some(text), _) => {
                let known = sheet.source(text);
                let color = match known {
                    Some(_) => crate::theme::ink(crate::theme::accepts(port.accepts), ui.visuals()),
                    None => crate::theme::error(ui.visuals()),
                };
                let link = ui.link(RichText::new(format!("• {text}")).color(color));
                if let Some((node, _)) = known
                    && link.on_hover_text("Select that node").clicked()
                {
                    actions.push(Action::Select([sheet.nodes[node].name.clone()].into()));
                }
                if let Some(gesture) = Gesture::click(&ui.small_button("×").on_hover_text("Disconnect")) {
                    disconnect(gesture, place, actions);
                }
            }
            (None, None) if port.arity != Arity::One && !port.accepts.takes_color() => {
                ui.weak("not connected");
            }
            (None, None) if !port.accepts.takes_color() && !port.accepts.takes_number() => {
                ui.label(RichText::new(format!("needs a {}", port.accepts)).color(crate::theme::error(ui.visuals())));
            }
            (None, value) => {
                let keyed = value.and_then(Curve::read);
                let default = if port.accepts.takes_color() { json!("#808080") } else { json!(0) };
                let at = |frame: f64| match &keyed {
                    Some(keyed) => keyed.at(frame),
                    None => value.cloned().unwrap_or_else(|| default.clone()),
                };
                let shown = at(place.state.frame as f64);
                let (told, frame) = key::typed_ui(ui, place, |ui, frame| {
                    let value = at(frame);
                    if value.is_number() {
                        knob::number_ui(ui, &value, range(port), "")
                    } else {
                        color::color_ui(ui, &value, place, actions)
                    }
                });
                key::tell(told, keyed.as_ref(), frame, place, actions);
                key::button_ui(panel, ui, keyed.as_ref(), &shown, place, actions);
                curve = keyed;
            }
        }
        label
    });
    follow::target_ui(ui, row.response.rect, &row.inner, &item, place, actions);
    if let Some(keyed) = curve.filter(|_| panel.curves.contains(&place.path)) {
        key::curve_ui(ui, &keyed, "", place, actions);
    }
}

/// Returns the range of numbers that a port takes.
fn range(port: &Port) -> (f64, f64) {
    let mask = port.accepts == trochoid::Accepts::Mask || port.accepts.takes_color();
    if mask { (0.0, 1.0) } else { (f64::NEG_INFINITY, f64::INFINITY) }
}

/// Parses a typed constant of a port.
///
/// # Errors
/// It is none; the error is what was expected.
pub(super) fn constant(typed: &str, port: &Port) -> Result<Value, NoValue<'static>> {
    let (min, max) = range(port);
    let number = || Number::new(0.0).range(min, max).read(typed).map(Value::from).map_err(NoValue::Number);
    match port.accepts.takes_color() {
        true => color::read_color(typed).map_err(NoValue::Color).or_else(|why| number().map_err(|_| why)),
        false => number(),
    }
}

/// Disconnects a pin in the same way as the canvas.
fn disconnect(gesture: Gesture, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    let sheet = place.state.sheet();
    let [_, crate::document::Step::Key(name), steps @ ..] = place.path.0.as_slice() else { return };
    let Some(node) = sheet.find(name) else { return };
    match sheet.nodes[node].pin(steps) {
        Some(pin) => gesture.rewire(edit::disconnected(sheet, (node, pin)), actions),
        None => gesture.edit(Edit::reset(Path(place.path.0.clone())), actions),
    }
}

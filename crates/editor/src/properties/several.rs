//! Several selected nodes: the knobs that all of them have, changed together in one step of undo.

use super::context::{Properties, WidgetContext, label_ui};
use super::{knob, link, port};
use crate::actions::Action;
use crate::document::curve::Curve;
use crate::document::edit::{self, default_value};
use crate::document::{Node, Path};
use crate::field::{self, FieldResponse, Gesture};
use crate::state::State;
use egui::{ComboBox, RichText, TextEdit, Ui, WidgetInfo, WidgetType};
use serde_json::{Value, json};
use std::fmt::Display;
use trochoid::{Arity, Item, Knob, KnobDefault, KnobType, Port};

/// Draws what the selected nodes share.
pub(super) fn several_ui(panel: &mut Properties, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    // The boxes of a group's inputs and outputs are no nodes, and have nothing to set.
    let is_node = |name: &&String| sheet.node(name).is_some_and(|node| node.side.is_none());
    let names: Vec<String> = state.selection.iter().filter(is_node).cloned().collect();
    if names.is_empty() {
        ui.label("Boxes of the group's inputs and outputs: select one of them to see what it is.");
        return;
    }
    let nodes: Vec<&Node> = names.iter().filter_map(|name| sheet.node(name)).collect();
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(edit::count(nodes.len(), "node")).heading());
        let off = same(nodes.iter().map(|node| node.disabled));
        let mut told = field::mixed_switch_ui(ui, off, "Disable");
        told.response = told.response.on_hover_text("Let the inputs of these nodes pass through unchanged (D)");
        told.edit(actions, |off| edit::switched(sheet, &names, !off));
    });
    ui.add(egui::Label::new(RichText::new(types(&nodes)).weak()).wrap());
    ui.separator();
    let declared: Option<Vec<&[Item]>> = nodes.iter().map(|node| Some(node.declaration?.items)).collect();
    let Some([first, others @ ..]) = declared.as_deref() else {
        ui.label("Nodes of an unknown type are among them, whose knobs are not known.");
        return;
    };
    let mut count = 0;
    for item in *first {
        let alike: Option<Vec<&Item>> =
            others.iter().map(|items| items.iter().find(|own| is_alike(item, own))).collect();
        let Some(alike) = alike else { continue };
        let places: Vec<Path> = names.iter().map(|name| Path::node(name).to(item.name())).collect();
        let set: Vec<Option<&Value>> = places.iter().map(|path| sheet.get(path)).collect();
        let defaults = std::iter::once(item).chain(alike).map(default_of);
        let shown: Vec<Option<Value>> =
            set.iter().zip(defaults).map(|(set, default)| set.cloned().or(default)).collect();
        if matches!(item, Item::Port(_)) && set.iter().flatten().any(|value| is_connected(value)) {
            continue;
        }
        count += 1;
        let mut place = WidgetContext::new(state, places[0].clone(), set.iter().copied().flatten().next());
        place.also = places[1..].to_vec();
        let is_same = shown.windows(2).all(|pair| is_equal(pair[0].as_ref(), pair[1].as_ref()));
        match item {
            Item::Knob(known) if is_same => knob::knob_ui(panel, ui, known, &place, actions),
            Item::Port(known) if is_same => port::port_ui(panel, ui, known, &place, actions),
            Item::Knob(known) => mixed_knob_ui(ui, known, &place, actions),
            Item::Port(known) => mixed_port_ui(ui, known, &place, actions),
            Item::List(_) => {}
        }
    }
    if count == 0 {
        ui.weak("These nodes have no knob in common.");
    }
}

/// Returns the value that all have.
fn same<T: PartialEq>(mut all: impl Iterator<Item = T>) -> Option<T> {
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// Lists the types of nodes: `2 × Mix, Ramp`.
fn types(nodes: &[&Node]) -> String {
    let mut all: Vec<(&str, usize)> = Vec::new();
    for node in nodes {
        match all.iter_mut().find(|(ty, _)| *ty == node.ty) {
            Some((_, count)) => *count += 1,
            None => all.push((&node.ty, 1)),
        }
    }
    let told = all.into_iter().map(|(ty, count)| if count == 1 { ty.into() } else { format!("{count} × {ty}") });
    told.collect::<Vec<String>>().join(", ")
}

/// Returns whether two items take the same values, by name and kind. What their ranges say is checked by the nodes.
fn is_alike(a: &Item, b: &Item) -> bool {
    match (a, b) {
        (Item::Knob(a), Item::Knob(b)) => a.name == b.name && is_alike_type(&a.takes, &b.takes),
        (Item::Port(a), Item::Port(b)) => {
            let is_constant = a.accepts.takes_color() || a.accepts.takes_number();
            let is_one = !matches!(a.arity, Arity::Many { .. });
            is_constant && is_one && (a.name, a.accepts, a.arity) == (b.name, b.accepts, b.arity)
        }
        _ => false,
    }
}

fn is_alike_type(a: &KnobType, b: &KnobType) -> bool {
    match (a, b) {
        (KnobType::Choice(a), KnobType::Choice(b)) => a == b,
        (KnobType::Vector(a), KnobType::Vector(b)) => a == b,
        (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}

/// Returns the value of an item that is not set.
fn default_of(item: &Item) -> Option<Value> {
    match item {
        Item::Knob(known) if !matches!(known.default, Some(KnobDefault::Unset)) => Some(default_value(known)),
        _ => None,
    }
}

fn is_connected(value: &Value) -> bool {
    value.as_str().is_some_and(|text| !crate::document::color::is_color(text) && link::of(Some(value)).is_none())
}

/// Returns whether values are the same however their numbers are written.
fn is_equal(a: Option<&Value>, b: Option<&Value>) -> bool {
    match (a, b) {
        (Some(Value::Number(a)), Some(Value::Number(b))) => a.as_f64() == b.as_f64(),
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_equal(Some(a), Some(b)))
        }
        (a, b) => a == b,
    }
}

/// Draws a knob that has several values.
fn mixed_knob_ui(ui: &mut Ui, known: &'static Knob, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        label_ui(ui, known.name, &knob::help(known, &default_value(known)), true);
        let told = match &known.takes {
            KnobType::Bool => field::mixed_switch_ui(ui, None, "").map(Value::from),
            KnobType::Choice(words) => mixed_choice_ui(ui, words, place),
            _ => mixed_text_ui(ui, place, |typed| knob::typed_value(typed, known)),
        };
        tell(told, known.name, place, actions);
    });
}

/// Draws a port that has several constants.
fn mixed_port_ui(ui: &mut Ui, known: &'static Port, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        label_ui(ui, known.name, known.help, true);
        let told = mixed_text_ui(ui, place, |typed| match crate::document::link::written(typed) {
            Some(link) => Ok(link.into()),
            None => port::constant(typed, known),
        });
        tell(told, known.name, place, actions);
    });
}

fn mixed_choice_ui(ui: &mut Ui, words: &[&str], place: &WidgetContext<'_>) -> FieldResponse<Value> {
    let mut given = None;
    let combo = ComboBox::from_id_salt(place.path.to_string()).width(100.0).selected_text("mixed");
    let response = combo.show_ui(ui, |ui| {
        for word in words {
            let entry = ui.selectable_label(false, *word);
            given = given.take().or(Gesture::click(&entry).map(|gesture| (json!(word), gesture)));
        }
    });
    FieldResponse { response: response.response, given }
}

/// Draws a field in which the value for all is typed.
fn mixed_text_ui<E: Display>(
    ui: &mut Ui,
    place: &WidgetContext<'_>,
    read: impl FnOnce(&str) -> Result<Value, E>,
) -> FieldResponse<Value> {
    field::draft_ui(
        ui,
        &place.path.to_string(),
        "",
        |typed| read(typed.trim()),
        |text| TextEdit::singleline(text).hint_text("mixed").desired_width(84.0),
    )
}

/// Requests the edit that gives all nodes a value: as a key at the current frame to those that have keys.
fn tell(told: FieldResponse<Value>, name: &str, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    let called = format!("{}, mixed", name.replace('_', " "));
    told.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, called.clone()));
    let (sheet, frame) = (place.state.sheet(), place.state.frame as f64);
    told.edit(actions, |value| {
        place.set_each(|path| match sheet.get(path).and_then(Curve::read) {
            Some(keyed) => keyed.keyed(frame, &value).write(),
            None => value.clone(),
        })
    });
}

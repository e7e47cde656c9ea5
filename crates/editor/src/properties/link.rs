//! Linked values: their formulas, and what they are at the current frame.

use super::color;
use super::context::{Linking, Properties, WidgetContext};
use crate::actions::Action;
use crate::document::change::style;
use crate::document::group::follower;
use crate::document::link::{is_link, written};
use crate::document::{Path, Step, spoken};
use crate::field::{self, FieldResponse, Gesture, Number};
use crate::refusal;
use crate::state::State;
use egui::{Button, Color32, Key, Label, RichText, Sense, TextEdit, TextStyle, Ui, WidgetInfo, WidgetType, vec2};
use serde_json::{Value, json};
use std::fmt::Display;
use trochoid::{CheckedGraph, Item, KnobType, NodeId};

/// Returns the link that a value is.
pub(super) fn of(value: Option<&Value>) -> Option<&str> {
    value.and_then(Value::as_str).filter(|text| is_link(text))
}

/// Draws the field of a link, its present value, and the button that removes it. A value that is no link is typed over it:
/// `read` parses it.
pub(super) fn link_ui<E: Display>(
    panel: &mut Properties,
    ui: &mut Ui,
    place: &WidgetContext<'_>,
    present: Option<Present>,
    read: impl FnOnce(&str) -> Result<Value, E>,
    actions: &mut Vec<Action>,
) {
    let link = of(place.value).unwrap_or_default();
    let read = |typed: &str| written(typed).map_or_else(|| read(typed.trim()), |link| Ok(link.into()));
    let is_new = panel.links(&place.path);
    if let Some(typed) = panel.linking.as_mut().filter(|_| is_new).and_then(|linking| linking.typed.take()) {
        field::begin_draft(ui, &place.path.to_string(), link, typed);
    }
    let width = (ui.available_size_before_wrap().x - 96.0).clamp(80.0, 150.0);
    let told = field::draft_ui(ui, &place.path.to_string(), link, read, |text| {
        TextEdit::singleline(text).hint_text("= node.knob").desired_width(width).font(TextStyle::Monospace)
    });
    let field = told.response.clone();
    field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, format!("Link of {}", spoken(&place.path))));
    if is_new && !link.is_empty() {
        panel.linking = None;
    } else if is_new && !field.has_focus() {
        let is_refused = refusal::stands(ui.ctx(), field.id);
        if field.lost_focus() && told.given.is_none() && !is_refused || ui.input(|input| input.key_pressed(Key::Escape))
        {
            panel.linking = None;
        } else if !field.lost_focus() && !is_refused {
            field.request_focus();
        }
    }
    told.edit(actions, |value| place.set(&value));
    let help = "Follows other knobs by its formula. Type another formula, or a value to end the link.";
    field.on_hover_text(if link.is_empty() { help.into() } else { format!("{link}\n{help}") });
    if link.is_empty() {
        return;
    }
    match &present {
        Some(Present { color: Some(color), .. }) => {
            let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
            let (spot, _) = ui.allocate_exact_size(vec2(18.0, 18.0), Sense::hover());
            ui.painter().rect_filled(spot.shrink(2.0), 2.0, Color32::from_rgb(r, g, b));
        }
        Some(Present { value, .. }) => drop(ui.add(Label::new(RichText::new(short(value)).weak()).truncate())),
        None => {}
    }
    let help = if present.is_some() { "Remove the link, and keep its present value" } else { "Remove the link" };
    let end = ui.small_button("×").on_hover_text(help);
    end.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Unlink {}", spoken(&place.path))));
    if let Some(gesture) = Gesture::click(&end) {
        match present {
            Some(present) => gesture.edit(place.set(&present.value), actions),
            None => place.reset(gesture, actions),
        }
        actions.push(Action::Seal);
    }
}

/// Draws the field of a component that is a link.
pub(super) fn component_ui(ui: &mut Ui, path: &Path, value: &Value) -> FieldResponse<Value> {
    let link = of(Some(value)).unwrap_or_default();
    let read = |typed: &str| match written(typed) {
        Some(link) => Ok(link.into()),
        None => Number::new(0.0).read(typed).map(Value::from).map_err(|why| why.expected),
    };
    let told = field::draft_ui(ui, "link", link, read, |text| {
        TextEdit::singleline(text).desired_width(84.0).font(TextStyle::Monospace)
    });
    let field = told.response.clone().on_hover_text(link);
    field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, format!("Link of {}", spoken(path))));
    told
}

/// Draws the entry of a value's menu that begins a link.
pub(super) fn menu_ui(panel: &mut Properties, ui: &mut Ui, place: &WidgetContext<'_>) {
    let begin = ui.add_enabled(of(place.value).is_none(), Button::new("Link …"));
    if begin.on_hover_text("Follow another knob or a formula: type = node.knob").clicked() {
        panel.linking = Some(Linking { path: place.path.clone(), typed: None });
        ui.close();
    }
}

/// What a link gives at the current frame.
pub(super) struct Present {
    /// The value as a document would have it.
    value: Value,
    /// The color that it is, as sRGB values from 0 to 1.
    color: Option<[f32; 3]>,
}

impl Present {
    fn color(value: [f64; 3], state: &State) -> Self {
        let value = json!(value);
        Self { color: color::display(&value, state), value }
    }
}

/// Returns what a linked knob or port is at the current frame; `None` if the document has errors.
pub(super) fn present(state: &State, path: &Path) -> Option<Present> {
    let graph = state.session.meaning().graph.as_ref()?;
    let [Step::Key(nodes), Step::Key(name), steps @ ..] = path.0.as_slice() else { return None };
    let whole = state.whole_name(name);
    if nodes != "nodes" {
        return None;
    }
    if let Some(node) = graph.find(&whole) {
        return value(state, graph, node, steps);
    }
    // A use of a group is no node of the expanded document: what follows its knob inside has the value.
    let [Step::Key(knob)] = steps else { return None };
    let (inner, place) = follower(state.session.sheet(), &whole, knob)?;
    value(state, graph, graph.find(&inner)?, &place.0)
}

/// Returns the value at a place in a node of the expanded document.
fn value(state: &State, graph: &CheckedGraph, node: NodeId, mut steps: &[Step]) -> Option<Present> {
    let values = graph.node(node).record.settle(state.frame as f64);
    let (mut record, mut items) = (&values, graph.node(node).ty.declaration().items);
    // Lists come before the item, and the index of a connection or component may follow it.
    while let [Step::Key(name), Step::Index(index), rest @ ..] = steps
        && !rest.is_empty()
    {
        let list = items.iter().find_map(|item| match item {
            Item::List(list) if list.name == name => Some(list),
            _ => None,
        })?;
        (record, items, steps) = (record.list(list.name).get(*index)?, list.items, rest);
    }
    let [Step::Key(name), ..] = steps else { return None };
    let item = items.iter().find(|item| item.name() == name)?;
    let name = item.name();
    let value = match item {
        Item::Knob(knob) => match knob.takes {
            KnobType::Number { .. } => json!(record.number(name)),
            KnobType::Integer { .. } => json!(record.integer(name)),
            KnobType::Bool => json!(record.bool(name)),
            KnobType::Choice(_) | KnobType::Text | KnobType::Path => json!(record.text(name)),
            KnobType::Color => return Some(Present::color(record.vector3(name), state)),
            KnobType::Vector(count) => match steps {
                [_, Step::Index(component)] => json!(record.vector3(name).get(*component)?),
                _ => json!(record.vector3(name).get(..count)?),
            },
            KnobType::Numbers { .. } => json!(record.numbers(name)),
            KnobType::Texts { .. } => json!(record.texts(name)),
        },
        Item::Port(_) => {
            let index = if let [.., Step::Index(index)] = steps { *index } else { 0 };
            let source = record.all(name).get(index)?;
            match source.color() {
                Some(color) => return Some(Present::color(color, state)),
                None => json!(source.number()?),
            }
        }
        Item::List(_) => return None,
    };
    Some(Present { value, color: None })
}

/// Writes a value with as many digits as there is room for.
fn short(value: &Value) -> String {
    let number = |value: &Value| value.as_f64().map(|number| format!("{}", field::rounded(number)));
    match value {
        Value::Array(items) => items.iter().map(|item| number(item).unwrap_or_default()).collect::<Vec<_>>().join(", "),
        Value::String(text) => text.clone(),
        value => number(value).unwrap_or_else(|| style(value)),
    }
}

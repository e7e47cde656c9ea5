//! Properties of the group that is entered, and of the boxes of its inputs and outputs.

use super::context::{Properties, WidgetContext, label_ui};
use super::{knob, notes, port};
use crate::actions::Action;
use crate::document::group::{self, NoGroup, Within};
use crate::document::link::is_link;
use crate::document::sheet::Side;
use crate::document::{Edit, Node, Op, Path, edit};
use crate::field::{self, Gesture};
use crate::state::State;
use egui::{ComboBox, RichText, TextEdit, Ui, WidgetInfo, WidgetType};
use serde_json::Value;
use trochoid::{INPUT_ACCEPTS, Item, Knob, input_kind, registry};

/// Why a name cannot be that of a group, of an input, or of a knob.
#[derive(Debug, thiserror::Error)]
pub(super) enum WrongName {
    #[error("a name of a–z, A–Z, 0–9 and _ that does not start with a digit")]
    Illegal,
    #[error("another name: this one is taken")]
    Taken,
}

pub(super) fn name_of(typed: &str, is_taken: impl Fn(&str) -> bool) -> Result<String, WrongName> {
    let name = typed.trim();
    let is_legal = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    match is_legal {
        false => Err(WrongName::Illegal),
        true if is_taken(name) => Err(WrongName::Taken),
        true => Ok(name.into()),
    }
}

/// Draws the group that is entered: its name, and its knobs with their defaults.
pub(super) fn group_ui(panel: &mut Properties, ui: &mut Ui, state: &State, within: &Within, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let Some(known) = sheet.library.group(within.group()) else { return };
    let definition = within.definition();
    let is_own = known.file.is_none();
    ui.add_enabled_ui(is_own, |ui| {
        ui.horizontal_wrapped(|ui| {
            let is_taken = |name: &str| sheet.library.group(name).is_some() || registry().get(name).is_some();
            let read = |typed: &str| name_of(typed, is_taken);
            let named = field::draft_ui(ui, "group", within.group(), read, |text| {
                TextEdit::singleline(text).desired_width(150.0).font(egui::TextStyle::Heading)
            });
            named.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Name of the group"));
            if let Some((typed, gesture)) = named.given {
                gesture.whole(group::renamed_group(state.session.sheet(), within.group(), &typed), actions);
                actions.push(Action::Seal);
            }
            ui.label(RichText::new("Group").strong());
        });
    });
    match &known.file {
        None => ui.weak("Select a node to see its knobs. Right-click a knob to make it one of the group."),
        // Legible, unlike what it explains.
        Some(file) => {
            ui.label(format!("{file} has this group. Make local copies it into this document, to change it."))
        }
    };
    ui.add_enabled_ui(is_own, |ui| {
        ui.separator();
        ui.label(RichText::new("Knobs of the group").strong());
        let items = sheet.library.face(within.group()).map_or(&[][..], |face| face.items);
        for item in items {
            let Item::Knob(declared) = item else { continue };
            let place = definition.to("knobs").to(declared.name);
            // Included files have knobs too.
            let own = known.entries("knobs").find(|(name, _)| *name == declared.name);
            let Some((value, is_described)) = own.map(|(_, knob)| group::whole_default(knob)) else { continue };
            let path = if is_described { place.to("default") } else { place.clone() };
            let place = WidgetContext { state, path, value, also: Vec::new() };
            ui.push_id(declared.name, |ui| match value {
                Some(shown) if !is_plain(shown) => written_ui(ui, declared, shown, &place, actions),
                _ => knob::knob_ui(panel, ui, declared, &place, actions),
            });
        }
        if items.iter().all(|item| !matches!(item, Item::Knob(_))) {
            ui.weak("None so far.");
        }
        ui.separator();
        notes::notes_ui(panel, ui, state, &definition, actions);
    });
}

/// Draws the connections and knobs of a use of a group.
pub(super) fn use_ui(panel: &mut Properties, ui: &mut Ui, state: &State, node: &Node, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let path = Path::node(&node.name);
    let (body, known) = (sheet.get(&path), sheet.library.group(&node.ty));
    let items = node.declaration.map_or(&[][..], |known| known.items);
    for item in items {
        let value = body.and_then(|body| body.get(item.name()));
        let place = WidgetContext { state, path: path.to(item.name()), value, also: Vec::new() };
        match item {
            Item::Port(port) => port::port_ui(panel, ui, port, &place, actions),
            Item::Knob(declared) => {
                let default = known.and_then(|group| group.entries("knobs").find(|(name, _)| *name == declared.name));
                let default = default.and_then(|(_, knob)| group::whole_default(knob).0);
                let is_linked = value.and_then(Value::as_str).is_some_and(is_link);
                match value.or(default) {
                    Some(shown) if !is_linked && !is_plain(shown) => written_ui(ui, declared, shown, &place, actions),
                    _ => knob::knob_ui(panel, ui, declared, &place, actions),
                }
            }
            // Groups have no lists of records.
            Item::List(_) => {}
        }
    }
}

/// Returns whether the widgets of knobs can show a value: it is constant or keyed.
pub(super) fn is_plain(value: &Value) -> bool {
    match value {
        Value::String(text) => !is_link(text),
        Value::Array(items) => items.iter().all(Value::is_number),
        Value::Object(entries) => entries.contains_key("keys"),
        _ => true,
    }
}

/// What is expected of a value that is written as JSON.
#[derive(Debug, thiserror::Error)]
#[error("a value as JSON, or a link such as = NODE.KNOB")]
struct NoValue;

/// Draws a knob whose value is a link, or a list of anything, as it is written.
pub(super) fn written_ui(
    ui: &mut Ui,
    declared: &Knob,
    shown: &Value,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    ui.horizontal_wrapped(|ui| {
        let label = label_ui(ui, declared.name, declared.help, place.value.is_some());
        label.context_menu(|ui| {
            let reset = ui.add_enabled(place.value.is_some(), egui::Button::new("Reset to default"));
            if let Some(gesture) = Gesture::click(&reset) {
                place.reset(gesture, actions);
                ui.close();
            }
        });
        let read = |text: &str| match is_link(text.trim()) {
            true => Ok(Value::from(text.trim())),
            false => serde_json::from_str(text).map_err(|_| NoValue),
        };
        field::value_ui(ui, &place.path.to_string(), shown, 180.0, read).edit(actions, |value| place.set(&value));
    });
}

/// Draws the box of an input or output of the group.
pub(super) fn side_ui(ui: &mut Ui, state: &State, node: &Node, side: Side, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let Some(within) = &sheet.within else { return };
    let (is_own, called) = (within.file.is_none(), node.called());
    ui.add_enabled_ui(is_own, |ui| {
        ui.horizontal_wrapped(|ui| {
            let known = sheet.library.group(within.group());
            let is_taken = |name: &str| match side {
                Side::Input => sheet.find(name).is_some() || known.is_some_and(|group| group.has("knobs", name)),
                Side::Output => known.is_some_and(|group| group.has("outputs", name)),
            };
            let read = |typed: &str| name_of(typed, is_taken);
            let named = field::draft_ui(ui, "name", called, read, |text| {
                TextEdit::singleline(text).desired_width(150.0).font(egui::TextStyle::Heading)
            });
            named.response.on_hover_text("Its name; uses of the group follow when it changes");
            if let Some((typed, gesture)) = named.given
                && let Ok(edit) = renamed(state, within, node, side, &typed)
            {
                gesture.whole(edit, actions);
                actions.push(Action::Seal);
            }
            ui.label(RichText::new(if side == Side::Input { "Input" } else { "Output" }).strong());
        });
    });
    if side == Side::Output {
        ui.label("What uses of the group make under this name.");
        return;
    }
    ui.label("What a use of the group connects here.");
    ui.separator();
    ui.add_enabled_ui(is_own, |ui| {
        let path = Path::node(&node.name);
        let written = sheet.get(&path);
        let kind = written.and_then(|input| input.as_str().or_else(|| input.get("kind")?.as_str())).unwrap_or_default();
        ui.horizontal_wrapped(|ui| {
            label_ui(ui, "kind", "What can be connected.", true);
            ComboBox::from_id_salt("kind of the input").selected_text(kind).show_ui(ui, |ui| {
                for accepts in INPUT_ACCEPTS.map(input_kind) {
                    if let Some(gesture) = Gesture::click(&ui.selectable_label(accepts == kind, &accepts)) {
                        let place = if written.is_some_and(Value::is_object) { path.to("kind") } else { path.clone() };
                        let label = format!("Set the kind of {called}");
                        let text = crate::document::json::quoted(&accepts);
                        gesture.edit(Edit::new(label, vec![Op::Set(place, text)]), actions);
                        actions.push(Action::Seal);
                    }
                }
            });
        });
        let is_optional = written.and_then(|input| input.get("optional")) == Some(&Value::Bool(true));
        let told = field::switch_ui(ui, is_optional, "May stay open");
        told.edit(actions, |on| {
            let text = format!("{{ \"kind\": {}, \"optional\": {on} }}", crate::document::json::quoted(kind));
            let op = match written.is_some_and(Value::is_object) {
                true => Op::Set(path.to("optional"), on.to_string()),
                false => Op::Set(path.clone(), text),
            };
            Edit::new(format!("Set whether {called} may stay open"), vec![op])
        });
    });
}

/// Renames an input or output of the group. Uses of the group elsewhere set an input by its new name, and refer to an output
/// by it.
fn renamed(state: &State, within: &Within, node: &Node, side: Side, name: &str) -> Result<Edit, NoGroup> {
    let (sheet, root, called) = (state.sheet(), state.session.sheet(), node.called());
    let (new, uses) = match side {
        Side::Input => (name.to_string(), group::renamed_input(root, within.group(), called, name)),
        Side::Output => (format!("{}{name}", group::OUTPUT), group::renamed_output(root, within.group(), called, name)),
    };
    let own = within.rebased(&sheet.library, edit::renamed(sheet, &node.name, &new))?;
    Ok(Edit::new(format!("Rename {called} to {name}"), [uses, own.ops].concat()))
}

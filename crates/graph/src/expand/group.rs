//! Definitions of groups: what a document says under `"groups"`.

use super::Expander;
use crate::check::is_legal_name;
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Accepts, nearest};

/// A group: nodes that are used like one.
pub(super) struct Group<'d> {
    pub(super) name: &'d str,
    pub(super) inputs: Vec<Input<'d>>,
    pub(super) knobs: Vec<GroupKnob<'d>>,
    pub(super) nodes: Vec<&'d Entry>,
    /// Names of outputs, and the references within the group that they stand for; the first one is meant where a
    /// reference names none.
    pub(super) outputs: Vec<(&'d str, &'d Spanned)>,
}

/// Socket of a group.
pub(super) struct Input<'d> {
    pub(super) name: &'d str,
    pub(super) accepts: Accepts,
    /// What is connected if the use connects nothing.
    pub(super) default: Option<&'d Spanned>,
    /// Whether ports inside stay open if nothing is connected.
    pub(super) is_optional: bool,
}

/// Knob of a group, or of the document.
pub(super) struct GroupKnob<'d> {
    pub(super) name: &'d str,
    /// Value if the use sets none; `None` if it must.
    pub(super) default: Option<&'d Spanned>,
    pub(super) range: [f64; 2],
}

/// Keys of a group.
const KEYS: [&str; 6] = ["inputs", "knobs", "nodes", "outputs", "ui", "notes"];
/// Keys of an input that is written as an object.
const INPUT_KEYS: [&str; 5] = ["kind", "default", "optional", "help", "notes"];
/// Keys of a knob of a group, and of one of the document.
const KNOB_KEYS: [&str; 7] = ["default", "min", "max", "unit", "help", "ui", "notes"];
const DOCUMENT_KNOB_KEYS: [&str; 7] = ["value", "min", "max", "unit", "help", "ui", "notes"];

impl<'d> Expander<'d> {
    /// Reads the groups of a document.
    pub(super) fn groups(&mut self, value: &'d Spanned) -> Vec<Group<'d>> {
        let expected = "an object of groups by name";
        let Some(entries) = self.object(value, "groups", expected) else { return Vec::new() };
        let mut groups: Vec<Group<'d>> = Vec::new();
        for entry in entries {
            let name = entry.key.as_str();
            if !is_legal_name(name) {
                let found = format!("the group name \"{}\"", shorten(name));
                self.error(entry.offset, found, "a–z, A–Z, 0–9 and _, not starting with a digit", "rename the group");
                continue;
            }
            if self.registry.get(name).is_some() {
                let found = format!("the group name \"{name}\", which is a node type");
                self.error(entry.offset, found, "a name of its own", "rename the group");
                continue;
            }
            groups.extend(self.group(entry));
        }
        groups
    }

    fn group(&mut self, entry: &'d Entry) -> Option<Group<'d>> {
        let name = entry.key.as_str();
        let place = format!("groups.{name}");
        let entries = self.object(&entry.value, &place, "an object with \"nodes\" and \"outputs\"")?;
        let mut group = Group { name, inputs: Vec::new(), knobs: Vec::new(), nodes: Vec::new(), outputs: Vec::new() };
        for item in entries {
            let within = format!("{place}.{}", shorten(&item.key));
            match item.key.as_str() {
                "inputs" => {
                    let inputs = self.object(&item.value, &within, "an object of inputs by name").unwrap_or_default();
                    group.inputs = inputs.into_iter().filter_map(|input| self.declared_input(input, &within)).collect();
                }
                "knobs" => group.knobs = self.knobs(&item.value, &within, "default"),
                "nodes" => {
                    group.nodes = self.object(&item.value, &within, "an object of nodes by name").unwrap_or_default();
                }
                "outputs" => {
                    let expected = "an object of references by name, such as { \"surface\": \"hull\" }";
                    for output in self.object(&item.value, &within, expected).unwrap_or_default() {
                        match &output.value.json {
                            Json::String(_) => group.outputs.push((output.key.as_str(), &output.value)),
                            _ => self.error(
                                output.value.offset,
                                output.value.brief(),
                                "a reference to a node of the group",
                                "write the name of a node in quotes",
                            ),
                        }
                    }
                }
                "ui" | "notes" => {}
                key => self.unknown(item.offset, key, &KEYS),
            }
        }
        if group.nodes.is_empty() {
            self.error(entry.offset, format!("the group \"{name}\" without nodes"), "\"nodes\"", "add them");
        }
        if group.outputs.is_empty() {
            let remedy = "add \"outputs\": { \"NAME\": \"NODE\" }";
            self.error(entry.offset, format!("the group \"{name}\" without outputs"), "at least one output", remedy);
        }
        let names = group.inputs.iter().map(|input| input.name);
        let names: Vec<&str> = names.chain(group.nodes.iter().map(|node| node.key.as_str())).collect();
        if let Some(twice) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
            let found =
                format!("the name \"{}\" for an input and for a node of the group \"{name}\"", shorten(twice.1));
            self.error(entry.offset, found, "each name once in a group", "rename one of them");
        }
        let items = group.inputs.iter().map(|input| input.name).chain(group.knobs.iter().map(|knob| knob.name));
        let items: Vec<&str> = items.collect();
        if let Some(twice) = items.iter().enumerate().find(|(at, name)| items[..*at].contains(name)) {
            let found =
                format!("the name \"{}\" for an input and for a knob of the group \"{name}\"", shorten(twice.1));
            self.error(entry.offset, found, "each name once in a group", "rename one of them");
        }
        Some(group)
    }

    fn declared_input(&mut self, entry: &'d Entry, place: &str) -> Option<Input<'d>> {
        let name = entry.key.as_str();
        if !is_legal_name(name) || ["type", "disabled", "ui", "notes", "knobs"].contains(&name) {
            let found = format!("the name \"{}\" of an input", shorten(name));
            self.error(entry.offset, found, "a–z, A–Z, 0–9 and _, and no key of nodes", "rename it");
            return None;
        }
        let (mut kind, mut default, mut is_optional) = (None, None, false);
        match &entry.value.json {
            Json::String(_) => kind = Some(&entry.value),
            Json::Object(_) => {
                for item in self.object(&entry.value, place, "an object with \"kind\"")? {
                    match (item.key.as_str(), &item.value.json) {
                        ("kind", _) => kind = Some(&item.value),
                        ("default", _) => default = Some(&item.value),
                        ("optional", Json::Bool(value)) => is_optional = *value,
                        ("optional", _) => {
                            self.error(item.value.offset, item.value.brief(), "true or false", "write true or false");
                        }
                        ("help" | "notes", _) => {}
                        (key, _) => self.unknown(item.offset, key, &INPUT_KEYS),
                    }
                }
            }
            _ => kind = Some(&entry.value),
        }
        let text = kind.and_then(|kind| if let Json::String(text) = &kind.json { Some(text.as_str()) } else { None });
        let Some(accepts) = text.and_then(input_accepts) else {
            let names = input_kinds();
            let at = kind.unwrap_or(&entry.value);
            let remedy = match text.and_then(|text| nearest(text, names.iter().map(String::as_str))) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("write one of {}", names.join(", ")),
            };
            self.error(at.offset, at.brief(), format!("the kind of the input \"{name}\""), remedy);
            return None;
        };
        Some(Input { name, accepts, default, is_optional })
    }

    /// Reads the knobs of a group, whose values are under `"default"`, or those of the document, under `"value"`.
    pub(super) fn knobs(&mut self, value: &'d Spanned, place: &str, key: &str) -> Vec<GroupKnob<'d>> {
        let entries = self.object(value, place, "an object of knobs by name").unwrap_or_default();
        entries.into_iter().filter_map(|entry| self.group_knob(entry, place, key)).collect()
    }

    fn group_knob(&mut self, entry: &'d Entry, place: &str, key: &str) -> Option<GroupKnob<'d>> {
        let name = entry.key.as_str();
        if !is_legal_name(name) || ["type", "disabled", "ui", "notes"].contains(&name) {
            let found = format!("the name \"{}\" of a knob", shorten(name));
            self.error(entry.offset, found, "a–z, A–Z, 0–9 and _, and no key of nodes", "rename it");
            return None;
        }
        let mut knob = GroupKnob { name, default: None, range: [f64::NEG_INFINITY, f64::INFINITY] };
        // A value by itself is short for one without a range; keys are values, too.
        let is_described =
            matches!(&entry.value.json, Json::Object(items) if !items.iter().any(|item| item.key == "keys"));
        if !is_described {
            knob.default = Some(&entry.value);
            return Some(knob);
        }
        let known = if key == "value" { DOCUMENT_KNOB_KEYS } else { KNOB_KEYS };
        for item in self.object(&entry.value, place, "a knob")? {
            match (item.key.as_str(), &item.value.json) {
                (own, _) if own == key => knob.default = Some(&item.value),
                ("min", Json::Number(number)) => knob.range[0] = *number,
                ("max", Json::Number(number)) => knob.range[1] = *number,
                ("min" | "max", _) => self.error(item.value.offset, item.value.brief(), "a number", "write a number"),
                ("unit" | "help" | "ui" | "notes", _) => {}
                (key, _) => self.unknown(item.offset, key, &known),
            }
        }
        if knob.default.is_none() && key == "value" {
            let found = format!("the knob \"{name}\" without a value");
            self.error(entry.offset, found, "\"value\"", "add \"value\": …");
            return None;
        }
        if knob.range[0] > knob.range[1] {
            let found = format!("\"min\" {} and \"max\" {}", knob.range[0], knob.range[1]);
            self.error(entry.offset, found, "min ≤ max", "swap them");
            return None;
        }
        Some(knob)
    }
}

/// What inputs of groups may take.
pub const INPUT_ACCEPTS: [Accepts; 9] = [
    Accepts::Color,
    Accepts::Mask,
    Accepts::Weights,
    Accepts::Field,
    Accepts::Image,
    Accepts::Surface,
    Accepts::Camera,
    Accepts::Light,
    Accepts::View,
];

/// Returns the names of what inputs may take.
pub(crate) fn input_kinds() -> Vec<String> {
    INPUT_ACCEPTS.map(input_kind).into()
}

/// Returns the name of what an input takes.
pub fn input_kind(accepts: Accepts) -> String {
    match accepts {
        Accepts::Mask => "Mask".into(),
        Accepts::Image => "Image".into(),
        accepts => accepts.to_string(),
    }
}

/// Returns what an input takes whose kind has this name.
pub fn input_accepts(name: &str) -> Option<Accepts> {
    INPUT_ACCEPTS.into_iter().find(|accepts| input_kind(*accepts) == name)
}

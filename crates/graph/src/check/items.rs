//! Reads the ports and knobs of a node according to its declaration.

use super::keyed::{COLOR, FINITE};
use super::palette::is_name;
use super::values::{count, expected};
use super::weight_names::{WEIGHT_NAMES, takes_weight_names};
use super::{Checker, Draft, FaultLocation};
use crate::declare::{KnobDefault, KnobType};
use crate::registry::item_names;
use crate::spanned::{Entry, Json, Spanned, number_text, shorten};
use crate::{
    Accepts, Animated, Arity, Declaration, Item, Kind, Knob, List, NodeId, Port, Record, Setting, Severity, Source,
    nearest, refusal,
};
use std::collections::HashMap;

/// Returns the name of an item in a record of a list, such as `waves[0].wavelength`, or that of the record for no item.
fn within(list: &str, index: usize, item: Option<String>) -> String {
    match item.filter(|item| item != list) {
        Some(item) => format!("{list}[{index}].{item}"),
        None => format!("{list}[{index}]"),
    }
}

/// Nodes that a reference may name, with their indices and declarations.
pub(super) type Names<'m> = HashMap<&'m str, (usize, Option<&'static Declaration>)>;

/// Keys that every node may carry.
const COMMON: [&str; 4] = ["type", "disabled", "ui", "notes"];

impl<'a> Checker<'a> {
    /// Reads the items of a node whose type is known.
    pub(super) fn fill_in(&mut self, draft: &mut Draft<'a>, entry: &'a Entry, names: &Names<'a>) {
        let Some(ty) = draft.ty else { return };
        let place = FaultLocation { offset: entry.offset, node: Some(draft.name), port: None };
        let Some(entries) = self.object(&entry.value, place, "an object with a \"type\"") else { return };
        if let Some(disabled) = entries.iter().find(|entry| entry.key == "disabled") {
            match disabled.value.json {
                Json::Bool(value) => draft.disabled = value,
                _ => {
                    let place =
                        FaultLocation { offset: disabled.value.offset, node: Some(draft.name), port: Some("disabled") };
                    self.error(place, disabled.value.brief(), "true or false", "write true or false");
                }
            }
        }
        let is_common =
            |key: &str| COMMON.contains(&key) || (key == WEIGHT_NAMES && takes_weight_names(ty.declaration()));
        let own: Vec<&Entry> = entries.into_iter().filter(|entry| !is_common(&entry.key)).collect();
        for entry in &own {
            if let Some(name) = item_names(ty.declaration().items).find(|name| *name == entry.key) {
                draft.offsets.push((name, entry.value.offset));
            }
        }
        let before = self.diagnostics.len();
        // Names of operands in other compositors.
        let operands: Vec<&Entry> =
            own.iter().copied().filter(|entry| matches!(entry.key.as_str(), "a" | "b" | "A" | "B")).collect();
        if let (Some(refusal), Some(first)) = (refusal(ty.declaration().name), operands.first()) {
            if operands.iter().all(|entry| is_mask(&entry.value, names)) {
                // The operation is legal, but written in another way.
                let listed: Vec<String> = operands.iter().map(|entry| entry.value.brief()).collect();
                let keys: Vec<String> = operands.iter().map(|entry| format!("\"{}\"", entry.key)).collect();
                let remedy = format!("write \"weights\": [{}]", listed.join(", "));
                let place = FaultLocation { port: Some("weights"), ..place.at(first.offset) };
                self.error(place, keys.join(" and "), "masks in one list, \"weights\"", remedy);
            } else {
                let offset = entries_type(&entry.value).unwrap_or(entry.offset);
                self.refused(FaultLocation { offset, port: Some("type"), ..place }, ty.declaration().name, refusal);
            }
            // The node counts as one of unknown type: its record has none of the declared items.
            (draft.ty, draft.faulty) = (None, true);
            return;
        }
        draft.record = self.record(ty.declaration().items, &own, place, names);
        draft.has_gaps = std::mem::take(&mut self.has_gaps);
        draft.faulty = self.diagnostics[before..].iter().any(|found| found.severity == Severity::Error);
    }

    fn record(
        &mut self,
        items: &'static [Item],
        entries: &[&'a Entry],
        place: FaultLocation<'_>,
        names: &Names<'a>,
    ) -> Record {
        let known: Vec<&str> = item_names(items).collect();
        let mut misspelt = Vec::new();
        for entry in entries {
            if !known.contains(&entry.key.as_str()) {
                self.unknown_key(place.at(entry.offset), &entry.key, &known);
                misspelt.push((nearest(&entry.key, known.iter().copied()), &entry.value));
            }
        }
        let mut record = Record::default();
        for item in items {
            let value = entries.iter().find(|entry| entry.key == item.name()).map(|entry| &entry.value);
            // What is there under a misspelt name is not reported as missing.
            let meant = || misspelt.iter().find(|(meant, _)| *meant == Some(item.name())).map(|(_, value)| *value);
            let value = value.or_else(meant);
            let place =
                FaultLocation { offset: value.map_or(place.offset, |v| v.offset), port: Some(item.name()), ..place };
            match item {
                Item::Port(port) => record.ports.push((port.name, self.port(port, value, place, names))),
                Item::Knob(knob) => record.knobs.push((knob.name, self.knob(knob, value, place))),
                Item::List(list) => record.lists.push((list.name, self.list(list, value, place, names))),
            }
        }
        record
    }

    fn list(
        &mut self,
        list: &'static List,
        value: Option<&'a Spanned>,
        place: FaultLocation<'_>,
        names: &Names<'a>,
    ) -> Vec<Record> {
        let expected = format!("a list of {}", count(list.min, list.max, "record"));
        let Some(value) = value else {
            if list.min > 0 {
                self.error(place, format!("no \"{}\"", list.name), expected, how_to_write(list));
            }
            return Vec::new();
        };
        match &value.json {
            Json::Array(items) if (list.min..=list.max).contains(&items.len()) => items
                .iter()
                .enumerate()
                .filter_map(|(index, item)| {
                    if !matches!(item.json, Json::Object(_)) {
                        let expected = format!("a record: {{ {} }}", keys_of(list));
                        self.error(place.at(item.offset), item.brief(), expected, how_to_write(list));
                        return None;
                    }
                    let entries = self.object(item, place, "an object")?;
                    let before = self.diagnostics.len();
                    self.records.push((list.name, index));
                    let record = self.record(list.items, &entries, place.at(item.offset), names);
                    self.records.pop();
                    // Values from `--set` have no line and column, so only the name tells an item of the record from
                    // one of the node.
                    let news = self.diagnostics[before..].iter_mut().filter(|found| found.line == 0);
                    news.for_each(|found| found.port = Some(within(list.name, index, found.port.take())));
                    Some(record)
                })
                .collect(),
            _ => {
                self.error(place, value.brief(), expected, how_to_write(list));
                Vec::new()
            }
        }
    }

    fn port(
        &mut self,
        port: &Port,
        value: Option<&'a Spanned>,
        place: FaultLocation<'_>,
        names: &Names<'a>,
    ) -> Vec<Source> {
        match (port.arity, value) {
            (Arity::Optional, None) => Vec::new(),
            (Arity::Many { min: 0, .. }, None) => Vec::new(),
            (_, None) => {
                let remedy = format!("connect it ({})", port.help.trim_end_matches('.'));
                self.error(place, format!("no \"{}\"", port.name), format!("a {}", port.accepts), remedy);
                Vec::new()
            }
            (Arity::One | Arity::Optional, Some(value)) => {
                self.source(port.accepts, value, place, names).into_iter().collect()
            }
            (Arity::Many { min, max }, Some(value)) => {
                let Json::Array(items) = &value.json else {
                    self.no_list(port, [min, max], value, place);
                    return Vec::new();
                };
                let mut sources = Vec::new();
                for (index, item) in items.iter().enumerate() {
                    self.element = Some(index);
                    sources.extend(self.source(port.accepts, item, place.at(item.offset), names));
                    self.element = None;
                }
                self.has_gaps |= sources.len() < items.len();
                if !(min..=max).contains(&items.len()) {
                    self.no_list(port, [min, max], value, place);
                    return Vec::new();
                }
                sources
            }
        }
    }

    /// Reports a value that is no list of as many connections as a port takes.
    fn no_list(&mut self, port: &Port, [min, max]: [usize; 2], value: &Spanned, place: FaultLocation<'_>) {
        self.has_gaps = true;
        let expected = format!("a list of {}", count(min, max, &port.accepts.to_string()));
        self.error(place, value.brief(), expected, "write them in brackets: [ … ]");
    }

    /// Returns the node and the item at a place, such as `stops[1].color`, while they are read.
    pub(super) fn item_at(&self, place: FaultLocation<'_>) -> Option<(String, String)> {
        let within: String = self.records.iter().map(|(list, index)| format!("{list}[{index}].")).collect();
        let index = self.element.map_or(String::new(), |index| format!("[{index}]"));
        Some((place.node?.into(), within + place.port? + &index))
    }

    fn source(
        &mut self,
        accepts: Accepts,
        value: &'a Spanned,
        place: FaultLocation<'_>,
        names: &Names<'a>,
    ) -> Option<Source> {
        self.linked_port(value.offset, place);
        match &value.json {
            Json::String(text) if accepts.takes_color() && is_name(text) => {
                self.named(text, place, true).map(Source::Color)
            }
            Json::String(text) if !accepts.takes_color() && (text.starts_with('#') || is_name(text)) => {
                let remedy = match accepts {
                    Accepts::Mask => "write a number from 0 to 1, or the name of a mask; a color cannot be a weight",
                    Accepts::Weights => {
                        "write the name of a node, or numbers that sum to 1; a color cannot be a weight"
                    }
                    Accepts::Scalar | Accepts::Field => "write a number, or the name of a node",
                    _ => "write the name of a node",
                };
                self.error(place, format!("the color {}", value.brief()), format!("a {accepts}"), remedy);
                None
            }
            Json::String(text) if !(accepts.takes_color() && text.starts_with('#')) => {
                self.reference(text, place, names, accepts.takes_color())
            }
            Json::Number(number)
                if matches!(accepts, Accepts::Mask | Accepts::Image) && !(0.0..=1.0).contains(number) =>
            {
                let remedy =
                    "a weight and its complement must both be ≥ 0: write a number from 0 to 1, or Clamp a Field";
                self.error(place, value.brief(), "a mask: a number in [0, 1]", remedy);
                None
            }
            Json::Number(number) if accepts.takes_number() && number.is_finite() => {
                Some(Source::Number(Animated::constant(vec![*number])))
            }
            Json::Number(_) if accepts.takes_number() => {
                self.error(place, value.brief(), "a finite number", "write a smaller number");
                None
            }
            Json::Object(_) if accepts.takes_number() && accepts != Accepts::Image => {
                let (min, max) = if accepts == Accepts::Mask { (0.0, 1.0) } else { (f64::MIN, f64::MAX) };
                self.animated(value, [min, max], place, |checker, value, place| {
                    checker.number(value, min, max, place).map(|number| vec![number])
                })
                .map(Source::Number)
            }
            Json::String(_) | Json::Array(_) | Json::Object(_) if accepts == Accepts::Color => {
                self.animated(value, COLOR, place, Self::color).map(Source::Color)
            }
            // Keyed values are not accepted: they could be colors or masks.
            Json::String(_) | Json::Array(_) if accepts == Accepts::Image => {
                self.color(value, place).map(|color| Source::Color(Animated::constant(color)))
            }
            Json::Array(items) if accepts == Accepts::Weights => self.literal_weights(items, place),
            _ => {
                let literal = match accepts {
                    Accepts::Color => " or a color",
                    Accepts::Image => ", a color or a number",
                    Accepts::Mask | Accepts::Scalar | Accepts::Field => " or a number",
                    Accepts::Weights => " or a list of numbers that sum to 1",
                    _ => "",
                };
                let expected = format!("a reference to a {accepts}{literal}");
                let remedy = match (&value.json, accepts) {
                    (Json::Array(_), Accepts::Mask | Accepts::Scalar | Accepts::Field) => {
                        "write the name of a node in quotes; for keys, write { \"keys\": [[1, 0], [10, 1]] }"
                    }
                    _ => "write the name of a node in quotes",
                };
                self.error(place, value.brief(), expected, remedy);
                None
            }
        }
    }

    /// Resolves the node and output that a text names. With `or_color`, the remedy also explains literal colors.
    pub(super) fn reference(
        &mut self,
        text: &str,
        place: FaultLocation<'_>,
        names: &Names<'a>,
        or_color: bool,
    ) -> Option<Source> {
        let (name, output) = node_and_output(text, names);
        let Some(&(node, declaration)) = names.get(name) else {
            let near = if self.is_full() { None } else { nearest(name, names.keys().copied()) };
            let is_hex = matches!(name.len(), 3 | 6) && name.bytes().all(|byte| byte.is_ascii_hexdigit());
            let is_number = text.parse::<f64>().is_ok_and(f64::is_finite);
            let name = if is_number { text } else { name };
            let remedy = match near {
                _ if is_number => format!("write numbers without quotes: {text}"),
                _ if or_color && let Some(named) = self.meant(text) => format!("did you mean \"{named}\"?"),
                _ if or_color && is_hex => format!("did you mean \"#{name}\"?"),
                Some(near) => format!("did you mean \"{near}\"?"),
                None if or_color => "add the node, or correct the name; a color is written \"#rrggbb\"".into(),
                None => "add the node, or correct the name".into(),
            };
            self.error(
                place,
                format!("a reference to \"{}\", which is not a node", shorten(name)),
                "the name of a node",
                remedy,
            );
            return None;
        };
        let index = match (output, declaration) {
            (None, _) | (_, None) => 0,
            (Some(output), Some(declaration)) => {
                let outputs = declaration.outputs;
                match outputs.iter().position(|known| known.name == output) {
                    Some(index) => index,
                    None => {
                        let known: Vec<&str> = outputs.iter().map(|output| output.name).collect();
                        let remedy = match nearest(output, known.iter().copied()) {
                            Some(near) => format!("did you mean \"{name}.{near}\"?"),
                            None if takes_weight_names(declaration) => format!(
                                "name its weights by \"{WEIGHT_NAMES}\": [ … ], or count them: \"{name}.0\", \"{name}.1\""
                            ),
                            None => format!("outputs of {}: {}", declaration.name, known.join(", ")),
                        };
                        let found = format!("a reference to output \"{}\" of a {}", shorten(output), declaration.name);
                        self.error(place, found, "one of its outputs", remedy);
                        return None;
                    }
                }
            }
        };
        Some(Source::Output { node: NodeId(node), output: index })
    }

    fn knob(&mut self, knob: &Knob, value: Option<&'a Spanned>, place: FaultLocation<'_>) -> Setting {
        let Some(value) = value else {
            return match knob.default {
                None => {
                    let remedy = format!("write \"{}\": {}", knob.name, example(&knob.takes));
                    self.error(place, format!("no \"{}\"", knob.name), expected(&knob.takes), remedy);
                    Setting::Unset
                }
                Some(KnobDefault::Number(number)) => Setting::Numeric(Animated::constant(vec![number])),
                Some(KnobDefault::Bool(value)) => Setting::Bool(value),
                Some(KnobDefault::Text(text)) => Setting::Text(text.into()),
                Some(KnobDefault::Vector(values)) => Setting::Numeric(Animated::constant(values.to_vec())),
                Some(KnobDefault::Unset) => Setting::Unset,
            };
        };
        if !knob.animated && matches!(value.json, Json::Object(_)) {
            self.error(place, "a keyed value", expected(&knob.takes), "this knob cannot be animated: write one value");
            return Setting::Unset;
        }
        let setting = match knob.takes {
            KnobType::Number { min, max } => self
                .animated(value, [min, max], place, |checker, value, place| {
                    Some(vec![checker.number(value, min, max, place)?])
                })
                .map(Setting::Numeric),
            KnobType::Integer { min, max } => self
                .animated(value, [min as f64, max as f64], place, |checker, value, place| {
                    let number = checker.number(value, min as f64, max as f64, place)?;
                    if number.fract() != 0.0 {
                        checker.error(place, value.brief(), "a whole number", format!("write {}", number.trunc()));
                        return None;
                    }
                    Some(vec![number])
                })
                .map(Setting::Numeric),
            KnobType::Color => self.color_or_name(value, place).map(Setting::Numeric),
            KnobType::Vector(n) => self
                .animated(value, FINITE, place, |checker, value, place| checker.vector(value, n, n, place))
                .map(Setting::Numeric),
            KnobType::Numbers { min, max } => self.vector(value, min, max, place).map(Setting::Numbers),
            KnobType::Bool => match value.json {
                Json::Bool(value) => Some(Setting::Bool(value)),
                _ => self.mismatch(value, &knob.takes, place),
            },
            KnobType::Choice(words) => match &value.json {
                Json::String(text) if words.contains(&text.as_str()) => Some(Setting::Text(text.clone())),
                Json::String(text) => {
                    let remedy = match nearest(text, words.iter().copied()) {
                        Some(near) => format!("did you mean \"{near}\"?"),
                        None => format!("choose one of these: {}", knob.help),
                    };
                    self.error(place, value.brief(), expected(&knob.takes), remedy);
                    None
                }
                _ => self.mismatch(value, &knob.takes, place),
            },
            KnobType::Text | KnobType::Path => match &value.json {
                Json::String(text) if !text.is_empty() && !text.contains('\0') => Some(Setting::Text(text.clone())),
                _ => self.mismatch(value, &knob.takes, place),
            },
            KnobType::Texts { max } => match &value.json {
                Json::Array(items) if (1..=max).contains(&items.len()) => {
                    let texts: Vec<String> = items
                        .iter()
                        .filter_map(|item| if let Json::String(text) = &item.json { Some(text.clone()) } else { None })
                        .collect();
                    if texts.len() == items.len() {
                        Some(Setting::Texts(texts))
                    } else {
                        self.mismatch(value, &knob.takes, place)
                    }
                }
                _ => self.mismatch(value, &knob.takes, place),
            },
        };
        match setting {
            Some(Setting::Numeric(animated)) if knob.hold_keys => {
                match animated.held(is_said(value, "interpolation")) {
                    Some(held) => Setting::Numeric(held),
                    None => {
                        let expected = "no \"interpolation\", or \"hold\", and no handles";
                        self.error(place, "an interpolation", expected, "each key of this knob holds until the next");
                        Setting::Unset
                    }
                }
            }
            setting => setting.unwrap_or(Setting::Unset),
        }
    }

    fn mismatch<T>(&mut self, value: &Spanned, takes: &KnobType, place: FaultLocation<'_>) -> Option<T> {
        self.error(place, value.brief(), expected(takes), "correct the value");
        None
    }
}

/// Returns the first keys of the records of a list.
fn keys_of(list: &List) -> String {
    let keys: Vec<String> = item_names(list.items).map(|name| format!("\"{name}\"")).collect();
    let (most, more) = (keys.len().min(4), if keys.len() > 4 { ", …" } else { "" });
    format!("{}{more}", keys[..most].join(", "))
}

/// Returns an example of a value, as JSON.
fn example(takes: &KnobType) -> String {
    match takes {
        KnobType::Number { min, max } => number_text(0.0_f64.clamp(*min, *max)),
        KnobType::Integer { min, max } => 0.clamp(*min, *max).to_string(),
        KnobType::Bool => "true, or false".into(),
        KnobType::Choice(words) => {
            let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
            match &words[..] {
                [rest @ .., last] if !rest.is_empty() => format!("{}, or {last}", rest.join(", ")),
                words => words.join(", "),
            }
        }
        KnobType::Color => "\"#rrggbb\"".into(),
        KnobType::Vector(_) | KnobType::Numbers { .. } => "[ … ], a list of numbers".into(),
        KnobType::Text => "a string in quotes".into(),
        KnobType::Path => "the path of a file in quotes, relative to the document".into(),
        KnobType::Texts { .. } => "[ … ], a list of strings in quotes".into(),
    }
}

/// Returns the remedy for a missing or wrong list.
fn how_to_write(list: &List) -> String {
    format!("write \"{}\": [{{ … }}, …], a list of records with {}: {}", list.name, keys_of(list), list.help)
}

/// Whether a value is certainly a mask: a number from 0 to 1, or an output that is declared as a mask.
fn is_mask(value: &Spanned, names: &Names<'_>) -> bool {
    match &value.json {
        Json::Number(number) => (0.0..=1.0).contains(number),
        Json::String(text) => {
            let (name, output) = node_and_output(text, names);
            let outputs =
                names.get(name).and_then(|(_, declaration)| *declaration).map_or(&[][..], |known| known.outputs);
            let made = match output {
                Some(output) => outputs.iter().find(|known| known.name == output),
                None => outputs.first(),
            };
            made.is_some_and(|made| made.kind == Kind::MASK)
        }
        _ => false,
    }
}

/// Splits a reference into the name of a node and that of its output, if it names one. Names of nodes that pick weights
/// have dots themselves.
pub(super) fn node_and_output<'t>(text: &'t str, names: &Names<'_>) -> (&'t str, Option<&'t str>) {
    match text.split_once('.') {
        Some((name, output)) if !names.contains_key(text) => (name, Some(output)),
        _ => (text, None),
    }
}

/// Returns the place of the type in an object.
fn entries_type(value: &Spanned) -> Option<usize> {
    let Json::Object(entries) = &value.json else { return None };
    entries.iter().find(|entry| entry.key == "type").map(|entry| entry.value.offset)
}

/// Whether an object has a key.
fn is_said(value: &Spanned, key: &str) -> bool {
    if let Json::Object(entries) = &value.json { entries.iter().any(|entry| entry.key == key) } else { false }
}

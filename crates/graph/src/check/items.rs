//! A node's ports and knobs, read as its declaration says.

use super::{Checker, Draft, Place};
use crate::declare::{Default, Takes};
use crate::registry::item_names;
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{
    Accepts, Animated, Arity, Declaration, Interpolation, Item, Knob, List, NodeId, Port, Record, Setting, Source,
    nearest,
};
use std::collections::HashMap;
use trochoid_image::{parse_hex, srgb_decode};

/// What a reference may name: nodes, each with its position and declaration.
pub(super) type Names<'m> = HashMap<&'m str, (usize, Option<&'static Declaration>)>;

/// Keys that every node may carry.
const COMMON: [&str; 4] = ["type", "disabled", "ui", "notes"];

impl<'a> Checker<'a> {
    /// Reads the items of a node whose type is known.
    pub(super) fn fill_in(&mut self, draft: &mut Draft<'a>, entry: &'a Entry, names: &Names<'a>) {
        let Some(ty) = draft.ty else { return };
        let place = Place { offset: entry.offset, node: Some(draft.name), port: None };
        let Some(entries) = self.object(&entry.value, place, "an object with a \"type\"") else { return };
        if let Some(disabled) = entries.iter().find(|entry| entry.key == "disabled") {
            match disabled.value.json {
                Json::Bool(value) => draft.disabled = value,
                _ => {
                    let place = Place { offset: disabled.value.offset, node: Some(draft.name), port: Some("disabled") };
                    self.error(place, disabled.value.brief(), "true or false", "write true or false");
                }
            }
        }
        let own: Vec<&Entry> = entries.into_iter().filter(|entry| !COMMON.contains(&entry.key.as_str())).collect();
        for entry in &own {
            if let Some(name) = item_names(ty.declaration().items).find(|name| *name == entry.key) {
                draft.offsets.insert(name, entry.value.offset);
            }
        }
        let before = self.diagnostics.len();
        draft.record = self.record(ty.declaration().items, &own, place, names);
        draft.faulty = self.diagnostics.len() > before;
    }

    fn record(&mut self, items: &'static [Item], entries: &[&'a Entry], place: Place<'_>, names: &Names<'a>) -> Record {
        let known: Vec<&str> = item_names(items).collect();
        for entry in entries {
            if !known.contains(&entry.key.as_str()) {
                self.unknown_key(place.at(entry.offset), &entry.key, &known);
            }
        }
        let mut record = Record::default();
        for item in items {
            let value = entries.iter().find(|entry| entry.key == item.name()).map(|entry| &entry.value);
            let place = Place { offset: value.map_or(place.offset, |v| v.offset), port: Some(item.name()), ..place };
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
        place: Place<'_>,
        names: &Names<'a>,
    ) -> Vec<Record> {
        let expected = format!("a list of {}", count(list.min, list.max, "record"));
        let Some(value) = value else {
            if list.min > 0 {
                self.error(place, format!("no \"{}\"", list.name), expected, format!("add it: {}", list.help));
            }
            return Vec::new();
        };
        match &value.json {
            Json::Array(items) if (list.min..=list.max).contains(&items.len()) => items
                .iter()
                .filter_map(|item| {
                    let entries = self.object(item, place, "an object")?;
                    Some(self.record(list.items, &entries, place.at(item.offset), names))
                })
                .collect(),
            _ => {
                self.error(place, value.brief(), expected, list.help);
                Vec::new()
            }
        }
    }

    fn port(&mut self, port: &Port, value: Option<&'a Spanned>, place: Place<'_>, names: &Names<'a>) -> Vec<Source> {
        match (port.arity, value) {
            (Arity::Optional, None) => Vec::new(),
            (Arity::Many { min: 0, .. }, None) => Vec::new(),
            (_, None) => {
                let remedy = format!("connect it: {}", port.help);
                self.error(place, format!("no \"{}\"", port.name), format!("a {}", port.accepts), remedy);
                Vec::new()
            }
            (Arity::One | Arity::Optional, Some(value)) => {
                self.source(port.accepts, value, place, names).into_iter().collect()
            }
            (Arity::Many { min, max }, Some(value)) => match &value.json {
                Json::Array(items) if (min..=max).contains(&items.len()) => items
                    .iter()
                    .filter_map(|item| self.source(port.accepts, item, place.at(item.offset), names))
                    .collect(),
                _ => {
                    let expected = format!("a list of {}", count(min, max, &port.accepts.to_string()));
                    self.error(place, value.brief(), expected, "write them in brackets: [ … ]");
                    Vec::new()
                }
            },
        }
    }

    fn source(&mut self, accepts: Accepts, value: &'a Spanned, place: Place<'_>, names: &Names<'a>) -> Option<Source> {
        match &value.json {
            Json::String(text) if !(accepts == Accepts::Color && text.starts_with('#')) => {
                self.reference(text, place, names)
            }
            Json::Number(number) if accepts == Accepts::Mask && !(0.0..=1.0).contains(number) => {
                let remedy =
                    "a weight and its complement must both be ≥ 0: write a number from 0 to 1, or Clamp a Field";
                self.error(place, value.brief(), "a mask: a number in [0, 1]", remedy);
                None
            }
            Json::Number(number) if accepts.takes_number() && number.is_finite() => {
                Some(Source::Number(Animated::constant(vec![*number])))
            }
            Json::Object(_) if accepts.takes_number() => {
                let (min, max) = if accepts == Accepts::Mask { (0.0, 1.0) } else { (f64::MIN, f64::MAX) };
                self.animated(value, place, |checker, value, place| {
                    checker.number(value, min, max, place).map(|number| vec![number])
                })
                .map(Source::Number)
            }
            Json::String(_) | Json::Array(_) | Json::Object(_) if accepts == Accepts::Color => {
                self.animated(value, place, Self::color).map(Source::Color)
            }
            Json::Array(items) if accepts == Accepts::Weights => self.literal_weights(items, place),
            _ => {
                let literal = match accepts {
                    Accepts::Color => " or a color",
                    Accepts::Mask | Accepts::Scalar | Accepts::Field => " or a number",
                    Accepts::Weights => " or a list of numbers that sum to 1",
                    _ => "",
                };
                let expected = format!("a reference to a {accepts}{literal}");
                self.error(place, value.brief(), expected, "write the name of a node in quotes");
                None
            }
        }
    }

    /// Numbers as weights: ≥ 0, with sum 1 up to the rounding of decimal fractions.
    fn literal_weights(&mut self, items: &'a [Spanned], place: Place<'_>) -> Option<Source> {
        let mut numbers = Vec::with_capacity(items.len());
        for item in items {
            numbers.push(self.number(item, f64::MIN, f64::MAX, place.at(item.offset))?);
        }
        let sum: f64 = numbers.iter().sum();
        let lowest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest < 0.0 {
            let found = format!("the weight {lowest}");
            let remedy = "a negative weight pushes the color out of the palette on the far side: use 0, or another control color";
            self.error(place, found, "weights ≥ 0 that sum to 1", remedy);
            return None;
        }
        if (sum - 1.0).abs() > 1e-6 {
            let scaled: Vec<String> = numbers.iter().map(|w| format!("{:.4}", w / sum)).collect();
            let found = format!("weights that sum to {sum}: equal colors of 0.6 would give {}", 0.6 * sum);
            let remedy = if sum > 0.0 {
                format!("divide by the sum: [{}]", scaled.join(", "))
            } else {
                "one weight must be above 0".into()
            };
            self.error(place, found, "weights ≥ 0 that sum to 1", remedy);
            return None;
        }
        Some(Source::Numbers(numbers))
    }

    pub(super) fn reference(&mut self, text: &str, place: Place<'_>, names: &Names<'a>) -> Option<Source> {
        let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
        let Some(&(node, declaration)) = names.get(name) else {
            let remedy = match nearest(name, names.keys().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "add the node, or correct the name".into(),
            };
            self.error(
                place,
                format!("a reference to \"{}\", which is no node", shorten(name)),
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

    fn knob(&mut self, knob: &Knob, value: Option<&'a Spanned>, place: Place<'_>) -> Setting {
        let Some(value) = value else {
            return match knob.default {
                None => {
                    let remedy = format!("set it: {}", knob.help);
                    self.error(place, format!("no \"{}\"", knob.name), expected(&knob.takes), remedy);
                    Setting::Unset
                }
                Some(Default::Number(number)) => Setting::Numeric(Animated::constant(vec![number])),
                Some(Default::Bool(value)) => Setting::Bool(value),
                Some(Default::Text(text)) => Setting::Text(text.into()),
                Some(Default::Vector(values)) => Setting::Numeric(Animated::constant(values.to_vec())),
                Some(Default::Unset) => Setting::Unset,
            };
        };
        if !knob.animated && matches!(value.json, Json::Object(_)) {
            self.error(
                place,
                "a keyed value",
                expected(&knob.takes),
                "this knob cannot be keyed over frames: write one value",
            );
            return Setting::Unset;
        }
        let setting = match knob.takes {
            Takes::Number { min, max } => self
                .animated(value, place, |checker, value, place| Some(vec![checker.number(value, min, max, place)?]))
                .map(Setting::Numeric),
            Takes::Integer { min, max } => self
                .animated(value, place, |checker, value, place| {
                    let number = checker.number(value, min as f64, max as f64, place)?;
                    if number.fract() != 0.0 {
                        checker.error(place, value.brief(), "a whole number", format!("write {}", number.round()));
                        return None;
                    }
                    Some(vec![number])
                })
                .map(Setting::Numeric),
            Takes::Color => self.animated(value, place, Self::color).map(Setting::Numeric),
            Takes::Vector(n) => self
                .animated(value, place, |checker, value, place| checker.vector(value, n, n, place))
                .map(Setting::Numeric),
            Takes::Numbers { min, max } => self.vector(value, min, max, place).map(Setting::Numbers),
            Takes::Bool => match value.json {
                Json::Bool(value) => Some(Setting::Bool(value)),
                _ => self.mismatch(value, &knob.takes, place),
            },
            Takes::Choice(words) => match &value.json {
                Json::String(text) if words.contains(&text.as_str()) => Some(Setting::Text(text.clone())),
                Json::String(text) => {
                    let remedy = match nearest(text, words.iter().copied()) {
                        Some(near) => format!("did you mean \"{near}\"?"),
                        None => "choose one of them".into(),
                    };
                    self.error(place, value.brief(), expected(&knob.takes), remedy);
                    None
                }
                _ => self.mismatch(value, &knob.takes, place),
            },
            Takes::Text | Takes::Path => match &value.json {
                Json::String(text) if !text.is_empty() && !text.contains('\0') => Some(Setting::Text(text.clone())),
                _ => self.mismatch(value, &knob.takes, place),
            },
            Takes::Texts { max } => match &value.json {
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
        setting.unwrap_or(Setting::Unset)
    }

    fn mismatch<T>(&mut self, value: &Spanned, takes: &Takes, place: Place<'_>) -> Option<T> {
        self.error(place, value.brief(), expected(takes), "correct the value");
        None
    }

    fn number(&mut self, value: &Spanned, min: f64, max: f64, place: Place<'_>) -> Option<f64> {
        match value.json {
            Json::Number(n) if (min..=max).contains(&n) => Some(n),
            Json::Number(n) if !n.is_finite() => {
                self.error(place, "a number beyond the range of f64", "a finite number", "write a smaller number");
                None
            }
            Json::Number(n) => {
                let remedy = format!("the nearest legal value is {}", n.clamp(min, max));
                self.error(place, n, expected(&Takes::Number { min, max }), remedy);
                None
            }
            _ => {
                self.error(place, value.brief(), expected(&Takes::Number { min, max }), "write a number");
                None
            }
        }
    }

    fn vector(&mut self, value: &Spanned, min: usize, max: usize, place: Place<'_>) -> Option<Vec<f64>> {
        match &value.json {
            Json::Array(items) if (min..=max).contains(&items.len()) => {
                // The largest f32 bounds every number that reaches a kernel.
                let limit = f64::from(f32::MAX);
                items.iter().map(|item| self.number(item, -limit, limit, place.at(item.offset))).collect()
            }
            _ => {
                let expected = format!("a list of {}", count(min, max, "number"));
                self.error(place, value.brief(), expected, "write the numbers in brackets: [ … ]");
                None
            }
        }
    }

    /// A color as `"#rrggbb"` in sRGB or `[r, g, b]` in the working space, in the working space.
    fn color(&mut self, value: &Spanned, place: Place<'_>) -> Option<Vec<f64>> {
        match &value.json {
            Json::String(text) => match parse_hex(text) {
                Ok(color) => Some(self.space.from_linear_srgb(color.map(srgb_decode)).map(|v| v.max(0.0)).to_vec()),
                Err(error) => {
                    self.error(place, value.brief(), "a color", error);
                    None
                }
            },
            Json::Array(items) if items.len() == 3 => {
                items.iter().map(|item| self.number(item, 0.0, f64::from(f32::MAX), place.at(item.offset))).collect()
            }
            _ => {
                let expected = "a color: \"#rrggbb\" in sRGB, or [r, g, b] in the working space";
                self.error(place, value.brief(), expected, "write a color");
                None
            }
        }
    }

    /// A value, or `{"keys": [[frame, value], …], "interpolation": …}`.
    fn animated(
        &mut self,
        value: &'a Spanned,
        place: Place<'_>,
        mut read: impl FnMut(&mut Self, &'a Spanned, Place<'_>) -> Option<Vec<f64>>,
    ) -> Option<Animated> {
        if !matches!(value.json, Json::Object(_)) {
            return read(self, value, place).map(Animated::constant);
        }
        let entries = self.object(value, place, "a keyed value")?;
        let mut interpolation = Interpolation::default();
        let mut keys = None;
        for entry in entries {
            match (entry.key.as_str(), &entry.value.json) {
                ("keys", Json::Array(items)) if !items.is_empty() => {
                    let mut list = Vec::with_capacity(items.len());
                    for item in items {
                        let place = place.at(item.offset);
                        match &item.json {
                            Json::Array(pair) if pair.len() == 2 => {
                                let frame = self.number(&pair[0], -1e7, 1e7, place.at(pair[0].offset))?;
                                list.push((frame, read(self, &pair[1], place.at(pair[1].offset))?));
                            }
                            _ => {
                                self.error(place, item.brief(), "a key: [frame, value]", "write [frame, value]");
                                return None;
                            }
                        }
                    }
                    keys = Some(list);
                }
                ("interpolation", Json::String(name)) => match Interpolation::from_name(name) {
                    Some(known) => interpolation = known,
                    None => {
                        let expected = format!("one of {}", Interpolation::NAMES.join(", "));
                        self.error(place.at(entry.value.offset), entry.value.brief(), expected, "choose one of them");
                        return None;
                    }
                },
                ("keys" | "interpolation", _) => {
                    let expected = "\"keys\": [[frame, value], …], \"interpolation\": a word";
                    self.error(place.at(entry.value.offset), entry.value.brief(), expected, "correct the keyed value");
                    return None;
                }
                (key, _) => self.unknown_key(place.at(entry.offset), key, &["keys", "interpolation"]),
            }
        }
        let Some(keys) = keys else {
            self.error(place, "a keyed value without \"keys\"", "\"keys\": [[frame, value], …]", "add the keys");
            return None;
        };
        let animated = Animated::keyed(keys, interpolation);
        if animated.is_none() {
            self.error(place, "keys out of order", "frames that ascend, each once", "sort the keys by frame");
        }
        animated
    }
}

/// What a knob takes, in words.
pub fn expected(takes: &Takes) -> String {
    match takes {
        Takes::Number { min, max } => match (*min > -1e30, *max < 1e30) {
            (true, true) => format!("a number from {min} to {max}"),
            (true, false) => format!("a number, at least {min}"),
            (false, true) => format!("a number, at most {max}"),
            (false, false) => "a finite number".into(),
        },
        Takes::Integer { min, max } => format!("a whole number from {min} to {max}"),
        Takes::Bool => "true or false".into(),
        Takes::Choice(words) => format!("one of {}", words.join(", ")),
        Takes::Color => "a color: \"#rrggbb\" in sRGB, or [r, g, b] in the working space".into(),
        Takes::Vector(n) => format!("a list of {n} numbers"),
        Takes::Text => "a text".into(),
        Takes::Path => "a path relative to the document".into(),
        Takes::Numbers { min, max } => format!("a list of {}", count(*min, *max, "number")),
        Takes::Texts { max } => format!("a list of {}", count(1, *max, "text")),
    }
}

fn count(min: usize, max: usize, what: &str) -> String {
    let plural = if max == 1 || what == "Weights" { "" } else { "s" };
    if min == max {
        format!("{min} {what}{plural}")
    } else if max > 4096 {
        format!("at least {min} {what}{plural}")
    } else {
        format!("{min} to {max} {what}{plural}")
    }
}

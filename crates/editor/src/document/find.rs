//! What can be found in a document: nodes, knobs, colors, and texts for people.

use super::change::{spoken, style};
use super::color::{hex, is_color};
use super::edit::default_value;
use super::json::{Path, Step};
use super::sheet::Sheet;
use super::swatches::{Swatch, SwatchKey};
use serde_json::Value;
use trochoid::{Arity, Item, KnobDefault};

/// Place in a document that can be gone to.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// A node, by name.
    Node(String),
    /// A color of the palette, or of the places that use it.
    Color(SwatchKey),
    /// A knob, or a port with a constant; also a knob of the document.
    Knob(Path),
    /// The notes of a node, an output, or the document.
    Notes(Path),
    /// An output, by name.
    Output(String),
    /// A backdrop or a note in the graph, by key.
    Backdrop(String),
}

impl Target {
    /// Returns the word for what it is.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Node(_) => "Node",
            Self::Color(_) => "Color",
            Self::Knob(_) => "Knob",
            Self::Notes(_) => "Notes",
            Self::Output(_) => "Output",
            Self::Backdrop(_) => "Backdrop",
        }
    }

    /// Returns the order of kinds among equally good matches.
    fn order(&self) -> u8 {
        match self {
            Self::Node(_) => 0,
            Self::Color(_) => 1,
            Self::Knob(_) => 2,
            Self::Notes(_) | Self::Output(_) | Self::Backdrop(_) => 3,
        }
    }
}

/// Something that can be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Where it is.
    pub target: Target,
    /// Its name.
    pub name: String,
    /// Its type, value or text.
    pub detail: String,
    /// Its color, as sRGB values from 0 to 1.
    pub color: Option<[f32; 3]>,
    /// What it is found by, in lower case.
    own: Vec<String>,
    /// What only narrows a search down, in lower case: the node and its type.
    around: String,
}

impl Entry {
    fn new(target: Target, name: impl Into<String>, detail: impl Into<String>) -> Self {
        let (name, detail) = (name.into(), detail.into());
        let own = vec![name.to_lowercase(), detail.to_lowercase()];
        Self { target, name, detail, color: None, own, around: String::new() }
    }

    /// Returns how badly the words fit, in lower case, less being better; `None` if one of them is not found. At least
    /// one must be in what it is found by, or be a path such as `sky.weight`.
    fn cost(&self, words: &[String]) -> Option<u8> {
        let mut best = None;
        for word in words {
            let own = self.own.iter().filter_map(|text| place(text, word)).min();
            let around = self.around.contains(word.as_str());
            match own.or((around && word.contains('.')).then_some(ELSEWHERE)) {
                Some(cost) => best = Some(best.map_or(cost, |best: u8| best.min(cost))),
                None if around => {}
                None => return None,
            }
        }
        best
    }
}

/// Cost of a word that is found within another one.
const ELSEWHERE: u8 = 3;

/// Returns how badly a word fits a text: 0 if it is the text, up to [`ELSEWHERE`]; `None` if it is not in it.
fn place(text: &str, word: &str) -> Option<u8> {
    if text == word {
        return Some(0);
    }
    let begins = |at: usize| at == 0 || !text[..at].ends_with(char::is_alphanumeric);
    let cost = |(at, _): (usize, &str)| {
        if at == 0 {
            1
        } else if begins(at) {
            2
        } else {
            ELSEWHERE
        }
    };
    text.match_indices(word).map(cost).min()
}

/// Returns the indices of the entries that fit a text, best first: all, if it is empty.
pub fn matching(entries: &[Entry], text: &str) -> Vec<usize> {
    let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
    if words.is_empty() {
        return (0..entries.len()).collect();
    }
    let cost = |(index, entry): (usize, &Entry)| Some((entry.cost(&words)?, entry.target.order(), index));
    let mut found: Vec<(u8, u8, usize)> = entries.iter().enumerate().filter_map(cost).collect();
    found.sort_unstable();
    found.into_iter().map(|(_, _, index)| index).collect()
}

/// Returns everything that can be found in a document with these colors: nodes first.
pub fn entries(sheet: &Sheet, swatches: &[Swatch]) -> Vec<Entry> {
    let mut all: Vec<Entry> =
        sheet.nodes.iter().map(|node| Entry::new(Target::Node(node.name.clone()), &node.name, &node.ty)).collect();
    all.extend(swatches.iter().map(color));
    for node in &sheet.nodes {
        let path = Path::node(&node.name);
        let Some(body) = sheet.get(&path) else { continue };
        let around = format!("{} {}", node.name, node.ty).to_lowercase();
        match node.declaration {
            Some(declaration) => gather(declaration.items, Some(body), &path, &around, &mut all),
            None => gather_unknown(sheet, body, &path, &around, &mut all),
        }
    }
    for (name, body) in object(&sheet.value, "knobs") {
        let value = body.get("value").unwrap_or(body);
        all.push(knob(Path::default().to("knobs").to(name), value, "", ""));
    }
    notes(&mut all, Path::default(), &sheet.value, "the document");
    for node in &sheet.nodes {
        let path = Path::node(&node.name);
        sheet.get(&path).into_iter().for_each(|body| notes(&mut all, path.clone(), body, &node.name));
    }
    for (name, body) in object(&sheet.value, "outputs") {
        let file = body.get("file").and_then(Value::as_str).unwrap_or_default();
        all.push(Entry::new(Target::Output(name.clone()), name, file));
        notes(&mut all, super::output::path(name), body, name);
    }
    for (name, body) in &sheet.backdrops {
        let title = body.text.lines().next().unwrap_or_default();
        let rest = body.text.lines().skip(1).collect::<Vec<_>>().join(" ");
        all.push(Entry::new(Target::Backdrop(name.clone()), title, rest));
    }
    all
}

fn object<'v>(value: &'v Value, key: &str) -> impl Iterator<Item = (&'v String, &'v Value)> {
    value.get(key).and_then(Value::as_object).into_iter().flatten()
}

fn color(swatch: &Swatch) -> Entry {
    let text = swatch.color.map(hex).unwrap_or_default();
    let (name, detail) = match &swatch.key {
        SwatchKey::Named(name) => (name.clone(), text),
        SwatchKey::Literal(place) => (text, place.clone()),
    };
    let mut entry = Entry { color: swatch.color, ..Entry::new(Target::Color(swatch.key.clone()), name, detail) };
    // The knob that holds it is found by its place.
    if matches!(swatch.key, SwatchKey::Literal(_)) {
        entry.around = entry.own.pop().unwrap_or_default();
    }
    entry
}

/// Returns the entry of a knob with a value. `remark` follows the value.
fn knob(path: Path, value: &Value, around: &str, remark: &str) -> Entry {
    let written = value.as_str().map_or_else(|| style(value), String::from);
    let name = path.0.iter().rev().find_map(|step| match step {
        Step::Key(key) => Some(key.clone()),
        Step::Index(_) => None,
    });
    let name = name.unwrap_or_default().to_lowercase();
    let title = spoken(&path);
    let around = format!("{} {around}", title.to_lowercase());
    let mut own = vec![name.replace('_', " "), name];
    // A default is no value that the document has.
    if remark.is_empty() {
        own.push(written.to_lowercase());
    }
    let detail = format!("{written}{remark}");
    Entry { target: Target::Knob(path), name: title, detail, color: None, own, around }
}

/// Collects the knobs of some items, and their ports with constants.
fn gather(items: &[Item], body: Option<&Value>, at: &Path, around: &str, all: &mut Vec<Entry>) {
    for item in items {
        let (value, path) = (body.and_then(|body| body.get(item.name())), at.to(item.name()));
        match (item, value) {
            (Item::Knob(_), Some(value)) => all.push(knob(path, value, around, "")),
            (Item::Knob(known), None) if !matches!(known.default, None | Some(KnobDefault::Unset)) => {
                all.push(knob(path, &default_value(known), around, " by default"));
            }
            (Item::Port(port), Some(Value::Array(elements))) if matches!(port.arity, Arity::Many { .. }) => {
                let constants = elements.iter().enumerate().filter(|(_, element)| is_constant(element));
                all.extend(constants.map(|(index, element)| knob(path.to(index), element, around, "")));
            }
            (Item::Port(_), Some(value)) if is_constant(value) => all.push(knob(path, value, around, "")),
            (Item::List(list), Some(Value::Array(records))) => {
                for (index, record) in records.iter().enumerate() {
                    gather(list.items, Some(record), &path.to(index), around, all);
                }
            }
            _ => {}
        }
    }
}

/// Returns whether the value of a port is a constant or a link, and no node.
fn is_constant(value: &Value) -> bool {
    value.as_str().is_none_or(|text| is_color(text) || super::link::is_link(text))
}

/// Collects what is set in a node of an unknown type, except connections.
fn gather_unknown(sheet: &Sheet, body: &Value, at: &Path, around: &str, all: &mut Vec<Entry>) {
    let own = body.as_object().into_iter().flatten();
    let own = own.filter(|(key, _)| !["type", "disabled", "notes", "ui"].contains(&key.as_str()));
    let is_wired = |value: &Value| value.as_str().is_some_and(|text| sheet.source(text).is_some());
    all.extend(own.filter(|(_, value)| !is_wired(value)).map(|(key, value)| knob(at.to(key), value, around, "")));
}

fn notes(all: &mut Vec<Entry>, path: Path, body: &Value, of: &str) {
    let text = body.get("notes").and_then(Value::as_str).unwrap_or_default();
    if !text.is_empty() {
        let mut entry = Entry::new(Target::Notes(path), of, text.split_whitespace().collect::<Vec<_>>().join(" "));
        entry.around = entry.own.remove(0);
        all.push(entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;

    const STORM: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 }, "working_space": "srgb",
  "notes": "Painted after a print.",
  "palette": { "deep_water": "#14262e" },
  "knobs": { "strength": { "value": 0.75 } },
  "nodes": {
    "down": { "type": "ScreenY", "notes": "0 at the horizon" },
    "grain": { "type": "Noise", "octaves": 6 },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.625, "color": "palette.deep_water" } ] },
    "dusk": { "type": "Mix", "a": "sky", "b": "#2d3f52", "weight": "= knobs.strength" }
  },
  "outputs": { "beauty": { "color": "dusk", "file": "stills/beauty.png" } },
  "ui": { "backdrops": { "b1": { "at": [0, 0], "size": [9, 9], "text": "Far away\nThe last boats", "tint": 0 } } }
}"##;

    fn found(text: &str) -> Vec<String> {
        let session = Session::new(STORM.into(), None);
        assert!(session.meaning().graph.is_some(), "{:?}", session.meaning().diagnostics);
        let swatches = super::super::swatches::swatches(session.sheet(), None, 1);
        let all = entries(session.sheet(), &swatches);
        let told = |index: usize| format!("{} {}, {}", all[index].target.kind(), all[index].name, all[index].detail);
        matching(&all, text).into_iter().map(told).collect()
    }

    #[test]
    fn nodes_are_found_by_name_and_type() {
        assert_eq!(found("dusk")[0], "Node dusk, Mix");
        assert_eq!(found("MIX")[0], "Node dusk, Mix");
        assert_eq!(found("ram")[0], "Node sky, Ramp", "before what has it within");
        assert!(!found("dusk").iter().any(|told| told.starts_with("Knob")), "knobs are not found by their node");
    }

    #[test]
    fn knobs_are_found_by_name_and_value_and_narrowed_down_by_their_node() {
        assert_eq!(found("octaves"), ["Knob grain.octaves, 6"]);
        assert_eq!(found("6")[0], "Knob grain.octaves, 6", "the value itself comes before parts of others");
        assert_eq!(found("0.625"), ["Knob sky.stops[1].at, 0.625"]);
        assert_eq!(found("dusk weight"), ["Knob dusk.weight, = knobs.strength"]);
        assert_eq!(found("dusk.weight"), ["Knob dusk.weight, = knobs.strength"]);
        assert!(found("weight").contains(&"Knob dusk.weight, = knobs.strength".to_string()));
        assert!(!found("weight").iter().any(|told| told.starts_with("Knob sky.weight")), "that one is connected");
        assert_eq!(found("strength")[0], "Knob knobs.strength, 0.75");
        // What is not set is found by its name alone.
        assert!(found("gain").iter().any(|told| told == "Knob grain.gain, 0.5 by default"), "{:?}", found("gain"));
        assert!(!found("0.5").iter().any(|told| told.contains("gain")));
    }

    #[test]
    fn colors_are_found_by_name_and_hex() {
        assert_eq!(found("deep")[0], "Color deep_water, #14262e");
        assert_eq!(found("#14262e")[0], "Color deep_water, #14262e");
        let all = found("2d3f52");
        assert_eq!(
            all,
            ["Color #2d3f52, sky.stops[0].color", "Knob sky.stops[0].color, #2d3f52", "Knob dusk.b, #2d3f52"]
        );
    }

    #[test]
    fn texts_for_people_are_found_by_any_of_their_words() {
        assert_eq!(found("horizon"), ["Notes down, 0 at the horizon"]);
        assert_eq!(found("print"), ["Notes the document, Painted after a print."]);
        assert_eq!(found("boats"), ["Backdrop Far away, The last boats"]);
        assert_eq!(found("stills"), ["Output beauty, stills/beauty.png"]);
        assert!(found("no such thing").is_empty());
    }
}

//! Presets: knobs of a node type that the user keeps under a name. Each is a file in the folder for the program's data,
//! `presets/TYPE/NAME.json`, which can be given to others.

use crate::document::change::style;
use crate::document::color::{hex, is_color, is_name};
use crate::document::edit::default_value;
use crate::document::{Edit, Node, Op, Path, Sheet, link};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path as File, PathBuf};
use trochoid::{Declaration, Item, KnobDefault};

/// Maximum size of a preset, in bytes.
const MOST_BYTES: u64 = 4 << 20;
/// Longest name, in letters.
const LONGEST: usize = 60;
/// Version of the files.
const VERSION: u64 = 1;

/// Why a preset cannot be kept or applied.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoPreset {
    #[error("{file}: found {found}; expected {expected}; {remedy}")]
    File { file: String, found: String, expected: String, remedy: String },
    #[error(transparent)]
    Unreadable(#[from] trochoid::io::Error),
    #[error("The preset cannot be kept: {0}")]
    Unwritten(#[from] trochoid::OutputError),
    #[error("The preset cannot be kept: {0}")]
    Folder(#[from] std::io::Error),
    #[error("Presets cannot be kept: there is no folder for the editor's data")]
    NoFolder,
}

/// Why a text cannot be the name of something that is kept.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub(crate) enum WrongName {
    #[error("Type a name")]
    Empty,
    #[error("Found {0:?}; expected a name without / \\ : * ? \" < > |")]
    Letter(char),
    #[error("Found a dot at the beginning; expected a letter or digit")]
    Dot,
    #[error("Found more than {LONGEST} letters; type a shorter name")]
    Long,
}

/// Returns why a text cannot be a name, which is also that of a file.
pub(crate) fn wrong_name(name: &str) -> Option<WrongName> {
    if name.is_empty() {
        return Some(WrongName::Empty);
    }
    let wrong = name.chars().find(|c| c.is_control() || "/\\:*?\"<>|".contains(*c));
    match wrong {
        Some(letter) => Some(WrongName::Letter(letter)),
        None if name.starts_with('.') => Some(WrongName::Dot),
        None => (name.chars().count() > LONGEST).then_some(WrongName::Long),
    }
}

/// The names of all presets, by the types of their nodes.
pub(crate) type Presets = BTreeMap<String, Vec<String>>;

fn folder(data: &File) -> PathBuf {
    data.join("presets")
}

/// Returns the file of a preset.
pub(crate) fn file(data: &File, ty: &str, name: &str) -> PathBuf {
    folder(data).join(ty).join(format!("{name}.json"))
}

/// Lists the presets in the folder for the program's data.
pub(crate) fn list(data: &File) -> Presets {
    let entries = |folder: &File| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut all = Presets::new();
    for place in entries(&folder(data)) {
        let Some(ty) = place.file_name().and_then(|name| name.to_str()) else { continue };
        let files = entries(&place).filter(|file| file.extension().is_some_and(|end| end == "json"));
        let names = files.filter_map(|file| Some(file.file_stem()?.to_str()?.to_string()));
        let mut names: Vec<String> = names.collect();
        names.sort();
        if !names.is_empty() {
            all.insert(ty.into(), names);
        }
    }
    all
}

/// Returns the values of all knobs of a node, and the names of those that cannot be kept, because they follow other nodes.
/// Colors of the palette become what they are here.
pub(crate) fn knobs(sheet: &Sheet, node: &Node) -> (Map<String, Value>, Vec<String>) {
    let body = sheet.get(&Path::node(&node.name));
    let (mut kept, mut left_out) = (Map::new(), Vec::new());
    for item in node.declaration.map_or(&[][..], |known| known.items) {
        let set = body.and_then(|body| body.get(item.name()));
        let value = match (item, set) {
            (Item::Port(_), _) => continue,
            (Item::Knob(_), Some(value)) => value.clone(),
            // What is not set now is not set by the preset either.
            (Item::Knob(knob), None) if matches!(knob.default, Some(KnobDefault::Unset)) => Value::Null,
            (Item::Knob(knob), None) => default_value(knob),
            (Item::List(_), value) => value.cloned().unwrap_or_else(|| json!([])),
        };
        match item {
            Item::List(list) if has_wires(list.items, &value) => left_out.push(item.name().to_string()),
            _ => match resolved(sheet, value) {
                Some(value) => drop(kept.insert(item.name().into(), value)),
                None => left_out.push(item.name().to_string()),
            },
        }
    }
    (kept, left_out)
}

/// Returns whether records are connected to nodes.
fn has_wires(items: &[Item], records: &Value) -> bool {
    let is_wire = |value: &Value| match value {
        Value::String(text) => !is_color(text) && !link::is_link(text),
        Value::Array(elements) => elements.iter().any(Value::is_string),
        _ => false,
    };
    records.as_array().into_iter().flatten().any(|record| {
        items.iter().any(|item| match (item, record.get(item.name())) {
            (Item::Port(_), Some(value)) => is_wire(value),
            (Item::List(list), Some(records)) => has_wires(list.items, records),
            _ => false,
        })
    })
}

/// Returns a value that means the same in another document; `None` if it follows other nodes.
fn resolved(sheet: &Sheet, mut value: Value) -> Option<Value> {
    match &mut value {
        Value::String(text) if is_name(text) => return sheet.named(text).map(|color| hex(color).into()),
        Value::String(text) if link::is_link(text) && !link::nodes(text).is_empty() => return None,
        Value::Array(items) => {
            for item in items {
                *item = resolved(sheet, item.take())?;
            }
        }
        Value::Object(entries) => {
            for (_, entry) in entries.iter_mut() {
                *entry = resolved(sheet, entry.take())?;
            }
        }
        _ => {}
    }
    Some(value)
}

/// Keeps a preset, in the place of another one of this type and name.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn keep(data: &File, ty: &str, name: &str, knobs: &Map<String, Value>) -> Result<(), NoPreset> {
    let file = file(data, ty, name);
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let whole = json!({ "trochoid_preset": VERSION, "type": ty, "knobs": knobs });
    let text = serde_json::to_string_pretty(&whole).unwrap_or_default();
    Ok(trochoid::write_whole(&file, format!("{text}\n").as_bytes())?)
}

/// Reads the knobs of a preset.
///
/// # Errors
/// The file cannot be read, is no preset of this type, or has knobs that the type does not have.
pub(crate) fn read(data: &File, known: &Declaration, name: &str) -> Result<Map<String, Value>, NoPreset> {
    let file = file(data, known.name, name);
    let text = trochoid::io::read_text(&file, MOST_BYTES)?;
    let fault = |found: String, expected: String, remedy: &str| NoPreset::File {
        file: file.display().to_string(),
        found,
        expected,
        remedy: remedy.into(),
    };
    let again = "correct the file, or delete the preset and save it anew";
    let mut whole: Value =
        serde_json::from_str(&text).map_err(|why| fault(why.to_string(), "a preset as JSON".into(), again))?;
    if whole.get("trochoid_preset").and_then(Value::as_u64) != Some(VERSION) {
        let found = whole.get("trochoid_preset").map_or("no \"trochoid_preset\"".into(), style);
        return Err(fault(found, format!("\"trochoid_preset\": {VERSION}"), again));
    }
    let ty = whole.get("type").and_then(Value::as_str).unwrap_or_default();
    if ty != known.name {
        return Err(fault(format!("the type \"{ty}\""), format!("\"{}\"", known.name), again));
    }
    let Some(Value::Object(knobs)) = whole.get_mut("knobs").map(Value::take) else {
        return Err(fault("no \"knobs\"".into(), "the knobs and their values".into(), again));
    };
    let is_known = |name: &str| known.items.iter().any(|item| !matches!(item, Item::Port(_)) && item.name() == name);
    if let Some(name) = knobs.keys().find(|name| !is_known(name)) {
        let (found, expected) = (format!("the knob \"{name}\""), format!("a knob that {} has", known.name));
        return Err(fault(found, expected, "remove it from the file, or save the preset anew"));
    }
    Ok(knobs)
}

/// Returns the edit that gives nodes of a type the knobs of a preset. A knob with its default is not written.
pub(crate) fn applied(sheet: &Sheet, nodes: &[&Node], name: &str, knobs: &Map<String, Value>) -> Edit {
    let (mut ops, mut removed) = (Vec::new(), Vec::new());
    for node in nodes {
        let path = Path::node(&node.name);
        for item in node.declaration.map_or(&[][..], |known| known.items) {
            let Some(value) = knobs.get(item.name()) else { continue };
            let place = path.to(item.name());
            let is_default = match item {
                Item::Knob(knob) if knob.default.is_some() => value.is_null() || is_equal(value, &default_value(knob)),
                Item::List(list) => list.min == 0 && value.as_array().is_some_and(Vec::is_empty),
                _ => false,
            };
            match sheet.get(&place) {
                Some(old) if is_equal(old, value) => {}
                Some(_) if is_default => removed.push(Op::Remove(place)),
                None if is_default => {}
                _ => ops.push(Op::Set(place, style(value))),
            }
        }
    }
    ops.append(&mut removed);
    Edit::new(format!("Apply {name}"), ops)
}

/// Returns whether values are the same however their numbers are written.
fn is_equal(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_equal(a, b)),
        (a, b) => a == b,
    }
}

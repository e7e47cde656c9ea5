//! Knobs of the document, which links in it follow by `= knobs.NAME`.

use super::knobs::{relinked, unlinked};
use super::make::free;
use super::{NoGroup, link};
use crate::document::change::{Edit, spoken, style};
use crate::document::json::{Op, Path, quoted};
use crate::document::sheet::Sheet;
use serde_json::{Map, Value};
use trochoid::Knob;

/// Returns the path of a knob of the document.
pub fn document_knob(name: &str) -> Path {
    Path::default().to("knobs").to(name)
}

/// Returns the value of a knob of the document, and its path.
pub fn document_value<'s>(sheet: &'s Sheet, name: &str) -> Option<(Path, &'s Value)> {
    let path = document_knob(name);
    let written = sheet.get(&path)?;
    match written.get("value") {
        Some(value) => Some((path.to("value"), value)),
        None => Some((path, written)),
    }
}

/// Adds a knob; also returns its name.
pub fn added_knob(sheet: &Sheet) -> (Edit, String) {
    let name = free("knob", |name| sheet.get(&document_knob(name)).is_some());
    let text = "{ \"value\": 0, \"min\": 0, \"max\": 1 }".to_string();
    (Edit::new("Add a knob of the document", vec![Op::Set(document_knob(&name), text)]), name)
}

/// Renames a knob, and the links to it.
pub fn renamed_document_knob(sheet: &Sheet, from: &str, to: &str) -> Edit {
    let mut ops = Vec::new();
    for key in ["nodes", "knobs"] {
        relinked(sheet, &Path::default().to(key), ("knobs", Some(from)), ("knobs", to), &mut ops);
    }
    ops.push(Op::Rename(document_knob(from), to.into()));
    Edit::new(format!("Rename knob {from} to {to}"), ops)
}

/// Changes what is said about a knob beside its value: its range, unit or help.
pub fn described(sheet: &Sheet, name: &str, key: &str, told: Option<&Value>) -> Edit {
    let path = document_knob(name);
    let ops = match (sheet.get(&path), told) {
        (Some(Value::Object(entries)), None) if entries.contains_key(key) => vec![Op::Remove(path.to(key))],
        (Some(Value::Object(entries)), Some(told)) if entries.contains_key("value") => {
            vec![Op::Set(path.to(key), style(told))]
        }
        (Some(value), Some(told)) => {
            let mut whole = Map::new();
            whole.insert("value".into(), value.clone());
            whole.insert(key.into(), told.clone());
            vec![Op::Set(path, style(&Value::Object(whole)))]
        }
        _ => Vec::new(),
    };
    Edit::new(format!("Set the {key} of the knob {name}"), ops).merging(format!("knobs.{name}.{key}"))
}

/// Returns the places whose links follow a knob of the document.
fn followers(sheet: &Sheet, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    for key in ["nodes", "knobs"] {
        let at = Path::default().to(key);
        for (place, text) in sheet.get(&at).map(|value| crate::document::link::links(value, &at)).unwrap_or_default() {
            if link::names(text).iter().any(|(_, node, knob)| (*node, *knob) == ("knobs", name)) {
                found.push(spoken(&place));
            }
        }
    }
    found
}

/// Deletes a knob.
///
/// # Errors
/// Something follows it.
pub fn deleted_knob(sheet: &Sheet, name: &str) -> Result<Edit, NoGroup> {
    let followers = followers(sheet, name);
    match followers.is_empty() {
        true => Ok(Edit::new(format!("Delete knob {name}"), vec![Op::Remove(document_knob(name))])),
        false => Err(NoGroup::Followed(name.into(), followers.join(", "))),
    }
}

/// Makes the value of a knob or port of a node a knob of the document, to which it is linked. Returns the edit and the name.
///
/// # Errors
/// The place is no knob of a node, or its value is a link.
pub fn promoted_to_document(sheet: &Sheet, place: &Path, declared: Option<&Knob>) -> Result<(Edit, String), NoGroup> {
    let (node, item, value) = unlinked(sheet, place, declared)?;
    let is_taken = |name: &str| sheet.get(&document_knob(name)).is_some();
    let wanted = if is_taken(item) { format!("{node}_{item}") } else { item.into() };
    let name = free(&wanted, is_taken);
    let mut definition = Map::new();
    definition.insert("value".into(), value);
    for (key, text) in declared.into_iter().flat_map(|knob| [("unit", knob.unit), ("help", knob.help)]) {
        if !text.is_empty() {
            definition.insert(key.into(), text.into());
        }
    }
    let ops = vec![
        Op::Set(document_knob(&name), style(&Value::Object(definition))),
        Op::Set(place.clone(), quoted(&format!("= knobs.{name}"))),
    ];
    Ok((Edit::new(format!("Make {node}.{item} a knob of the document"), ops), name))
}

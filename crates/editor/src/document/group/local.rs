//! Groups of included files, copied into the document.

use super::NoGroup;
use super::library::{Library, joined};
use super::{link, unpack};
use crate::document::change::{Edit, style};
use crate::document::json::{Op, Path, quoted};
use crate::document::sheet::Sheet;
use serde_json::Value;
use std::collections::BTreeSet;
use trochoid::{Item, KnobType};

/// Copies a group of an included file into the document, under a name of its own, and lets all uses in the document use the
/// copy. Returns the edit and the name of the copy.
///
/// # Errors
/// The group is part of the document already.
pub fn made_local(root: &Sheet, name: &str) -> Result<(Edit, String), NoGroup> {
    let library = &root.library;
    let group = library.group(name).ok_or_else(|| NoGroup::NoUse(name.into()))?;
    let Some(file) = &group.file else { return Err(NoGroup::Local(name.into())) };
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let text = copied(library, name, folder).ok_or_else(|| NoGroup::NoUse(name.into()))?;
    let copy = library.free_name(name);
    let mut ops = vec![Op::Set(Path::default().to("groups").to(&copy), text)];
    for place in uses(root, name) {
        ops.push(Op::Set(place.to("type"), quoted(&copy)));
    }
    Ok((Edit::new(format!("Make {name} local"), ops), copy))
}

/// Returns the text of a group of another document, in whose folder its files are, for one that names that folder so.
pub fn copied(library: &Library, name: &str, folder: &str) -> Option<String> {
    let mut body = library.group(name)?.body.clone();
    if let Some(Value::Object(nodes)) = body.get_mut("nodes") {
        for node in nodes.values_mut() {
            let items = library.declaration(node).map_or(&[][..], |known| known.items);
            unpack::relocated(items, node, folder);
        }
    }
    for knob in paths(library, name) {
        let Some(knob) = body.get_mut("knobs").and_then(|knobs| knobs.get_mut(knob)) else { continue };
        let place = if knob.is_object() { knob.get_mut("default") } else { Some(knob) };
        if let Some(Value::String(path)) = place
            && !path.is_empty()
            && !link::is_link(path)
        {
            *path = joined(folder, path);
        }
    }
    Some(written(&body))
}

/// Returns the knobs of a group that are names of files.
fn paths(library: &Library, name: &str) -> BTreeSet<&'static str> {
    let items = library.face(name).map_or(&[][..], |face| face.items).iter();
    let paths = items.filter_map(|item| match item {
        Item::Knob(knob) if matches!(knob.takes, KnobType::Path) => Some(knob.name),
        _ => None,
    });
    paths.collect()
}

/// Returns the paths of all nodes that use a group, in the document itself.
pub(super) fn uses(root: &Sheet, name: &str) -> Vec<Path> {
    let is_use = |body: &Value| body.get("type").and_then(Value::as_str) == Some(name);
    let nodes = |value: &Value, at: &Path| -> Vec<Path> {
        let nodes = value.get("nodes").and_then(Value::as_object).into_iter().flatten();
        nodes.filter(|(_, body)| is_use(body)).map(|(node, _)| at.to("nodes").to(node)).collect()
    };
    let mut found = nodes(&root.value, &Path::default());
    for (group, body) in root.value.get("groups").and_then(Value::as_object).into_iter().flatten() {
        found.extend(nodes(body, &Path::default().to("groups").to(group)));
    }
    found
}

/// Returns the text of a definition, with a line for each node.
fn written(body: &Value) -> String {
    let Some(entries) = body.as_object() else { return style(body) };
    let part = |(key, value): (&String, &Value)| match value {
        Value::Object(inner) if matches!(key.as_str(), "nodes" | "knobs" | "inputs") && !inner.is_empty() => {
            let lines: Vec<String> =
                inner.iter().map(|(name, value)| format!("{}: {}", quoted(name), style(value))).collect();
            format!("{}: {{\n        {}\n      }}", quoted(key), lines.join(",\n        "))
        }
        value => format!("{}: {}", quoted(key), style(value)),
    };
    let parts: Vec<String> = entries.iter().map(part).collect();
    format!("{{\n      {}\n    }}", parts.join(",\n      "))
}

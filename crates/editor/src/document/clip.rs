//! Nodes as clipboard text: JSON with their positions, readable even after a chat program has reformatted it.

use super::change::style;
use super::color::is_color;
use super::json::{Path, quoted};
use super::link::is_link;
use super::sheet::{Node, Point, Sheet, point};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};

/// Nodes read from clipboard text.
pub struct Clip {
    /// Node bodies by name, in the order of their document.
    pub nodes: Map<String, Value>,
    /// Upper left corners.
    pub positions: BTreeMap<String, Point>,
}

impl Clip {
    /// Returns the upper left corner of the bounding box.
    pub fn corner(&self) -> Point {
        let least = |axis: usize| self.positions.values().map(|at| at[axis]).fold(f32::INFINITY, f32::min);
        if self.positions.is_empty() { [0.0, 0.0] } else { [least(0), least(1)] }
    }
}

/// Reads clipboard text, tolerating code fences or quotes around it; returns `None` if it holds no nodes.
pub fn read(text: &str) -> Option<Clip> {
    let start = text.find('{')?;
    let end = text.rfind('}')?;
    let value: Value = serde_json::from_str(text.get(start..=end)?).ok()?;
    // Accepts a document or a bare map of nodes.
    let nodes = value.get("nodes").unwrap_or(&value).as_object()?.clone();
    if nodes.is_empty() || !nodes.values().all(|node| node.get("type").is_some_and(Value::is_string)) {
        return None;
    }
    let places = value.get("ui").and_then(|ui| ui.get("positions")).and_then(Value::as_object);
    let positions = places.into_iter().flatten().filter_map(|(name, at)| Some((name.clone(), point(Some(at))?)));
    Some(Clip { positions: positions.filter(|(name, _)| nodes.contains_key(name)).collect(), nodes })
}

/// Writes nodes as clipboard text.
pub fn write(sheet: &Sheet, nodes: &HashMap<&str, &Node>) -> String {
    let mut lines = Vec::new();
    let mut places = Vec::new();
    for node in sheet.nodes.iter().filter(|node| nodes.contains_key(node.name.as_str())) {
        let body = sheet.get(&Path::node(&node.name)).cloned().unwrap_or_default();
        lines.push(format!("    {}: {}", quoted(&node.name), style(&body)));
        places.push(format!("{}: [{:.0}, {:.0}]", quoted(&node.name), node.at[0], node.at[1]));
    }
    format!(
        "{{\n  \"trochoid\": 1,\n  \"nodes\": {{\n{}\n  }},\n  \"ui\": {{ \"positions\": {{ {} }} }}\n}}\n",
        lines.join(",\n"),
        places.join(", ")
    )
}

/// Renames the nodes that a node refers to; references that `to` does not know are removed.
pub fn redirect(items: &[trochoid::Item], body: &mut Value, to: &dyn Fn(&str) -> Option<String>) {
    let Some(entries) = body.as_object_mut() else { return };
    for item in items {
        match item {
            trochoid::Item::Knob(_) => {}
            trochoid::Item::Port(port) => {
                let Some(value) = entries.get_mut(port.name) else { continue };
                let leads = match value {
                    Value::Array(elements) if matches!(port.arity, trochoid::Arity::Many { .. }) => {
                        elements.retain_mut(|element| renamed(element, to));
                        true
                    }
                    value => renamed(value, to),
                };
                if !leads {
                    entries.remove(port.name);
                }
            }
            trochoid::Item::List(list) => {
                if let Some(Value::Array(records)) = entries.get_mut(list.name) {
                    records.iter_mut().for_each(|record| redirect(list.items, record, to));
                }
            }
        }
    }
}

/// Renames a reference; returns whether it still refers to a node.
fn renamed(value: &mut Value, to: &dyn Fn(&str) -> Option<String>) -> bool {
    let Value::String(text) = value else { return true };
    if is_color(text) || is_link(text) {
        return true;
    }
    let (node, output) = text.split_once('.').map_or((text.as_str(), None), |(node, output)| (node, Some(output)));
    let Some(new) = to(node) else { return false };
    *text = output.map_or(new.clone(), |output| format!("{new}.{output}"));
    true
}

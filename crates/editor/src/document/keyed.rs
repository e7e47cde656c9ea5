//! The keyed values of a document.

use super::curve::Curve;
use super::json::{Path, Step};
use super::sheet::Sheet;
use serde_json::Value;
use std::collections::BTreeSet;

/// A keyed value, where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Place in the document.
    pub path: Path,
    /// What it belongs to: a node, `palette` or `knobs`.
    pub owner: String,
    /// Its name there.
    pub name: String,
    /// Its keys.
    pub curve: Curve,
}

/// Returns the keyed values of the selected nodes; if nothing is selected, of all nodes, colors and knobs.
pub fn channels(sheet: &Sheet, selection: &BTreeSet<String>) -> Vec<Channel> {
    let mut found = Vec::new();
    for node in &sheet.nodes {
        if selection.is_empty() || selection.contains(&node.name) {
            let path = Path::node(&node.name);
            if let Some(body) = sheet.get(&path) {
                collect(body, &path, &node.name, 2, &mut found);
            }
        }
    }
    if selection.is_empty() && sheet.within.is_none() {
        for owner in ["palette", "knobs"] {
            let path = Path::default().to(owner);
            if let Some(body) = sheet.get(&path) {
                collect(body, &path, owner, 1, &mut found);
            }
        }
    }
    found
}

/// Returns the frames of the keys of channels, each once and in order.
pub fn frames(channels: &[Channel]) -> Vec<f64> {
    let mut frames: Vec<f64> = channels.iter().flat_map(|channel| &channel.curve.keys).map(|key| key.frame).collect();
    frames.sort_by(f64::total_cmp);
    frames.dedup();
    frames
}

/// Adds the keyed values within a value; their names begin after some steps of the path.
fn collect(value: &Value, path: &Path, owner: &str, steps: usize, found: &mut Vec<Channel>) {
    if let Some(curve) = Curve::read(value) {
        let name = Path(path.0[steps..].to_vec()).to_string();
        // The value of a knob of the document is called as the knob.
        let name = if owner == "knobs" { name.trim_end_matches(".value").into() } else { name };
        return found.push(Channel { path: path.clone(), owner: owner.into(), name, curve });
    }
    match value {
        Value::Object(entries) => {
            for (key, value) in entries.iter().filter(|(key, _)| !matches!(key.as_str(), "ui" | "notes")) {
                collect(value, &path.to(key), owner, steps, found);
            }
        }
        Value::Array(items) => {
            for (index, value) in items.iter().enumerate() {
                collect(value, &path.join(&[Step::Index(index)]), owner, steps, found);
            }
        }
        _ => {}
    }
}

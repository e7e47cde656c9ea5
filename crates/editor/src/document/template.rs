//! Scenes as templates: new documents that need no other document.

use super::change::Edit;
use super::json::{Misplaced, Op, Path, quoted, written};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Why a scene cannot be a template.
#[derive(Debug, thiserror::Error)]
pub enum NoTemplate {
    /// The scene, or a document that it includes, is not JSON.
    #[error("{name} is not JSON: {why}")]
    Json {
        /// The document.
        name: String,
        /// The fault.
        why: serde_json::Error,
    },
    /// It includes a document that is not at hand.
    #[error("the scene includes {0}, which is not part of this program")]
    Missing(String),
    /// It has no place for what would be written.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
}

/// Returns the text of a scene as a document of its own: the groups that it uses of others are part of it, as they are
/// written there. `library` returns the text of an included document.
///
/// # Errors
/// The scene or an included document cannot be read.
pub fn self_contained(scene: &str, library: impl Fn(&str) -> Option<&'static str>) -> Result<String, NoTemplate> {
    let value = read("the scene", scene)?;
    let includes = value.get("include").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let mut groups: BTreeMap<String, (&'static str, Value)> = BTreeMap::new();
    for path in includes.iter().filter_map(Value::as_str) {
        let text = library(path).ok_or_else(|| NoTemplate::Missing(path.into()))?;
        let included = read(path, text)?;
        for (name, body) in included.get("groups").and_then(Value::as_object).into_iter().flatten() {
            if let Some(written) = written(text, &Path::default().to("groups").to(name)) {
                groups.entry(name.clone()).or_insert((written, body.clone()));
            }
        }
    }
    let mut ops = Vec::new();
    if !includes.is_empty() {
        ops.push(Op::Remove(Path::default().to("include")));
    }
    for name in used(&value, &groups) {
        ops.push(Op::Set(Path::default().to("groups").to(&name), groups[&name].0.into()));
    }
    let text = Edit::new("Open a template", ops).applied(scene)?.0;
    with_own_outputs(&text)
}

/// Returns the text of a scene whose outputs are written beside the document, wherever that will be saved.
///
/// # Errors
/// The scene cannot be read.
pub fn with_own_outputs(scene: &str) -> Result<String, NoTemplate> {
    let value = read("the scene", scene)?;
    let mut ops = Vec::new();
    for (name, output) in value.get("outputs").and_then(Value::as_object).into_iter().flatten() {
        let file = output.get("file").and_then(Value::as_str).and_then(|file| file.rsplit_once('/'));
        if let Some((_, own)) = file {
            ops.push(Op::Set(Path::default().to("outputs").to(name).to("file"), quoted(own)));
        }
    }
    Ok(Edit::new("Open a template", ops).applied(scene)?.0)
}

fn read(name: &str, text: &str) -> Result<Value, NoTemplate> {
    serde_json::from_str(text).map_err(|why| NoTemplate::Json { name: name.into(), why })
}

/// Returns the groups that the nodes of a document use, and those that their nodes use.
fn used(document: &Value, groups: &BTreeMap<String, (&'static str, Value)>) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let own = document.get("groups").and_then(Value::as_object).into_iter().flatten().map(|(_, body)| body);
    let mut open: Vec<&Value> = std::iter::once(document).chain(own).collect();
    while let Some(body) = open.pop() {
        for (_, node) in body.get("nodes").and_then(Value::as_object).into_iter().flatten() {
            let ty = node.get("type").and_then(Value::as_str).unwrap_or_default();
            if let Some((_, group)) = groups.get(ty)
                && all.insert(ty.to_string())
            {
                open.push(group);
            }
        }
    }
    all
}

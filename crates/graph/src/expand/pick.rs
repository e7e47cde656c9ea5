//! References to one of several weights by its index: `parts.2` is a node of its own in the expanded document.

use super::Expander;
use super::scope::Scope;
use crate::Role;
use crate::spanned::{Entry, Json, Spanned};
use std::rc::Rc;

/// A picked weight: the reference to all of them, the index, and the first place that names it.
pub(super) struct Picked {
    weights: String,
    index: u32,
    offset: usize,
}

/// Returns the reference before an index, and the index, of a text that ends in one.
pub(super) fn split(text: &str) -> Option<(&str, u32)> {
    let (weights, index) = text.rsplit_once('.')?;
    let is_reference = weights.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && weights.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '/'));
    let is_index = !index.is_empty() && index.bytes().all(|byte| byte.is_ascii_digit());
    if is_reference && is_index { Some((weights, index.parse().ok()?)) } else { None }
}

/// Whether a value has such a text somewhere.
pub(super) fn has_any(value: &Spanned) -> bool {
    match &value.json {
        Json::String(text) => split(text).is_some(),
        Json::Array(items) => items.iter().any(has_any),
        Json::Object(entries) => entries.iter().any(|entry| has_any(&entry.value)),
        _ => false,
    }
}

impl<'d> Expander<'d> {
    /// Returns the reference to one of several weights.
    pub(super) fn pick(&mut self, scope: &Rc<Scope<'d>>, weights: &str, index: u32, offset: usize) -> Option<Spanned> {
        let found = self.reference(scope, weights, offset)?;
        let Json::String(weights) = &found.json else {
            let place = format!("weight {index} of {}", found.brief());
            self.error(offset, place, "weight of a node", "connect a node, or write the weight as a number");
            return None;
        };
        let name = format!("{weights}.{index}");
        self.picks.entry(name.clone()).or_insert_with(|| Picked { weights: weights.clone(), index, offset });
        Some(Spanned { offset, json: Json::String(name) })
    }

    /// Returns the nodes of all picked weights.
    pub(super) fn picked(&self) -> Vec<Entry> {
        let ty = self.registry.of_role(Role::Pick).map_or("", |ty| ty.declaration().name);
        let node = |(name, picked): (&String, &Picked)| {
            let offset = picked.offset;
            let item = |key: &str, json: Json| Entry { key: key.into(), offset, value: Spanned { offset, json } };
            let items = vec![
                item("type", Json::String(ty.into())),
                item("weights", Json::String(picked.weights.clone())),
                item("index", Json::Number(f64::from(picked.index))),
            ];
            Entry { key: name.clone(), offset, value: Spanned { offset, json: Json::Object(items) } }
        };
        self.picks.iter().map(node).collect()
    }
}

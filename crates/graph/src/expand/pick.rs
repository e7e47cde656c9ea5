//! References to one of several weights by its index or name: `parts.2` is a node of its own in the expanded document, and
//! so is `parts.light`, if the node names its weights.

use super::Expander;
use super::scope::Scope;
use crate::check::weight_names::{WEIGHT_NAMES, takes_weight_names, weight_names};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Role, nearest};
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

/// Whether some of these nodes name their weights.
pub(super) fn has_names(nodes: &[&Entry]) -> bool {
    nodes.iter().any(|node| match &node.value.json {
        Json::Object(items) => items.iter().any(|item| item.key == WEIGHT_NAMES),
        _ => false,
    })
}

/// What a text after a dot is.
pub(super) enum Name {
    /// A weight with this index.
    Weight(u32),
    /// A weight that the node does not have, which was reported.
    Unknown,
}

impl<'d> Expander<'d> {
    /// Returns which weight a name is; `None` if what is before it names no weights, or the name is that of an output.
    pub(super) fn named_weight(
        &mut self,
        scope: &Rc<Scope<'d>>,
        weights: &str,
        name: &str,
        offset: usize,
    ) -> Option<Name> {
        // Outputs of groups have names of their own.
        let used = scope.find(weights).and_then(|entry| self.used(entry));
        if used.is_some_and(|group| self.groups[group].outputs.iter().any(|(output, _)| *output == name)) {
            return None;
        }
        let before = self.faults.len();
        let found = self.reference(scope, weights, offset);
        // They are reported where the reference is read as a whole.
        self.faults.truncate(before);
        let Json::String(path) = found?.json else { return None };
        let entry = self.node_at(path.split('.').next()?)?;
        let names = weight_names(entry);
        let Json::Object(items) = &entry.value.json else { return None };
        let Json::String(ty) = &items.iter().find(|item| item.key == "type")?.value.json else { return None };
        let declaration = self.registry.get(ty)?.declaration();
        if names.is_empty()
            || !takes_weight_names(declaration)
            || declaration.outputs.iter().any(|output| output.name == name)
        {
            return None;
        }
        if let Some(index) = names.iter().position(|known| *known == name) {
            return Some(Name::Weight(u32::try_from(index).ok()?));
        }
        let remedy = match nearest(name, names.iter().copied()) {
            Some(near) => format!("did you mean \"{weights}.{near}\"?"),
            None => format!("its weights: {}", names.join(", ")),
        };
        let found = format!("a reference to weight \"{}\" of \"{}\"", shorten(name), shorten(weights));
        self.error(offset, found, "one of its weights", remedy);
        Some(Name::Unknown)
    }

    /// Returns the node with a path in the expanded document.
    fn node_at(&self, path: &str) -> Option<&'d Entry> {
        let (uses, name) = path.rsplit_once('/').map_or((None, path), |(uses, name)| (Some(uses), name));
        let mut nodes = self.top.clone();
        for used in uses.into_iter().flat_map(|uses| uses.split('/')) {
            let entry = nodes.iter().find(|node| node.key == used)?;
            nodes = self.groups[self.used(entry)?].nodes.clone();
        }
        nodes.into_iter().find(|node| node.key == name)
    }

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

//! Names of a node's weights, by which references pick one: `"names": ["shadow", "light"]`, then `parts.light`.

use super::is_legal_name;
use super::{Checker, Draft, FaultLocation};
use crate::spanned::{Entry, Json, shorten};
use crate::{Declaration, Kind};

/// Key of a node that names its weights.
pub(crate) const WEIGHT_NAMES: &str = "names";

/// Whether a type may have names of weights: its only output is what divides a picture.
pub(crate) fn takes_weight_names(declaration: &Declaration) -> bool {
    let is_item = declaration.items.iter().any(|item| item.name() == WEIGHT_NAMES);
    !is_item && matches!(declaration.outputs, [only] if matches!(only.kind, Kind::Weights(_)))
}

impl<'a> Checker<'a> {
    /// Checks the names of weights, one for each.
    pub(super) fn weight_names(&mut self, drafts: &[Draft<'a>], entries: &[&'a Entry]) {
        for (draft, entry) in drafts.iter().zip(entries) {
            let Some(declaration) = draft.ty.map(|ty| ty.declaration()) else { continue };
            let Json::Object(items) = &entry.value.json else { continue };
            let Some(item) = items.iter().find(|item| item.key == WEIGHT_NAMES) else { continue };
            if !takes_weight_names(declaration) {
                continue;
            }
            let place = FaultLocation { offset: item.value.offset, node: Some(draft.name), port: Some(WEIGHT_NAMES) };
            let count = match draft.kinds[..] {
                [Kind::Weights(count)] if !draft.disabled => Some(count),
                _ => None,
            };
            let expected = match count {
                Some(count) => format!("a list of {count} names, one for each weight"),
                None => "a list of names, one for each weight".into(),
            };
            let Json::Array(names) = &item.value.json else {
                self.error(place, item.value.brief(), expected, "write them in brackets: [\"shadow\", \"light\"]");
                continue;
            };
            let mut seen: Vec<&str> = Vec::new();
            for name in names {
                let place = place.at(name.offset);
                let Json::String(text) = &name.json else {
                    self.error(place, name.brief(), "the name of a weight", "write a name in quotes");
                    continue;
                };
                let is_output = declaration.outputs.iter().any(|output| output.name == text);
                if !is_legal_name(text) {
                    let found = format!("the name \"{}\"", shorten(text));
                    self.error(place, found, "a–z, A–Z, 0–9 and _, not starting with a digit", "rename the weight");
                } else if is_output {
                    let found = format!("the name \"{text}\", which is that of the output");
                    self.error(place, found, "a name of its own", "rename the weight");
                } else if seen.contains(&text.as_str()) {
                    self.error(place, format!("a second \"{text}\""), "each name once", "rename one of them");
                }
                seen.push(text);
            }
            if let Some(count) = count.filter(|count| *count != names.len()) {
                let remedy = if names.len() < count { "name all weights" } else { "remove what is too much" };
                self.error(place, format!("{} names", names.len()), expected, remedy);
            }
        }
    }
}

/// Returns the names of a node's weights, as far as they are text.
pub(crate) fn weight_names(entry: &Entry) -> Vec<&str> {
    let Json::Object(items) = &entry.value.json else { return Vec::new() };
    match items.iter().find(|item| item.key == WEIGHT_NAMES).map(|item| &item.value.json) {
        Some(Json::Array(names)) => {
            names.iter().map(|name| if let Json::String(text) = &name.json { text.as_str() } else { "" }).collect()
        }
        _ => Vec::new(),
    }
}

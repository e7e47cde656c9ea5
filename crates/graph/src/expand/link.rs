//! Links: values that are taken from other knobs.

use super::scope::Scope;
use super::{Expander, is_remark};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{Item, Knob, KnobDefault, nearest};
use std::rc::Rc;

/// Whether a text is a link, right or wrong.
pub(super) fn is_link(text: &str) -> bool {
    text.starts_with('=')
}

impl<'d> Expander<'d> {
    /// Returns a value with all links in it replaced; `None` if one of them is faulty.
    pub(super) fn linked(&mut self, value: &'d Spanned, scope: &Rc<Scope<'d>>) -> Option<Spanned> {
        let json = match &value.json {
            Json::String(text) if is_link(text) => return self.link(text, value.offset, scope),
            Json::Array(items) => {
                let list = items.iter().map(|item| self.linked(item, scope)).collect::<Option<Vec<_>>>()?;
                let has_link = items.iter().any(|item| matches!(&item.json, Json::String(text) if is_link(text)));
                let keyed = if has_link { self.keyed_list(&list, value.offset) } else { None };
                keyed.unwrap_or(Json::Array(list))
            }
            Json::Object(entries) => {
                let entry = |entry: &'d Entry| {
                    if is_remark(&entry.key) {
                        return Some(entry.clone());
                    }
                    let value = self.linked(&entry.value, scope)?;
                    Some(Entry { key: entry.key.clone(), offset: entry.offset, value })
                };
                Json::Object(entries.iter().map(entry).collect::<Option<_>>()?)
            }
            json => json.clone(),
        };
        Some(Spanned { offset: value.offset, json })
    }

    /// Returns the value of a link: `= knobs.NAME` and `= NODE.KNOB` as it is there, or a formula of such numbers.
    fn link(&mut self, text: &str, offset: usize, scope: &Rc<Scope<'d>>) -> Option<Spanned> {
        let formula = text.trim_start_matches('=').trim();
        match formula.split_once('.') {
            Some((node, knob)) if is_word(node) && is_word(knob) => self.value_of(scope, node, knob, offset),
            _ => self.formula(formula, offset, scope),
        }
    }

    /// Returns the value of a name with a dot: of a knob of the group or the document, or of a node's knob.
    pub(super) fn value_of(&mut self, scope: &Rc<Scope<'d>>, node: &str, knob: &str, offset: usize) -> Option<Spanned> {
        if node == "knobs" { self.knob(scope, knob, offset) } else { self.knob_of(scope, node, knob, offset) }
    }

    /// Returns the value of another node's knob, or its default.
    fn knob_of(&mut self, scope: &Rc<Scope<'d>>, node: &str, knob: &str, offset: usize) -> Option<Spanned> {
        let Some(entry) = scope.find(node) else {
            let near = nearest(node, scope.names().chain(["knobs"])).map(str::to_owned);
            let remedy =
                near.map_or("add the node, or correct the name".into(), |near| format!("did you mean \"{near}\"?"));
            self.error(
                offset,
                format!("a link to \"{}\", which is not a node", shorten(node)),
                "the name of a node",
                remedy,
            );
            return None;
        };
        if let Some(index) = self.used(entry) {
            let groups = self.groups.clone();
            let path = format!("{}{node}", scope.prefix);
            let inside = Rc::new(Scope::of_use(index, &groups[index], entry, &path, scope));
            return self.knob(&inside, knob, offset);
        }
        let Json::Object(items) = &entry.value.json else { return None };
        if let Some(item) = items.iter().find(|item| item.key == knob && !is_remark(knob)) {
            let name = format!("{node}.{knob}");
            return self.deeper(offset, (scope, &name), |expander| expander.linked(&item.value, scope));
        }
        let ty = items.iter().find(|item| item.key == "type").map(|item| &item.value.json);
        let ty = if let Some(Json::String(ty)) = ty { self.registry.get(ty) } else { None };
        let declared = ty.map_or(&[][..], |ty| ty.declaration().items);
        let knobs = || declared.iter().filter_map(|item| if let Item::Knob(knob) = item { Some(knob) } else { None });
        let Some(known) = knobs().find(|known| known.name == knob) else {
            let remedy = match nearest(knob, knobs().map(|known| known.name)) {
                Some(near) => format!("did you mean \"{node}.{near}\"?"),
                None => format!("knobs: {}", knobs().map(|known| known.name).collect::<Vec<_>>().join(", ")),
            };
            let found = format!("a link to \"{}\" of \"{}\"", shorten(knob), shorten(node));
            self.error(offset, found, "one of its knobs", remedy);
            return None;
        };
        let Some(json) = default_of(known) else {
            let found = format!("a link to \"{node}.{knob}\", which is not set and has no default");
            self.error(offset, found, "a knob with a value", format!("set \"{knob}\" of \"{node}\""));
            return None;
        };
        Some(Spanned { offset, json })
    }
}

/// Whether a text is a name.
pub(super) fn is_word(text: &str) -> bool {
    let is_start = |c: char| c.is_ascii_alphabetic() || c == '_';
    text.starts_with(is_start) && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Returns the default of a knob as it would be written.
fn default_of(knob: &Knob) -> Option<Json> {
    let number = |value: f64| Spanned { offset: 0, json: Json::Number(value) };
    match knob.default? {
        KnobDefault::Number(value) => Some(Json::Number(value)),
        KnobDefault::Bool(value) => Some(Json::Bool(value)),
        KnobDefault::Text(text) => Some(Json::String(text.into())),
        KnobDefault::Vector(values) => Some(Json::Array(values.iter().map(|value| number(*value)).collect())),
        KnobDefault::Unset => None,
    }
}

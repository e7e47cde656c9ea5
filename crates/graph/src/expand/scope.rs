//! What names stand for within a use of a group, or at the top of a document.

use super::group::Group;
use super::pick::Name;
use super::{DEPTH, Expander, is_color, link, pick};
use crate::nearest;
use crate::spanned::{Entry, Json, Spanned, shorten};
use std::collections::HashMap;
use std::rc::Rc;

/// Nodes that see each other: those of a document, or of one use of a group.
pub(super) struct Scope<'d> {
    /// What stands before their names in the expanded document.
    pub(super) prefix: String,
    nodes: HashMap<&'d str, &'d Entry>,
    /// The use, and the scope in which it is; `None` at the top.
    of: Option<Within<'d>>,
}

struct Within<'d> {
    group: usize,
    entry: &'d Entry,
    outside: Rc<Scope<'d>>,
}

impl<'d> Scope<'d> {
    pub(super) fn of_document(nodes: &[&'d Entry]) -> Self {
        Self { prefix: String::new(), nodes: nodes.iter().map(|node| (node.key.as_str(), *node)).collect(), of: None }
    }

    pub(super) fn of_use(index: usize, group: &Group<'d>, entry: &'d Entry, path: &str, outside: &Rc<Self>) -> Self {
        let nodes = group.nodes.iter().map(|node| (node.key.as_str(), *node)).collect();
        let of = Within { group: index, entry, outside: outside.clone() };
        Self { prefix: format!("{path}/"), nodes, of: Some(of) }
    }

    /// Returns the node with a name.
    pub(super) fn find(&self, name: &str) -> Option<&'d Entry> {
        self.nodes.get(name).copied()
    }

    /// Returns what the use sets for an item.
    pub(super) fn given(&self, item: &str) -> Option<&'d Spanned> {
        let Json::Object(items) = &self.of.as_ref()?.entry.value.json else { return None };
        items.iter().find(|entry| entry.key == item).map(|entry| &entry.value)
    }

    /// Whether the use is disabled.
    pub(super) fn is_disabled(&self) -> bool {
        self.given("disabled").is_some_and(|value| value.json == Json::Bool(true))
    }

    /// Returns the names of its nodes.
    pub(super) fn names(&self) -> impl Iterator<Item = &'d str> {
        self.nodes.keys().copied()
    }
}

impl<'d> Expander<'d> {
    /// Follows one reference or link more, to a name within a scope; reports a chain that does not end.
    pub(super) fn deeper<T>(
        &mut self,
        offset: usize,
        (scope, name): (&Scope<'d>, &str),
        follow: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<T> {
        let name = format!("{}{name}", scope.prefix);
        if let Some(first) = self.followed.iter().position(|known| *known == name) {
            let found = format!("a value that leads back to itself: {}", circle(&self.followed[first..]));
            self.error(offset, found, "a chain that ends", "give one of them a value of its own");
            return None;
        }
        if self.followed.len() >= DEPTH {
            let found = format!("more than {DEPTH} references or links, one leading to the next");
            self.error(offset, found, "a chain that ends", "name what is meant more directly");
            return None;
        }
        self.followed.push(name);
        let found = follow(self);
        self.followed.pop();
        found
    }

    /// Returns the value of a port in the expanded document; `None` if it stays open.
    pub(super) fn connected(&mut self, value: &'d Spanned, scope: &Rc<Scope<'d>>) -> Option<Spanned> {
        match &value.json {
            Json::String(text) if link::is_link(text) => self.linked(value, scope),
            Json::String(text) if is_color(text) => Some(value.clone()),
            Json::String(text) => self.reference(scope, text, value.offset),
            Json::Array(items) => {
                let mut flat = Vec::new();
                for item in items {
                    match (self.connected(item, scope), &item.json) {
                        // An input may have several connections.
                        (Some(Spanned { json: Json::Array(several), .. }), Json::String(_)) => flat.extend(several),
                        (found, _) => flat.extend(found),
                    }
                }
                Some(Spanned { offset: value.offset, json: Json::Array(flat) })
            }
            _ => self.linked(value, scope),
        }
    }

    /// Returns what a reference stands for in the expanded document: a reference, or a literal that an input has; `None`
    /// if it is an input that stays open.
    pub(super) fn reference(&mut self, scope: &Rc<Scope<'d>>, text: &str, offset: usize) -> Option<Spanned> {
        // A path leads into a use, as those who look at a node of a group write it: `left/bulb`.
        if let Some((name, rest)) = text.split_once('/')
            && let Some(entry) = scope.find(name)
            && let Some(index) = self.used(entry)
        {
            let groups = self.groups.clone();
            let path = format!("{}{name}", scope.prefix);
            let inside = Rc::new(Scope::of_use(index, &groups[index], entry, &path, scope));
            // Groups do not contain themselves, so paths are short.
            return self.reference(&inside, rest, offset);
        }
        if let Some((weights, index)) = pick::split(text) {
            return self.pick(scope, weights, index, offset);
        }
        if self.names_weights
            && let Some((weights, name)) = text.rsplit_once('.')
            && let Some(name) = self.named_weight(scope, weights, name, offset)
        {
            let Name::Weight(index) = name else { return None };
            return self.pick(scope, weights, index, offset);
        }
        let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
        let groups = self.groups.clone();
        if let Some(within) = &scope.of
            && groups[within.group].inputs.iter().any(|input| input.name == name)
        {
            return self.input(scope, name, output, offset);
        }
        let plain = |text: String| Some(Spanned { offset, json: Json::String(text) });
        let Some(entry) = scope.find(name) else {
            return plain(format!("{}{text}", scope.prefix));
        };
        let Some(index) = self.used(entry) else { return plain(format!("{}{text}", scope.prefix)) };
        let group = &groups[index];
        let path = format!("{}{name}", scope.prefix);
        let inside = Rc::new(Scope::of_use(index, group, entry, &path, scope));
        if inside.is_disabled() {
            let first = group.inputs.first()?.name;
            return self.deeper(offset, (scope, name), |expander| expander.input(&inside, first, None, offset));
        }
        let target = match output {
            None => group.outputs.first(),
            Some(output) => group.outputs.iter().find(|(known, _)| *known == output),
        };
        let Some((_, target)) = target else {
            let known: Vec<&str> = group.outputs.iter().map(|(name, _)| *name).collect();
            let output = output.unwrap_or_default();
            let remedy = match nearest(output, known.iter().copied()) {
                Some(near) => format!("did you mean \"{name}.{near}\"?"),
                None => format!("outputs of {}: {}", group.name, known.join(", ")),
            };
            let found = format!("a reference to output \"{}\" of the group {}", shorten(output), group.name);
            self.error(offset, found, "one of its outputs", remedy);
            return None;
        };
        let Json::String(target) = &target.json else { return None };
        self.deeper(offset, (scope, text), |expander| expander.reference(&inside, target, offset))
    }

    /// Returns what is connected to an input of a use, or an output of it.
    pub(super) fn input(
        &mut self,
        scope: &Rc<Scope<'d>>,
        name: &str,
        output: Option<&str>,
        offset: usize,
    ) -> Option<Spanned> {
        let within = scope.of.as_ref()?;
        let groups = self.groups.clone();
        let input = groups[within.group].inputs.iter().find(|input| input.name == name)?;
        let outside = within.outside.clone();
        let value = match (scope.given(name), input.default) {
            (Some(given), _) => {
                self.deeper(given.offset, (scope, name), |expander| expander.connected(given, &outside))?
            }
            // Defaults are literals.
            (None, Some(default)) => default.clone(),
            (None, None) => return None,
        };
        match (output, &value.json) {
            (None, _) => Some(value),
            (Some(output), Json::String(text)) if !is_color(text) && !text.contains('.') => {
                Some(Spanned { offset, json: Json::String(format!("{text}.{output}")) })
            }
            (Some(output), _) => {
                let found =
                    format!("output \"{}\" of the input \"{name}\", which has {}", shorten(output), value.brief());
                self.error(offset, found, "an input that is a node", "give it another input, or connect a node");
                None
            }
        }
    }

    /// Returns the value of a knob of a use, or at the top of a knob of the document.
    pub(super) fn knob(&mut self, scope: &Rc<Scope<'d>>, name: &str, offset: usize) -> Option<Spanned> {
        let groups = self.groups.clone();
        let document = self.knobs.clone();
        let knobs = scope.of.as_ref().map_or(&document[..], |within| &groups[within.group].knobs);
        let Some(knob) = knobs.iter().find(|knob| knob.name == name) else {
            let known: Vec<&str> = knobs.iter().map(|knob| knob.name).collect();
            let remedy = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean \"knobs.{near}\"?"),
                None if known.is_empty() => "add \"knobs\": { … }".into(),
                None => format!("knobs: {}", known.join(", ")),
            };
            let whose = match &scope.of {
                Some(within) => format!("the group {}", groups[within.group].name),
                None => "the document".into(),
            };
            let found = format!("\"knobs.{}\", which {whose} does not have", shorten(name));
            self.error(offset, found, "one of its knobs", remedy);
            return None;
        };
        let mut value = match (scope.given(name), &scope.of) {
            (Some(given), Some(within)) => {
                let outside = within.outside.clone();
                self.deeper(given.offset, (scope, name), |expander| expander.linked(given, &outside))
            }
            _ => {
                let default = knob.default?;
                if scope.of.is_none() {
                    *self.taken.entry(knob.name).or_default() += 1;
                }
                let label = format!("knobs.{name}");
                self.deeper(default.offset, (scope, &label), |expander| expander.linked(default, scope))
            }
        }?;
        if let (Json::Number(number), Some(legal)) = (&mut value.json, self.legal.get(&value.offset)) {
            *number = *legal;
        }
        Some(value)
    }
}

/// Tells in words how values follow each other around a circle.
fn circle(names: &[String]) -> String {
    // A knob or input of a use is written as those of nodes are.
    let told = |name: &String| match name.rsplit_once('/') {
        Some((user, own)) if !own.contains('.') => shorten(&format!("{user}.{own}")),
        _ => shorten(name),
    };
    let next = names.iter().skip(1).take(5).map(told).chain((names.len() > 6).then(|| "…".into()));
    let next: Vec<String> = next.chain([told(&names[0])]).collect();
    format!("{} follows {}", told(&names[0]), next.join(", which follows "))
}

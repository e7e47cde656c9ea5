//! Documents without groups and links: every use of a group is replaced by the group's nodes, and every link by its value.
//!
//! What is checked and evaluated is the expanded document, in which the nodes of a group have the names of its uses before
//! their own: `front/hull`. Values keep their places in the text, so messages lead into the group.

mod formula;
mod group;
mod link;
mod pick;
mod scope;

use crate::spanned::{Entry, Json, Spanned, number_text, shorten};
use crate::{Accepts, Document, Item, Knob, KnobType, Registry, nearest};
use formula::Time;
pub(crate) use group::input_kinds;
use group::{Group, GroupKnob};
pub use group::{INPUT_ACCEPTS, input_accepts, input_kind};
use pick::Picked;
use scope::Scope;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

/// Deepest nesting of uses, and longest chain of references and links.
const DEPTH: usize = 64;

/// A document without groups and links.
pub(crate) struct Expanded<'d> {
    /// Its root; that of the document if it has none.
    pub(crate) root: Cow<'d, Spanned>,
    pub(crate) faults: Vec<ExpansionFault>,
    /// Uses of groups, in the order of the document.
    pub(crate) uses: Vec<Use>,
    /// Names of the groups.
    pub(crate) groups: Vec<String>,
    /// Whether nodes and outputs were expanded: not if a group is faulty.
    pub(crate) is_whole: bool,
    /// Paths in included documents by their offsets, as they are relative to this document.
    pub(crate) moved: HashMap<usize, String>,
    /// Names of the nodes that pick weights which references name by their index, such as `parts.2`.
    pub(crate) picks: BTreeSet<String>,
    /// Knobs of the document, in its order.
    pub(crate) knobs: Vec<LinkedKnob>,
}

/// Knob of a document, and how often links and formulas take its value.
#[derive(Clone, Debug)]
pub(crate) struct LinkedKnob {
    pub(crate) name: String,
    /// Offset of its value, wherever links have brought it.
    pub(crate) offset: usize,
    pub(crate) taken: usize,
}

/// Fault of a group, of its use, or of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ExpansionFault {
    pub(crate) offset: usize,
    /// Path of the node.
    pub(crate) node: Option<String>,
    pub(crate) item: Option<String>,
    pub(crate) found: String,
    pub(crate) expected: String,
    pub(crate) remedy: String,
}

/// Use of a group.
pub(crate) struct Use {
    /// Its path: names from the outermost use to this one, with slashes between them.
    pub(crate) path: String,
    pub(crate) group: String,
    pub(crate) offset: usize,
    /// Connected inputs: name, what they take, offset, and the reference in the expanded document.
    pub(crate) inputs: Vec<UsedInput>,
}

/// Connected input of a use.
pub(crate) struct UsedInput {
    pub(crate) name: String,
    pub(crate) accepts: Accepts,
    pub(crate) offset: usize,
    pub(crate) reference: String,
}

/// Replaces uses of groups and links.
pub(crate) fn expand<'d>(document: &'d Document, registry: &'d Registry) -> Expanded<'d> {
    let root = &document.root;
    let Json::Object(entries) = &root.json else { return unchanged(root) };
    let is_new = |entry: &Entry| matches!(entry.key.as_str(), "groups" | "knobs");
    let nodes = entries.iter().find(|entry| entry.key == "nodes");
    let top: Vec<&Entry> = match nodes.map(|nodes| &nodes.value.json) {
        Some(Json::Object(nodes)) => nodes.iter().collect(),
        _ => Vec::new(),
    };
    let mut names_weights = pick::has_names(&top);
    let is_written_out = |entry: &Entry| !names_weights && !has_link(&entry.value) && !pick::has_any(&entry.value);
    let outputs = entries.iter().find(|entry| entry.key == "outputs");
    if !entries.iter().any(is_new) && [nodes, outputs].into_iter().flatten().all(is_written_out) {
        return unchanged(root);
    }
    let mut expander = Expander {
        document,
        registry,
        groups: Rc::default(),
        knobs: Rc::default(),
        faults: Vec::new(),
        uses: Vec::new(),
        moved: HashMap::new(),
        legal: HashMap::new(),
        picks: BTreeMap::new(),
        taken: BTreeMap::new(),
        top,
        names_weights,
        followed: Vec::new(),
        at: Vec::new(),
        time: Time::of(entries),
    };
    if let Some(groups) = entries.iter().find(|entry| entry.key == "groups") {
        expander.groups = Rc::new(expander.groups(&groups.value));
    }
    if let Some(knobs) = entries.iter().find(|entry| entry.key == "knobs") {
        expander.knobs = Rc::new(expander.knobs(&knobs.value, "knobs", "value"));
    }
    names_weights |= expander.groups.iter().any(|group| pick::has_names(&group.nodes));
    expander.names_weights = names_weights;
    expander.check_recursion();
    let groups = expander.groups.iter().map(|group| group.name.to_owned()).collect();
    let mut expanded = Vec::new();
    let is_whole = expander.faults.is_empty();
    if is_whole {
        let own = expander.top.clone();
        let scope = Rc::new(Scope::of_document(&own));
        for knob in expander.knobs.clone().iter() {
            let place = knob.default.map_or(0, |value| value.offset);
            if let Some(value) = expander.knob(&scope, knob.name, place) {
                expander.check_range(knob, &value);
            }
        }
        expander.taken.clear();
        let mut flat = Vec::new();
        expander.nodes(&own, &scope, &mut flat);
        for entry in entries.iter().filter(|entry| !is_new(entry)) {
            let mut entry = entry.clone();
            if let (Json::Object(outputs), "outputs") = (&mut entry.value.json, entry.key.as_str()) {
                outputs.iter_mut().for_each(|output| expander.output(output, &scope));
            }
            expanded.push(entry);
        }
        flat.extend(expander.picked());
        for entry in expanded.iter_mut().filter(|entry| entry.key == "nodes") {
            if let Json::Object(nodes) = &mut entry.value.json {
                *nodes = std::mem::take(&mut flat);
            }
        }
    } else {
        // Nothing is known of what uses a faulty group.
        expanded.extend(
            entries
                .iter()
                .filter(|entry| !is_new(entry) && !matches!(entry.key.as_str(), "nodes" | "outputs"))
                .cloned(),
        );
    }
    let Expander { faults, uses, moved, picks, taken, knobs, .. } = expander;
    let knob = |knob: &GroupKnob<'_>| {
        let taken = taken.get(knob.name).copied().unwrap_or_default();
        Some(LinkedKnob { name: knob.name.into(), offset: knob.default?.offset, taken })
    };
    let knobs = knobs.iter().filter_map(knob).collect();
    let root = Spanned { offset: root.offset, json: Json::Object(expanded) };
    let picks = picks.into_keys().collect();
    Expanded { root: Cow::Owned(root), faults, uses, groups, is_whole, moved, picks, knobs }
}

fn unchanged(root: &Spanned) -> Expanded<'_> {
    let (faults, uses, groups, moved, picks, knobs) = Default::default();
    Expanded { root: Cow::Borrowed(root), faults, uses, groups, is_whole: true, moved, picks, knobs }
}

/// Whether a value has a link somewhere.
fn has_link(value: &Spanned) -> bool {
    match &value.json {
        Json::String(text) => link::is_link(text),
        Json::Array(items) => items.iter().any(has_link),
        Json::Object(entries) => entries.iter().any(|entry| !is_remark(&entry.key) && has_link(&entry.value)),
        _ => false,
    }
}

/// Whether a key of a node is for people and editors alone.
fn is_remark(key: &str) -> bool {
    matches!(key, "ui" | "notes")
}

/// Expands a document, and collects faults.
struct Expander<'d> {
    document: &'d Document,
    registry: &'d Registry,
    groups: Rc<Vec<Group<'d>>>,
    /// Knobs of the document.
    knobs: Rc<Vec<GroupKnob<'d>>>,
    faults: Vec<ExpansionFault>,
    uses: Vec<Use>,
    moved: HashMap<usize, String>,
    /// Legal values of knobs in place of those whose fault is reported, by the place of the value, so that no port reports
    /// it again.
    legal: HashMap<usize, f64>,
    /// Nodes that pick weights, by name.
    picks: BTreeMap<String, Picked>,
    /// How often the values of the document's knobs are taken.
    taken: BTreeMap<&'d str, usize>,
    /// Nodes of the document.
    top: Vec<&'d Entry>,
    /// Whether any node names its weights.
    names_weights: bool,
    /// References and links that are being followed.
    followed: Vec<String>,
    /// Path of the node that is being read, and its item.
    at: Vec<String>,
    time: Time,
}

impl<'d> Expander<'d> {
    fn error(&mut self, offset: usize, found: impl ToString, expected: impl ToString, remedy: impl ToString) {
        let mut at = self.at.iter().cloned();
        let fault = ExpansionFault {
            offset,
            node: at.next(),
            item: at.next(),
            found: found.to_string(),
            expected: expected.to_string(),
            remedy: remedy.to_string(),
        };
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    fn unknown(&mut self, offset: usize, key: &str, known: &[&str]) {
        let remedy = match nearest(key, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("rename it to one of these, or remove it: {}", known.join(", ")),
        };
        self.error(offset, format!("unknown key \"{}\"", shorten(key)), "a known key", remedy);
    }

    /// Returns the entries of an object; reports other values and second keys.
    fn object(&mut self, value: &'d Spanned, place: &str, expected: &str) -> Option<Vec<&'d Entry>> {
        let Json::Object(entries) = &value.json else {
            self.error(value.offset, format!("{place}: {}", value.brief()), expected, "write a JSON object: { … }");
            return None;
        };
        let mut kept: Vec<&Entry> = Vec::new();
        for entry in entries {
            if kept.iter().any(|known| known.key == entry.key) {
                let found = format!("a second \"{}\"", shorten(&entry.key));
                self.error(entry.offset, found, "each name once", "rename or remove one of them");
            } else {
                kept.push(entry);
            }
        }
        Some(kept)
    }

    /// Returns the group that a node uses, if it uses one.
    fn used(&self, entry: &Entry) -> Option<usize> {
        let Json::Object(items) = &entry.value.json else { return None };
        let Json::String(ty) = &items.iter().find(|item| item.key == "type")?.value.json else { return None };
        self.groups.iter().position(|group| group.name == ty)
    }

    /// Reports groups that use themselves, directly or through others.
    fn check_recursion(&mut self) {
        let groups = self.groups.clone();
        let mut state = vec![0_u8; groups.len()];
        for start in 0..groups.len() {
            let mut path = Vec::new();
            self.visit(start, &groups, &mut state, &mut path);
        }
    }

    fn visit(&mut self, index: usize, groups: &[Group<'d>], state: &mut [u8], path: &mut Vec<usize>) {
        if state[index] == 2 {
            return;
        }
        if state[index] == 1 {
            let from = path.iter().position(|known| *known == index).unwrap_or_default();
            let names: Vec<&str> = path[from..].iter().chain([&index]).map(|index| groups[*index].name).collect();
            let place = groups[index].nodes.iter().find(|node| self.used(node).is_some()).map_or(0, |node| node.offset);
            let found = format!("a group that uses itself: {}", names.join(" → "));
            self.error(place, found, "groups that end somewhere", "remove one of these uses");
            return;
        }
        state[index] = 1;
        path.push(index);
        for node in &groups[index].nodes {
            if let Some(used) = self.used(node) {
                self.visit(used, groups, state, path);
            }
        }
        path.pop();
        state[index] = 2;
    }

    /// Appends the nodes of a scope in their order, those of groups in place of their uses.
    fn nodes(&mut self, entries: &[&'d Entry], scope: &Rc<Scope<'d>>, flat: &mut Vec<Entry>) {
        for entry in entries {
            if flat.len() > crate::document::MAX_NODES {
                return;
            }
            let path = format!("{}{}", scope.prefix, entry.key);
            self.at = vec![path.clone()];
            if let Some(index) = self.used(entry) {
                self.expand_use(index, entry, path, scope, flat);
            } else {
                flat.push(Entry { key: path, offset: entry.offset, value: self.node(entry, scope) });
            }
        }
    }

    /// Appends the nodes of a use, and checks what it is given.
    fn expand_use(
        &mut self,
        index: usize,
        entry: &'d Entry,
        path: String,
        scope: &Rc<Scope<'d>>,
        flat: &mut Vec<Entry>,
    ) {
        let groups = self.groups.clone();
        let group = &groups[index];
        let within = Rc::new(Scope::of_use(index, group, entry, &path, scope));
        self.given(group, entry, &within);
        let inputs = group.inputs.iter().filter_map(|input| {
            let offset = within.given(input.name)?.offset;
            match self.input(&within, input.name, None, offset)?.json {
                Json::String(reference) if !is_color(&reference) => {
                    Some(UsedInput { name: input.name.into(), accepts: input.accepts, offset, reference })
                }
                _ => None,
            }
        });
        let inputs = inputs.collect();
        self.uses.push(Use { path, group: group.name.into(), offset: entry.offset, inputs });
        if !within.is_disabled() {
            self.nodes(&group.nodes, &within, flat);
        }
    }

    /// Checks the keys of a use, and that nothing is missing.
    fn given(&mut self, group: &Group<'d>, entry: &'d Entry, within: &Rc<Scope<'d>>) {
        let Json::Object(items) = &entry.value.json else { return };
        let names: Vec<&str> =
            group.inputs.iter().map(|input| input.name).chain(group.knobs.iter().map(|knob| knob.name)).collect();
        for item in items {
            if !["type", "disabled", "ui", "notes"].contains(&item.key.as_str()) && !names.contains(&item.key.as_str())
            {
                self.unknown(item.offset, &item.key, &names);
            }
            if item.key == "disabled" && !matches!(item.value.json, Json::Bool(_)) {
                self.error(item.value.offset, item.value.brief(), "true or false", "write true or false");
            }
        }
        if within.is_disabled() && group.inputs.is_empty() {
            let found = format!("a disabled use of \"{}\", which has no inputs", group.name);
            self.error(entry.offset, found, "one with an input to pass on", "remove it instead");
        }
        for input in &group.inputs {
            if within.given(input.name).is_none() && input.default.is_none() && !input.is_optional {
                let found = format!("no \"{}\"", input.name);
                self.error(entry.offset, found, format!("a {}", input.accepts), "connect it, as the group asks for it");
            }
        }
        // To look at a value is not to take it.
        let taken = std::mem::take(&mut self.taken);
        for knob in &group.knobs {
            match self.knob(within, knob.name, entry.offset) {
                Some(value) => self.check_range(knob, &value),
                None if within.given(knob.name).is_none() && knob.default.is_none() => {
                    let found = format!("no \"{}\"", knob.name);
                    self.error(entry.offset, found, "a value", "set it: the group has no default for it");
                }
                None => {}
            }
        }
        self.taken = taken;
    }

    fn check_range(&mut self, knob: &GroupKnob<'d>, value: &Spanned) {
        let [min, max] = knob.range;
        let mut check = |offset: usize, number: f64, at: &str| {
            if !(min..=max).contains(&number) {
                let expected = match (min.is_finite(), max.is_finite()) {
                    (true, true) => format!("a number from {min} to {max}"),
                    (true, false) => format!("a number of at least {min}"),
                    _ => format!("a number of at most {max}"),
                };
                let found = format!("{}: {}{at}", knob.name, number_text(number));
                self.error(offset, found, expected, "correct the value");
            }
        };
        let mut written = |value: &Spanned| {
            if let Json::Number(number) = value.json {
                check(value.offset, number, "");
            }
        };
        match &value.json {
            Json::Object(items) => {
                let keys = items.iter().find(|item| item.key == "keys").map(|item| &item.value.json);
                let Some(Json::Array(keys)) = keys else { return };
                keys.iter()
                    .filter_map(|key| if let Json::Array(pair) = &key.json { pair.get(1) } else { None })
                    .for_each(&mut written);
                let turns = formula::numbers(value).map_or(Vec::new(), |numbers| numbers.turns());
                if let Some((frame, number)) = turns.into_iter().find(|(_, number)| !(min..=max).contains(number)) {
                    check(value.offset, number, &format!(" at frame {frame:.1}, between keys"));
                }
            }
            Json::Array(items) => items.iter().for_each(&mut written),
            _ => written(value),
        }
        if let Json::Number(number) = value.json
            && !(min..=max).contains(&number)
        {
            self.legal.insert(value.offset, number.min(max).max(min));
        }
    }

    /// Returns a node with the references and values of the expanded document.
    fn node(&mut self, entry: &'d Entry, scope: &Rc<Scope<'d>>) -> Spanned {
        let Json::Object(items) = &entry.value.json else { return entry.value.clone() };
        let ty = items.iter().find(|item| item.key == "type").map(|item| &item.value.json);
        let ty = if let Some(Json::String(ty)) = ty { self.registry.get(ty) } else { None };
        let declared = ty.map_or(&[][..], |ty| ty.declaration().items);
        let items = items.iter().filter_map(|item| self.item(item, declared, scope)).collect();
        Spanned { offset: entry.value.offset, json: Json::Object(items) }
    }

    /// Returns an item of a node or of a record; `None` if its port stays open.
    fn item(&mut self, item: &'d Entry, declared: &'static [Item], scope: &Rc<Scope<'d>>) -> Option<Entry> {
        let key = item.key.as_str();
        if key == "type" || is_remark(key) {
            return Some(item.clone());
        }
        self.at.truncate(1);
        self.at.push(key.to_owned());
        let found = declared.iter().find(|known| known.name() == key);
        let mut value = match (found, &item.value.json) {
            (Some(Item::Port(_)), _) => self.connected(&item.value, scope)?,
            (Some(Item::List(list)), Json::Array(records)) => {
                let record = |record: &'d Spanned, expander: &mut Self| match &record.json {
                    Json::Object(items) => {
                        let items = items.iter().filter_map(|item| expander.item(item, list.items, scope)).collect();
                        Spanned { offset: record.offset, json: Json::Object(items) }
                    }
                    _ => record.clone(),
                };
                let records = records.iter().map(|item| record(item, self)).collect();
                Spanned { offset: item.value.offset, json: Json::Array(records) }
            }
            _ => self.linked(&item.value, scope)?,
        };
        if let (Some(Item::Knob(Knob { takes: KnobType::Path, .. })), Json::String(path)) = (found, &value.json)
            && let Some(path) = self.document.relocated(path, value.offset)
        {
            self.moved.insert(value.offset, path.clone());
            value.json = Json::String(path);
        }
        Some(Entry { key: item.key.clone(), offset: item.offset, value })
    }

    /// Replaces the references of an output.
    fn output(&mut self, output: &mut Entry, scope: &Rc<Scope<'d>>) {
        self.at.clear();
        let Json::Object(items) = &mut output.value.json else { return };
        for item in
            items.iter_mut().filter(|item| matches!(item.key.as_str(), "color" | "weights" | "field" | "recipe"))
        {
            if let Json::String(text) = &item.value.json
                && let Some(found) = self.reference(scope, &text.clone(), item.value.offset)
            {
                item.value.json = found.json;
            }
        }
    }
}

/// Whether a text in a port is a color, not a reference.
fn is_color(text: &str) -> bool {
    text.starts_with('#') || text.starts_with("palette.") || text == "palette"
}

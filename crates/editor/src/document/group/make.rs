//! Groups made of nodes.

use super::NoGroup;
use super::body::{Connected, Rewriter};
use super::library::object;
use super::link;
use crate::document::change::{Edit, style};
use crate::document::decor;
use crate::document::edit::{count, default_value};
use crate::document::json::{Op, Path, quoted};
use crate::document::output;
use crate::document::sheet::{Node, Point, Sheet};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use trochoid::{Accepts, Item, Kind, input_kind};

/// Keys of a use that no input and no knob may have.
pub(super) const RESERVED: [&str; 5] = ["type", "disabled", "ui", "notes", "knobs"];

/// A group being made.
struct Draft<'s> {
    sheet: &'s Sheet,
    /// Indices of its nodes, in the order of the document.
    members: Vec<usize>,
    use_name: String,
    /// Inputs by the reference that they are connected to: name and kind.
    inputs: BTreeMap<String, (String, String)>,
    /// References within the group that are outputs, and their names.
    outputs: Vec<(String, String)>,
    knobs: Vec<DraftKnob>,
}

/// A knob of a group being made.
struct DraftKnob {
    name: String,
    definition: Value,
    from: From,
}

/// Where the value of a knob comes from.
#[derive(Clone, PartialEq)]
enum From {
    /// The knob of a member, which is linked to it.
    Member(String, String),
    /// What the use sets: a link out of it.
    Use(Value),
}

/// Makes a group of nodes, and puts a use of it in their place. Returns the edit and the name of the use.
///
/// # Errors
/// The nodes cannot be a group.
pub fn grouped(sheet: &Sheet, names: &BTreeSet<String>) -> Result<(Edit, String), NoGroup> {
    let chosen = names.iter().filter_map(|name| sheet.find(name));
    let members: BTreeSet<usize> = chosen.filter(|node| sheet.nodes[*node].side.is_none()).collect();
    if members.is_empty() {
        return Err(NoGroup::Nothing);
    }
    let below = sheet.downstream(members.iter().copied());
    let above = sheet.upstream(members.iter().copied());
    let between =
        (0..sheet.nodes.len()).find(|node| !members.contains(node) && below.contains(node) && above.contains(node));
    if let Some(between) = between {
        return Err(NoGroup::Between(sheet.nodes[between].called().into()));
    }
    let group = sheet.library.free_name("Group");
    let mut draft = Draft {
        sheet,
        members: members.into_iter().collect(),
        use_name: sheet.free_name(&group.to_lowercase()),
        inputs: BTreeMap::new(),
        outputs: Vec::new(),
        knobs: Vec::new(),
    };
    draft.find_inputs();
    draft.find_outputs();
    let mut outside = draft.outside_links();
    let body = draft.body();
    let mut ops = vec![Op::Set(Path::default().to("groups").to(&group), body)];
    ops.append(&mut outside);
    ops.extend(draft.moved(&group));
    let label = format!("Group {}", count(draft.members.len(), "node"));
    Ok((Edit::new(label, ops), draft.use_name))
}

/// Returns a name of an input, output or knob that is not taken.
pub(super) fn free(wanted: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let is_taken = |name: &str| RESERVED.contains(&name) || is_taken(name);
    let names = std::iter::once(wanted.to_string()).chain((2..).map(|n: usize| format!("{wanted}{n}")));
    names.into_iter().find(|name| !is_taken(name)).unwrap_or_default()
}

/// Returns the name of the kind that an input needs for a value of this kind.
fn kind_name(kind: Option<Kind>, accepts: Accepts) -> Accepts {
    match kind {
        Some(Kind::Color | Kind::Layers(_)) => Accepts::Color,
        Some(Kind::MASK) => Accepts::Mask,
        Some(Kind::Weights(_)) => Accepts::Weights,
        Some(Kind::ANY) | None => match accepts {
            Accepts::Scalar | Accepts::Direction => Accepts::Field,
            accepts => accepts,
        },
        Some(Kind::Field(_)) => Accepts::Field,
        Some(Kind::Surface) => Accepts::Surface,
        Some(Kind::Camera) => Accepts::Camera,
        Some(Kind::Light) => Accepts::Light,
        Some(Kind::View) => Accepts::View,
    }
}

impl Draft<'_> {
    fn is_member(&self, node: usize) -> bool {
        self.members.binary_search(&node).is_ok()
    }

    fn is_name_taken(&self, name: &str) -> bool {
        self.members.iter().any(|node| self.sheet.nodes[*node].name == name)
            || self.inputs.values().any(|(known, _)| known == name)
            || self.knobs.iter().any(|known| known.name == name)
    }

    /// Returns all references from pins to nodes: the node that is referred to, the pin and its node, and the text.
    fn references(&self) -> Vec<(usize, (usize, usize), String)> {
        let sheet = self.sheet;
        let pins =
            sheet.nodes.iter().enumerate().flat_map(|(node, own)| (0..own.pins.len()).map(move |pin| (node, pin)));
        let named = pins.filter_map(|to| {
            let text = sheet.nodes[to.0].pins[to.1].value.as_ref()?.as_str()?;
            let name = text.split_once('.').map_or(text, |(name, _)| name);
            Some((sheet.find(name)?, to, text.to_string()))
        });
        named.collect()
    }

    /// Makes an input for each result that comes in.
    fn find_inputs(&mut self) {
        let sheet = self.sheet;
        for (from, to, text) in self.references() {
            if !self.is_member(to.0) || self.is_member(from) || self.inputs.contains_key(&text) {
                continue;
            }
            let kind = sheet.source(&text).and_then(|(node, output)| sheet.nodes[node].makes.get(output)?.1);
            let kind = input_kind(kind_name(kind, sheet.nodes[to.0].pins[to.1].accepts));
            let name = free(&text.replace('.', "_"), |name| self.is_name_taken(name));
            self.inputs.insert(text, (name, kind));
        }
    }

    /// Makes an output for each result that is used outside; if there is none, for those that nothing inside takes.
    fn find_outputs(&mut self) {
        let sheet = self.sheet;
        let all = self.references();
        let out = all.iter().filter(|(from, to, _)| self.is_member(*from) && !self.is_member(to.0));
        let rendered = sheet.outputs.iter().filter_map(|output| {
            let name = output.source.split_once('.').map_or(output.source.as_str(), |(name, _)| name);
            Some((sheet.find(name)?, output.source.clone()))
        });
        let rendered = rendered.filter(|(from, _)| self.is_member(*from));
        let mut taken: Vec<(usize, String)> =
            out.map(|(from, _, text)| (*from, text.clone())).chain(rendered).collect();
        if taken.is_empty() {
            let is_end = |node: &&usize| all.iter().all(|(from, ..)| from != *node);
            let ends = self.members.iter().filter(is_end);
            taken = ends.map(|node| (*node, sheet.nodes[*node].name.clone())).collect();
        }
        taken.sort();
        taken.dedup();
        for (_, text) in taken {
            let name = free(&text.replace('.', "_"), |name| self.outputs.iter().any(|(_, known)| known == name));
            self.outputs.push((text, name));
        }
    }

    /// Returns the reference outside to a result of a member.
    fn shown_as(&self, text: &str) -> Option<String> {
        let index = self.outputs.iter().position(|(known, _)| known == text)?;
        Some(match index {
            0 => self.use_name.clone(),
            _ => format!("{}.{}", self.use_name, self.outputs[index].1),
        })
    }

    /// Makes a knob of a member one of the group, and returns its name. The use keeps its default.
    fn knob_of_member(&mut self, node: &str, knob: &str) -> String {
        let from = From::Member(node.into(), knob.into());
        if let Some(known) = self.knobs.iter().find(|known| known.from == from) {
            return known.name.clone();
        }
        let value = self.sheet.get(&Path::node(node).to(knob)).cloned();
        let declared = self.sheet.node(node).and_then(|node| node.declaration);
        let default = || {
            declared?.items.iter().find_map(|item| match item {
                Item::Knob(known) if known.name == knob => Some(default_value(known)),
                _ => None,
            })
        };
        let default = value.or_else(default).unwrap_or_default();
        let name = free(&format!("{node}_{knob}"), |name| self.is_name_taken(name));
        self.knobs.push(DraftKnob { name: name.clone(), definition: default, from });
        name
    }

    /// Returns the name of a knob of the group that the use sets to a link out of it.
    fn knob_of_outside(&mut self, node: &str, knob: &str) -> String {
        let from = From::Use(format!("= {node}.{knob}").into());
        if let Some(known) = self.knobs.iter().find(|known| known.from == from) {
            return known.name.clone();
        }
        let wanted = if node == "knobs" { knob.to_string() } else { format!("{node}_{knob}") };
        let name = free(&wanted, |name| self.is_name_taken(name));
        self.knobs.push(DraftKnob { name: name.clone(), definition: json!({}), from });
        name
    }

    /// Rewrites links of other nodes, and of knobs of the document, to knobs of members: these become knobs of the group.
    fn outside_links(&mut self) -> Vec<Op> {
        let sheet = self.sheet;
        let mut places: Vec<(Path, Value)> = Vec::new();
        for (index, node) in sheet.nodes.iter().enumerate() {
            let path = Path::node(&node.name);
            if !self.is_member(index)
                && node.side.is_none()
                && let Some(body) = sheet.get(&path)
            {
                let entries = body.as_object().into_iter().flatten().filter(|(key, _)| !link::is_remark(key));
                places.extend(entries.map(|(key, value)| (path.to(key), value.clone())));
            }
        }
        if let (None, Some(knobs)) = (&sheet.within, object(&sheet.value, "knobs")) {
            places.extend(knobs.iter().map(|(name, value)| (Path::default().to("knobs").to(name), value.clone())));
        }
        let mut ops = Vec::new();
        for (path, old) in places {
            let mut new = old.clone();
            let mut change = |text: &str| -> Result<Value, Infallible> {
                let text = link::replaced::<Infallible>(text, |node, knob| {
                    let is_inside = sheet.find(node).is_some_and(|node| self.is_member(node));
                    Ok(is_inside.then(|| {
                        let name = self.knob_of_member(node, knob);
                        format!("{}.{name}", self.use_name)
                    }))
                })?;
                Ok(Value::from(text))
            };
            let mut keep = |text: &str| Ok(Connected::To(text.into()));
            let Ok(()) = Rewriter { reference: &mut keep, link: &mut change }.links(&mut new);
            if new != old {
                ops.push(Op::Set(path, style(&new)));
            }
        }
        ops
    }

    /// Returns the text of the group's definition.
    fn body(&mut self) -> String {
        let sheet = self.sheet;
        let mut nodes: Vec<(String, Value)> = Vec::new();
        for index in self.members.clone() {
            let node = &sheet.nodes[index];
            let mut body = sheet.get(&Path::node(&node.name)).cloned().unwrap_or_default();
            let inputs = self.inputs.clone();
            let mut reference = |text: &str| -> Result<Connected, Infallible> {
                Ok(Connected::To(inputs.get(text).map_or(text, |(name, _)| name.as_str()).into()))
            };
            let mut change = |text: &str| -> Result<Value, Infallible> {
                let text = link::replaced::<Infallible>(text, |node, knob| {
                    let is_inside = sheet.find(node).is_some_and(|node| self.is_member(node));
                    Ok((!is_inside).then(|| format!("knobs.{}", self.knob_of_outside(node, knob))))
                })?;
                Ok(Value::from(text))
            };
            let items = node.declaration.map_or(&[][..], |known| known.items);
            let Ok(()) = Rewriter { reference: &mut reference, link: &mut change }.items(items, &mut body);
            nodes.push((node.name.clone(), body));
        }
        // Knobs of members that are now the group's are linked to it.
        for known in &self.knobs {
            if let From::Member(node, knob) = &known.from
                && let Some((_, body)) = nodes.iter_mut().find(|(name, _)| name == node)
            {
                body[knob] = format!("= knobs.{}", known.name).into();
            }
        }
        let mut parts = Vec::new();
        let entries = |all: &mut dyn Iterator<Item = (String, String)>| {
            let lines: Vec<String> = all.map(|(name, value)| format!("{}: {value}", quoted(&name))).collect();
            format!("{{\n        {}\n      }}", lines.join(",\n        "))
        };
        if !self.inputs.is_empty() {
            let mut inputs = self.inputs.values().map(|(name, kind)| (name.clone(), quoted(kind)));
            parts.push(format!("\"inputs\": {}", entries(&mut inputs)));
        }
        if !self.knobs.is_empty() {
            let mut knobs = self.knobs.iter().map(|known| (known.name.clone(), style(&known.definition)));
            parts.push(format!("\"knobs\": {}", entries(&mut knobs)));
        }
        let mut nodes = nodes.iter().map(|(name, body)| (name.clone(), style(body)));
        parts.push(format!("\"nodes\": {}", entries(&mut nodes)));
        let mut outputs = self.outputs.iter().map(|(text, name)| (name.clone(), quoted(text)));
        parts.push(format!("\"outputs\": {}", entries(&mut outputs)));
        let ui = self.ui();
        if !ui.is_empty() {
            parts.push(format!("\"ui\": {}", style(&Value::Object(ui))));
        }
        format!("{{\n      {}\n    }}", parts.join(",\n      "))
    }

    /// Returns the places of the members, and the dots of wires to them.
    fn ui(&self) -> Map<String, Value> {
        let members = || self.members.iter().map(|node| &self.sheet.nodes[*node]);
        let place = |node: &Node| (node.name.clone(), json!(node.at.map(|at| f64::from(at).round())));
        let places: Map<String, Value> = members().filter(|node| node.placed).map(place).collect();
        let is_own = |key: &str| members().any(|node| key.split(['.', '[']).next() == Some(&node.name));
        let dots = object(&self.sheet.value, "ui").and_then(|ui| ui.get("wires")?.as_object());
        let dots: Map<String, Value> = dots
            .into_iter()
            .flatten()
            .filter(|(key, _)| is_own(key))
            .map(|(key, dots)| (key.clone(), dots.clone()))
            .collect();
        let all = [("positions", places), ("wires", dots)].into_iter().filter(|(_, entries)| !entries.is_empty());
        all.map(|(key, entries)| (key.to_string(), entries.into())).collect()
    }

    /// Returns the operations that put the use in the place of the members.
    fn moved(&self, group: &str) -> Vec<Op> {
        let sheet = self.sheet;
        let mut body = Map::new();
        body.insert("type".into(), group.into());
        for (text, (name, _)) in &self.inputs {
            body.insert(name.clone(), text.as_str().into());
        }
        for known in &self.knobs {
            if let From::Use(value) = &known.from {
                body.insert(known.name.clone(), value.clone());
            }
        }
        let mut ops = vec![Op::Set(Path::node(&self.use_name), style(&Value::Object(body)))];
        for (from, to, text) in self.references() {
            let below = &sheet.nodes[to.0];
            if self.is_member(from)
                && !self.is_member(to.0)
                && let Some(source) = self.shown_as(&text)
            {
                ops.push(Op::Set(Path::node(&below.name).join(&below.pins[to.1].steps), quoted(&source)));
            }
        }
        for shown in &sheet.outputs {
            let path = output::path(&shown.name);
            let key = output::KEYS.into_iter().find(|key| sheet.get(&path.to(*key)).is_some());
            let source = self.shown_as(&shown.source);
            ops.extend(key.zip(source).map(|(key, source)| Op::Set(path.to(key), quoted(&source))));
        }
        let placed: Vec<Point> = self
            .members
            .iter()
            .map(|node| &sheet.nodes[*node])
            .filter(|node| node.placed)
            .map(|node| node.at)
            .collect();
        for index in &self.members {
            let node = &sheet.nodes[*index];
            ops.push(Op::Remove(Path::node(&node.name)));
            ops.extend(decor::undotted(sheet, &node.name));
            if node.placed {
                ops.push(Op::Remove(Path::default().to("ui").to("positions").to(&node.name)));
            }
        }
        if !placed.is_empty() {
            let mean = |axis: usize| placed.iter().map(|at| f64::from(at[axis])).sum::<f64>() / placed.len() as f64;
            let at = style(&json!([mean(0).round(), mean(1).round()]));
            ops.push(Op::Set(Path::default().to("ui").to("positions").to(&self.use_name), at));
        }
        ops
    }
}

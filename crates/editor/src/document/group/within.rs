//! The inside of a use of a group, drawn and edited like a document.

use super::NoGroup;
use super::face::kind_of_input;
use super::library::{Library, object};
use super::link;
use crate::document::change::Edit;
use crate::document::json::{Op, Path, Step};
use crate::document::sheet::{Node, Pin, Sheet, Side};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::sync::Arc;
use trochoid::{Accepts, CheckedGraph, Kind, Role, input_accepts, registry};

/// What the name of a box begins with that stands for an output of a group. No node has a dot in its name.
pub const OUTPUT: &str = "outputs.";

/// A use of a group, as one of the nodes of a document or of another use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Within {
    /// Names of the uses from the outermost to this one, each with its group.
    pub uses: Vec<(String, String)>,
    /// The included file that has the group's definition; `None` if the document itself does.
    pub file: Option<String>,
    /// How often the group is used, uses within uses counted each.
    pub count: usize,
}

impl Within {
    /// Returns the name of the group.
    pub fn group(&self) -> &str {
        self.uses.last().map_or("", |(_, group)| group)
    }

    /// Returns what stands before the names of its nodes in the expanded document.
    pub fn prefix(&self) -> String {
        self.uses.iter().map(|(name, _)| format!("{name}/")).collect()
    }

    /// Returns the path of the group in the document.
    pub fn definition(&self) -> Path {
        Path::default().to("groups").to(self.group())
    }

    /// Returns where in the document something is that is at this path in the group.
    fn place(&self, library: &Library, path: &Path) -> Option<Path> {
        let own = self.definition();
        let [Step::Key(top), rest @ ..] = path.0.as_slice() else { return None };
        match (top.as_str(), rest) {
            ("nodes", [Step::Key(name), rest @ ..]) => {
                let (key, name) = match name.strip_prefix(OUTPUT) {
                    Some(output) => ("outputs", output),
                    None if library.group(self.group()).is_some_and(|group| group.has("inputs", name)) => {
                        ("inputs", name.as_str())
                    }
                    None => ("nodes", name.as_str()),
                };
                Some(own.to(key).to(name).join(rest))
            }
            ("nodes" | "ui", rest) => Some(own.to(top).join(rest)),
            _ => None,
        }
    }

    /// Returns an edit of the group's nodes as one of the document.
    ///
    /// # Errors
    /// The group's definition is in another file.
    pub fn rebased(&self, library: &Library, edit: Edit) -> Result<Edit, NoGroup> {
        let mut ops = Vec::new();
        for op in edit.ops {
            let Some(place) = self.place(library, op.path()) else {
                ops.push(op);
                continue;
            };
            if let Some(file) = &self.file {
                return Err(NoGroup::Included { group: self.group().into(), file: file.clone() });
            }
            ops.push(match op {
                Op::Set(_, value) => Op::Set(place, value),
                Op::Insert(_, value) => Op::Insert(place, value),
                Op::Remove(_) => Op::Remove(place),
                Op::Rename(_, name) if place.0.get(2) == Some(&Step::from("outputs")) => {
                    Op::Rename(place, name.strip_prefix(OUTPUT).unwrap_or(&name).into())
                }
                Op::Rename(_, name) => Op::Rename(place, name),
            });
        }
        Ok(Edit { ops, ..edit })
    }

    /// Completes the box of an input or output of the group; returns whether it is one.
    pub(in crate::document) fn completes(&self, library: &Library, node: &mut Node, body: &Value) -> bool {
        let Some(group) = library.group(self.group()) else { return false };
        if let Some(output) = node.name.strip_prefix(OUTPUT) {
            node.side = Some(Side::Output);
            node.ty = "Output".into();
            node.pins.push(Pin {
                steps: Vec::new(),
                label: output.into(),
                help: "What uses of the group make under this name.",
                accepts: Accepts::Image,
                required: true,
                more: false,
                of_list: false,
                takes_all: true,
                value: Some(body.clone()),
            });
        } else if group.has("inputs", &node.name) {
            let kind = body.as_str().or_else(|| body.get("kind")?.as_str()).unwrap_or_default();
            let accepts = input_accepts(kind).unwrap_or(Accepts::Image);
            node.side = Some(Side::Input);
            node.ty = format!("Input, {accepts}");
            node.makes = match registry().of_role(Role::Render) {
                // What a view has beside itself is referred to by the input, too.
                Some(render) if accepts == Accepts::View => {
                    render.declaration().outputs.iter().map(|output| (output.name, Some(output.kind))).collect()
                }
                _ => vec![("value", Some(kind_of_input(accepts)))],
            };
        }
        node.side.is_some()
    }
}

/// Returns the inside of a use; the names lead to it from the outermost use.
pub fn enter(root: &Sheet, names: &[String], graph: Option<&CheckedGraph>) -> Option<Sheet> {
    let library = &root.library;
    let (mut nodes, mut uses) = (object(&root.value, "nodes")?, Vec::new());
    for name in names {
        let (group, definition) = library.used(nodes.get(name)?)?;
        uses.push((name.clone(), group.to_string()));
        nodes = object(&definition.body, "nodes")?;
    }
    let (_, name) = uses.last()?;
    let group = library.group(name)?;
    let count = match graph {
        Some(graph) => graph.groups().iter().filter(|used| used.group == *name).count(),
        None => super::knobs::groups_using(root, name).1,
    };
    let mut inside = Map::new();
    inside.extend(group.entries("inputs").map(|(name, input)| (name.clone(), input.clone())));
    inside.extend(group.entries("nodes").map(|(name, node)| (name.clone(), node.clone())));
    inside.extend(group.entries("outputs").map(|(name, output)| (format!("{OUTPUT}{name}"), output.clone())));
    let mut value = Map::new();
    // What holds for the whole document.
    for key in ["trochoid", "format", "working_space", "palette", "frames", "tolerance", "groups"] {
        value.extend(root.value.get(key).map(|entry| (key.to_string(), entry.clone())));
    }
    value.insert("nodes".into(), inside.into());
    value.extend(group.body.get("ui").map(|ui| ("ui".to_string(), ui.clone())));
    let within = Within { file: group.file.clone(), count, uses };
    let mut sheet = Sheet::with_groups(value.into(), graph, root.library.clone(), Some(within));
    sheet.text = Arc::clone(&root.text);
    Some(sheet)
}

/// Returns the kind of an output of a node or use in a checked document.
pub fn known_kind(library: &Library, graph: &CheckedGraph, body: &Value, path: &str, output: &str) -> Option<Kind> {
    let (path, output) = expanded(library, body, path, Some(output))?;
    let node = graph.node(graph.find(&path)?);
    let outputs = node.ty.declaration().outputs;
    let index = output.map_or(Some(0), |output| outputs.iter().position(|known| known.name == output))?;
    node.kinds.get(index).copied()
}

/// Deepest nesting of groups that is followed.
const DEPTH: usize = 64;

/// Returns the node of the expanded document that an output of a node or use comes from, and that node's output.
fn expanded(library: &Library, body: &Value, path: &str, output: Option<&str>) -> Option<(String, Option<String>)> {
    let Some((_, group)) = library.used(body) else { return Some((path.into(), output.map(String::from))) };
    let outputs = object(&group.body, "outputs")?;
    let target = match output {
        None => outputs.values().next(),
        Some(output) => outputs.get(output),
    };
    let target = target?.as_str()?;
    let (name, output) = target.split_once('.').map_or((target, None), |(name, output)| (name, Some(output)));
    // What an input passes on is outside.
    let node = object(&group.body, "nodes")?.get(name)?;
    if path.matches('/').count() > DEPTH {
        return None;
    }
    expanded(library, node, &format!("{path}/{name}"), output)
}

/// Returns where the document defines a node that has this name in the expanded document; `None` if another file does.
pub fn definition_path(root: &Sheet, name: &str) -> Option<Path> {
    let (mut nodes, mut place) = (object(&root.value, "nodes")?, Path::default());
    let mut names = name.split('/').peekable();
    while let Some(name) = names.next() {
        let node = nodes.get(name)?;
        if names.peek().is_none() {
            return Some(place.to("nodes").to(name));
        }
        let (group, definition) = root.library.used(node)?;
        if definition.file.is_some() {
            return None;
        }
        place = Path::default().to("groups").to(group);
        nodes = object(&definition.body, "nodes")?;
    }
    None
}

/// Returns all nodes of a document that some of its nodes depend on by wires and links, including those themselves, and
/// those that knobs of the document are linked to.
pub fn needed(root: &Sheet, nodes: impl IntoIterator<Item = usize>) -> BTreeSet<usize> {
    let linked = |value: &Value, open: &mut BTreeSet<usize>| {
        link::each(value, &mut |text| {
            open.extend(link::names(text).into_iter().filter_map(|(_, node, _)| root.find(node)));
        });
    };
    let mut open: BTreeSet<usize> = nodes.into_iter().collect();
    if let Some(knobs) = root.value.get("knobs") {
        linked(knobs, &mut open);
    }
    let mut all = BTreeSet::new();
    while let Some(node) = open.pop_first() {
        if all.contains(&node) {
            continue;
        }
        for node in root.upstream([node]) {
            if all.insert(node)
                && let Some(body) = root.get(&Path::node(&root.nodes[node].name))
            {
                linked(body, &mut open);
            }
        }
    }
    all
}

/// Returns whether a node, or a box within a use, has this name in the expanded document.
pub fn is_node(root: &Sheet, name: &str) -> bool {
    let Some((path, own)) = name.rsplit_once('/') else { return root.find(name).is_some() };
    let Some(mut nodes) = object(&root.value, "nodes") else { return false };
    let mut inside = None;
    for name in path.split('/') {
        let Some((_, group)) = nodes.get(name).and_then(|node| root.library.used(node)) else { return false };
        let Some(own) = object(&group.body, "nodes") else { return false };
        (nodes, inside) = (own, Some(group));
    }
    nodes.contains_key(own) || inside.is_some_and(|group| group.has("inputs", own))
}

//! A document as the canvas draws it; invalid documents are included as far as they can be understood.

use super::color::{is_color, rgb};
use super::group::{self, Library, Within};
use super::json::{Path, Step};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use trochoid::{Accepts, Arity, CheckedGraph, Declaration, Item, Kind, PaletteColor, Role};

/// Point on the canvas; x points right, y down.
pub type Point = [f32; 2];

/// Largest absolute frame number in the editor.
pub(crate) const FAR: i64 = 10_000_000;

/// Nodes, wires, and outputs of a document.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Nodes in the order of the document.
    pub nodes: Vec<Node>,
    /// Index of each node, by name.
    index: HashMap<String, usize>,
    /// Wires in the order of the nodes at their lower ends.
    pub wires: Vec<Wire>,
    /// Outputs in the order of the document.
    pub outputs: Vec<Output>,
    /// First frame, last frame, and frames per second.
    pub frames: (i64, i64, f64),
    /// Width and height of pictures, in pixels.
    pub format: [u32; 2],
    /// Colors of the palette by name, at the first frame, as sRGB values from 0 to 1.
    pub palette: BTreeMap<String, [f32; 3]>,
    /// Colored areas behind nodes, by key.
    pub backdrops: BTreeMap<String, Backdrop>,
    /// The whole document as parsed JSON.
    pub value: Value,
    /// Text of the document.
    pub text: Arc<str>,
    /// Groups that nodes may use.
    pub library: Arc<Library>,
    /// The use of a group of which these are the nodes; `None` for those of the document.
    pub within: Option<Within>,
}

/// A node.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name of the node.
    pub name: String,
    /// Type as written in the document.
    pub ty: String,
    /// Declaration of the type, if the type is known.
    pub declaration: Option<&'static Declaration>,
    /// Whether the node is bypassed.
    pub disabled: bool,
    /// Upper left corner.
    pub at: Point,
    /// Whether the document specifies the position.
    pub placed: bool,
    /// Inputs.
    pub pins: Vec<Pin>,
    /// Outputs: names, and kinds where known.
    pub makes: Vec<(&'static str, Option<Kind>)>,
    /// What it is of the group that is looked at, if it is none of its nodes.
    pub side: Option<Side>,
    /// Whether it is a use of a group.
    pub is_use: bool,
}

/// A box that stands for an input or an output of the group that is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What uses connect.
    Input,
    /// What uses make.
    Output,
}

impl Node {
    /// Returns whether the node's type has a role.
    pub fn is(&self, role: Role) -> bool {
        self.declaration.is_some_and(|declaration| declaration.role == Some(role))
    }

    /// Returns its name as it is shown.
    pub fn called(&self) -> &str {
        match self.side {
            Some(Side::Output) => self.name.strip_prefix(group::OUTPUT).unwrap_or(&self.name),
            _ => &self.name,
        }
    }
}

/// Input of a node: a place for one connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// Path within the node.
    pub steps: Vec<Step>,
    /// Displayed name.
    pub label: String,
    /// Help text of the port.
    pub help: &'static str,
    /// Kinds that the pin accepts.
    pub accepts: Accepts,
    /// Whether the node needs a value here.
    pub required: bool,
    /// Whether this is the empty pin behind a list's last element, for one more.
    pub more: bool,
    /// Whether this pin is an element of a list.
    pub of_list: bool,
    /// Whether any kind is accepted.
    pub takes_all: bool,
    /// Value in the document.
    pub value: Option<Value>,
}

/// Connection from an output of a node to a pin of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Wire {
    /// Source node and its output.
    pub from: (usize, usize),
    /// Destination node and its pin.
    pub to: (usize, usize),
}

/// Entry of the document's `outputs`.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name of the output.
    pub name: String,
    /// Reference to a node and its output, as written.
    pub source: String,
}

/// Colored area behind nodes, with a title.
#[derive(Clone, Debug, PartialEq)]
pub struct Backdrop {
    /// Upper left corner.
    pub at: Point,
    /// Width and height.
    pub size: Point,
    /// Title or note.
    pub text: String,
    /// Index of a color in the theme.
    pub tint: usize,
}

impl Sheet {
    /// Reads a parsed document; `graph` supplies kinds if the document is valid.
    pub fn new(value: Value, graph: Option<&CheckedGraph>) -> Self {
        let library = Arc::new(Library::read(&value, None));
        Self::with_groups(value, graph, library, None)
    }

    /// Reads a parsed document whose nodes may use these groups, or the nodes within a use of one.
    pub fn with_groups(
        value: Value,
        graph: Option<&CheckedGraph>,
        library: Arc<Library>,
        within: Option<Within>,
    ) -> Self {
        let mut sheet = Self { frames: (1, 1, 24.0), format: [1920, 1080], library, within, ..Self::default() };
        let entries = value.get("nodes").and_then(Value::as_object);
        for (name, body) in entries.into_iter().flatten() {
            sheet.index.insert(name.clone(), sheet.nodes.len());
            let node = sheet.read_node(name, body, &value, graph);
            sheet.nodes.push(node);
        }
        sheet.pass_kinds();
        sheet.join();
        let outputs = value.get("outputs").and_then(Value::as_object);
        for (name, body) in outputs.into_iter().flatten() {
            let source = ["color", "weights", "field", "recipe"].iter().find_map(|key| body.get(key)?.as_str());
            sheet.outputs.push(Output { name: name.clone(), source: source.unwrap_or_default().into() });
        }
        if let Some(frames) = value.get("frames") {
            // Clamped to the timeline's range; the document reports frames beyond it as an error.
            let frame = |name: &str| frames.get(name).and_then(Value::as_i64).map(|frame| frame.clamp(-FAR, FAR));
            let first = frame("first").unwrap_or(1);
            let last = frame("last").unwrap_or(first);
            let fps = frames.get("fps").and_then(Value::as_f64).filter(|fps| *fps > 0.0).unwrap_or(24.0);
            sheet.frames = (first, last.max(first), fps);
        }
        if let Some(format) = value.get("format") {
            let side = |key: &str| format.get(key).and_then(Value::as_u64).and_then(|side| u32::try_from(side).ok());
            sheet.format = [side("width").unwrap_or(1920).max(1), side("height").unwrap_or(1080).max(1)];
        }
        sheet.palette = palette(&value, graph);
        let backdrops = value.get("ui").and_then(|ui| ui.get("backdrops")).and_then(Value::as_object);
        for (name, body) in backdrops.into_iter().flatten() {
            let (Some(at), Some(size)) = (point(body.get("at")), point(body.get("size"))) else { continue };
            let text = body.get("text").and_then(Value::as_str).unwrap_or_default().into();
            let tint = body.get("tint").and_then(Value::as_u64).unwrap_or(0) as usize;
            sheet.backdrops.insert(name.clone(), Backdrop { at, size, text, tint });
        }
        sheet.value = value;
        sheet
    }

    /// Returns the index of the node with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// Returns the node with this name.
    pub fn node(&self, name: &str) -> Option<&Node> {
        Some(&self.nodes[self.find(name)?])
    }

    /// Returns the value at a path of the document.
    pub fn get(&self, path: &Path) -> Option<&Value> {
        path.find(&self.value)
    }

    /// Returns the kind of data on a wire.
    pub fn kind(&self, wire: &Wire) -> Option<Kind> {
        self.nodes[wire.from.0].makes.get(wire.from.1)?.1
    }

    /// Returns the old and new names of nodes renamed since the earlier sheet, matched by position.
    pub fn renamed(&self, before: &Self) -> Vec<(String, String)> {
        if self.nodes.len() != before.nodes.len() {
            return Vec::new();
        }
        let pairs = before.nodes.iter().zip(&self.nodes).map(|(old, new)| (&old.name, &new.name));
        let changed = pairs.filter(|(old, new)| self.find(old).is_none() && before.find(new).is_none());
        changed.map(|(old, new)| (old.clone(), new.clone())).collect()
    }

    /// Returns the color that a name in the palette stands for, as sRGB values from 0 to 1.
    pub fn named(&self, text: &str) -> Option<[f32; 3]> {
        self.palette.get(text.strip_prefix("palette.")?).copied()
    }

    /// Resolves a reference to a node and its output.
    pub fn source(&self, text: &str) -> Option<(usize, usize)> {
        let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
        let node = self.find(name)?;
        let output = match output {
            None => 0,
            Some(output) => self.nodes[node].makes.iter().position(|(known, _)| *known == output)?,
        };
        Some((node, output))
    }

    /// Returns the reference to an output of a node; the first output is referred to by the node's name alone.
    pub fn reference(&self, node: usize, output: usize) -> String {
        let node = &self.nodes[node];
        match node.makes.get(output) {
            Some((name, _)) if output > 0 => format!("{}.{name}", node.name),
            _ => node.name.clone(),
        }
    }

    /// Returns all nodes that the given ones depend on, including those themselves.
    pub fn upstream(&self, roots: impl IntoIterator<Item = usize>) -> HashSet<usize> {
        self.walk(roots, |wire| (wire.to.0, wire.from.0))
    }

    /// Returns all nodes that depend on the given ones, including those themselves.
    pub fn downstream(&self, roots: impl IntoIterator<Item = usize>) -> HashSet<usize> {
        self.walk(roots, |wire| (wire.from.0, wire.to.0))
    }

    fn walk(&self, roots: impl IntoIterator<Item = usize>, step: impl Fn(&Wire) -> (usize, usize)) -> HashSet<usize> {
        let mut next: HashMap<usize, Vec<usize>> = HashMap::new();
        for (from, to) in self.wires.iter().map(step) {
            next.entry(from).or_default().push(to);
        }
        let mut seen = HashSet::new();
        let mut open: Vec<usize> = roots.into_iter().collect();
        while let Some(node) = open.pop() {
            if seen.insert(node) {
                open.extend(next.get(&node).into_iter().flatten());
            }
        }
        seen
    }

    /// Returns an unused node name: `mix`, `mix2`, `mix3`.
    pub fn free_name(&self, wanted: &str) -> String {
        self.free_name_beside(wanted, |_| false)
    }

    /// Returns an unused node name that is not taken otherwise either.
    pub fn free_name_beside(&self, wanted: &str, taken: impl Fn(&str) -> bool) -> String {
        let taken = |name: &str| self.index.contains_key(name) || taken(name);
        if !taken(wanted) {
            return wanted.into();
        }
        let stem = wanted.trim_end_matches(|c: char| c.is_ascii_digit());
        let stem = if stem.is_empty() { "node" } else { stem };
        (2..).map(|n| format!("{stem}{n}")).find(|name| !taken(name)).unwrap_or_default()
    }

    /// Gives nodes whose output kind follows their input the kind of their first connection.
    fn pass_kinds(&mut self) {
        // Repeated at most as often as the longest chain of such nodes.
        for _ in 0..self.nodes.len() {
            let mut changed = false;
            for index in 0..self.nodes.len() {
                let open = self.nodes[index].makes.iter().any(|(_, kind)| *kind == Some(Kind::ANY));
                if !open {
                    continue;
                }
                let first = self.nodes[index].pins.iter().find_map(|pin| pin.value.as_ref());
                let kind = match first {
                    Some(Value::String(text)) if is_color(text) => Some(Kind::Color),
                    Some(Value::String(text)) => match self.source(text) {
                        Some((node, output)) => self.nodes[node].makes.get(output).and_then(|(_, kind)| *kind),
                        None => None,
                    },
                    Some(Value::Number(_)) => Some(Kind::MASK),
                    Some(Value::Array(_)) => Some(Kind::Color),
                    _ => None,
                };
                if kind != Some(Kind::ANY) {
                    let makes = &mut self.nodes[index].makes;
                    makes.iter_mut().filter(|(_, own)| *own == Some(Kind::ANY)).for_each(|(_, own)| *own = kind);
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// Collects the wires.
    fn join(&mut self) {
        for to in 0..self.nodes.len() {
            for pin in 0..self.nodes[to].pins.len() {
                let Some(Value::String(text)) = &self.nodes[to].pins[pin].value else { continue };
                if let Some(from) = self.source(text) {
                    self.wires.push(Wire { from, to: (to, pin) });
                }
            }
        }
    }
}

impl Sheet {
    /// Returns what stands before the names of its nodes in the expanded document.
    pub fn prefix(&self) -> String {
        self.within.as_ref().map(Within::prefix).unwrap_or_default()
    }

    fn read_node(&self, name: &str, body: &Value, document: &Value, graph: Option<&CheckedGraph>) -> Node {
        let ty = body.get("type").and_then(Value::as_str).unwrap_or_default();
        let declaration = self.library.declaration(body);
        let place = document.get("ui").and_then(|ui| ui.get("positions")).and_then(|all| point(all.get(name)));
        let mut node = Node {
            name: name.into(),
            ty: ty.into(),
            declaration,
            disabled: body.get("disabled") == Some(&Value::Bool(true)),
            at: place.unwrap_or_default(),
            placed: place.is_some(),
            pins: Vec::new(),
            makes: Vec::new(),
            side: None,
            is_use: self.library.used(body).is_some(),
        };
        if let Some(within) = &self.within
            && within.completes(&self.library, &mut node, body)
        {
            return node;
        }
        if let Some(declaration) = declaration {
            pins(declaration.items, body, &[], "", &mut node.pins);
            let path = format!("{}{name}", self.prefix());
            let kinds = declaration.outputs.iter().map(|output| {
                let known = graph.and_then(|graph| group::known_kind(&self.library, graph, body, &path, output.name));
                (output.name, known.or(Some(output.kind)))
            });
            node.makes = kinds.collect();
        }
        node
    }
}

impl Node {
    /// Returns the pin at a path within the node.
    pub fn pin(&self, steps: &[Step]) -> Option<usize> {
        self.pins.iter().position(|pin| pin.steps == steps)
    }
}

/// Collects the pins of some items; labels of a list's pins begin with the list's name.
fn pins(items: &'static [Item], body: &Value, steps: &[Step], before: &str, found: &mut Vec<Pin>) {
    for item in items {
        let within = |step: Step| steps.iter().cloned().chain([step]).collect::<Vec<Step>>();
        match item {
            Item::Knob(_) => {}
            Item::Port(port) => {
                let value = body.get(port.name);
                let pin = |steps: Vec<Step>, label: String, value: Option<&Value>| Pin {
                    steps,
                    label,
                    help: port.help,
                    accepts: port.accepts,
                    required: false,
                    more: false,
                    of_list: false,
                    takes_all: false,
                    value: value.cloned(),
                };
                let label = format!("{before}{}", port.name);
                match port.arity {
                    Arity::One | Arity::Optional => {
                        let required = port.arity == Arity::One;
                        found.push(Pin { required, ..pin(within(port.name.into()), label, value) });
                    }
                    Arity::Many { min, max } => {
                        let elements: &[Value] = value.and_then(Value::as_array).map_or(&[], Vec::as_slice);
                        let at = |index: usize| {
                            let mut steps = within(port.name.into());
                            steps.push(index.into());
                            steps
                        };
                        for (index, element) in elements.iter().enumerate() {
                            let label = format!("{label}[{index}]");
                            found.push(Pin { of_list: true, ..pin(at(index), label, Some(element)) });
                        }
                        if elements.len() < max {
                            let required = elements.len() < min;
                            let label = format!("{label}[{}]", elements.len());
                            found.push(Pin {
                                of_list: true,
                                required,
                                more: true,
                                ..pin(at(elements.len()), label, None)
                            });
                        }
                    }
                }
            }
            Item::List(list) => {
                let records: &[Value] = body.get(list.name).and_then(Value::as_array).map_or(&[], Vec::as_slice);
                for (index, record) in records.iter().enumerate() {
                    let mut steps = within(list.name.into());
                    steps.push(index.into());
                    pins(list.items, record, &steps, &format!("{before}{}[{index}].", list.name), found);
                }
            }
        }
    }
}

/// Parses a point.
pub fn point(value: Option<&Value>) -> Option<Point> {
    let [x, y] = value?.as_array()?.as_slice() else { return None };
    let [x, y] = [x.as_f64()? as f32, y.as_f64()? as f32];
    (x.is_finite() && y.is_finite()).then_some([x, y])
}

/// Returns the colors of a document's palette; those of an invalid document as far as they can be understood.
fn palette(value: &Value, graph: Option<&CheckedGraph>) -> BTreeMap<String, [f32; 3]> {
    if let Some(graph) = graph {
        let first = graph.frames().0 as f64;
        let shown = |color: &PaletteColor| {
            let numbers = color.color.at(first);
            let shown = graph.space().to_display([numbers[0], numbers[1], numbers[2]]);
            (color.name.clone(), shown.map(|channel| channel.clamp(0.0, 1.0) as f32))
        };
        return graph.palette().iter().map(shown).collect();
    }
    let entries = value.get("palette").and_then(Value::as_object).into_iter().flatten();
    entries.filter_map(|(name, color)| Some((name.clone(), rgb(color.as_str()?)?))).collect()
}

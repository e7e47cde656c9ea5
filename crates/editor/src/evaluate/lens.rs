//! Builds the document that shows one node: just that node and its dependencies, so that faults elsewhere do not
//! matter.

use super::subject::Subject;
use crate::document::{Path, Sheet, group, json as text, link};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use trochoid::{
    CheckedGraph, Diagnostic, DocumentPlace, EvalError, Format, FormatError, Kind, LoadError, NodeId, RefusedFile,
    Role, Severity, parse_within, registry,
};

/// Name of the lens's output.
pub const OUTPUT: &str = "look";

/// Names of nodes that a lens adds; `_` and the number keep them distinct from users' names.
const CAMERA: &str = "_lens_camera_1";
const LIGHT: &str = "_lens_light_1";
const VIEW: &str = "_lens_view_1";
const CLAY: &str = "_lens_clay_1";

/// Document that shows one node.
#[derive(Debug)]
pub struct Lens {
    /// The graph, whose only output is [`OUTPUT`].
    pub graph: CheckedGraph,
    /// Its document.
    pub text: String,
    /// Whether the picture is a clay shading of the node, because the node itself is not a picture.
    pub clay: bool,
}

impl Lens {
    /// Returns the files that evaluation at a frame may not read; the first one of each node.
    pub(super) fn refused(&self, frame: i64) -> Vec<RefusedFile> {
        let graph = &self.graph;
        let context = graph.frame_context(frame, u64::MAX);
        let reached = graph.dependencies(graph.outputs().iter().map(|output| output.node), frame);
        let nodes = (0..reached.len()).filter(|index| reached[*index] && !graph.nodes()[*index].disabled);
        nodes.filter_map(|index| graph.refused(NodeId(index), &context)).collect()
    }

    /// Returns the graph with its resolution divided by a factor.
    pub(super) fn drawn(&self, shrink: u32, finished: bool) -> Result<Cow<'_, CheckedGraph>, FormatError> {
        if shrink == 1 {
            return Ok(Cow::Borrowed(&self.graph));
        }
        let whole = self.graph.format();
        let side = |side: u32| side.div_ceil(shrink).max(1);
        // Coarse previews are visible only briefly: one sample per pixel is enough.
        let samples = if finished { whole.samples() } else { 1 };
        let format = Format::new(side(whole.width()), side(whole.height()), samples)?;
        Ok(Cow::Owned(self.graph.clone().with_scaled_format(format.sampled_like(whole))))
    }

    /// Translates the place in an error to the user's document; in the lens, everything is on one line.
    pub(super) fn in_document(&self, mut error: EvalError, subject: &Subject) -> EvalError {
        if let EvalError::Node { place, .. } | EvalError::TooMuchMemory { place, .. } = &mut error
            && let Some(there) = self.place_in_document(place, subject)
        {
            **place = there;
        }
        error
    }

    /// Returns the place in the user's document for a place in the lens.
    fn place_in_document(&self, sought: &DocumentPlace, subject: &Subject) -> Option<DocumentPlace> {
        let graph = &self.graph;
        let sheet = &subject.root;
        let mut places = vec![(graph.place_of_format(), Path::default().to("format"))];
        for (index, node) in graph.nodes().iter().enumerate() {
            let Some(own) = group::definition_path(sheet, &node.name) else { continue };
            let items = node.ty.declaration().items.iter();
            let items = items.map(|item| (graph.place_of(NodeId(index), Some(item.name())), own.to(item.name())));
            // The node's own place stands in for items that are not written in the document.
            places.push((graph.place_of(NodeId(index), None), own.clone()));
            places.extend(items);
        }
        let (_, path) = places.into_iter().find(|(place, _)| place == sought)?;
        let [line, column] = text::place(&sheet.text, &path)?;
        Some(DocumentPlace { document: subject.name.as_str().into(), line, column })
    }
}

/// Reason that an output of a node cannot be viewed.
#[derive(Debug, thiserror::Error)]
pub enum LensError {
    /// The output is not a picture.
    #[error("a {0} is not a picture: connect it to a Render or a pass, and view that")]
    NoPicture(Kind),
    /// The node's type is unknown.
    #[error("{0} cannot be shown, because nobody knows what it makes: select it to see what is wrong with it")]
    Unknown(String),
    /// The node or one of its dependencies has a fault.
    #[error("{}", told(.0))]
    Fault(Box<Diagnostic>),
    /// The lens's document cannot be read.
    #[error(transparent)]
    Load(LoadError),
}

/// Tells a fault with its place first. The lens has a text of its own, whose lines nobody knows.
fn told(fault: &Diagnostic) -> String {
    let place: Vec<&str> = [&fault.node, &fault.port].into_iter().flatten().map(String::as_str).collect();
    let place = if place.is_empty() { String::new() } else { format!("{}: ", place.join(", ")) };
    let remedy = if fault.remedy.is_empty() { String::new() } else { format!("\n{}", fault.remedy) };
    format!("{place}found {}; expected {}{remedy}", fault.found, fault.expected)
}

/// Builds the graph that shows an output of a node.
///
/// # Errors
/// Fails if the node has no visible result, or if the node or one of its dependencies has a fault; the error is a
/// sentence.
pub fn lens(subject: &Subject) -> Result<Lens, LensError> {
    let Subject { root: sheet, node, output, name, folder, access, .. } = subject;
    let (node, output) = (*node, *output);
    let shown = &subject.sheet.nodes[node];
    let prefix = subject.sheet.prefix();
    // A node of a group needs what the use needs that has it.
    let outermost = prefix.split_once('/').map_or(shown.name.as_str(), |(name, _)| name);
    let mut nodes = Map::new();
    for index in group::needed(sheet, sheet.find(outermost)) {
        let name = &sheet.nodes[index].name;
        nodes.insert(name.clone(), sheet.get(&Path::node(name)).cloned().unwrap_or_default());
    }
    let kind = shown.makes.get(output).and_then(|(_, kind)| *kind);
    let reference = format!("{prefix}{}", subject.sheet.reference(node, output));
    let (key, source) = match kind {
        Some(Kind::Color | Kind::Layers(_)) => ("color", reference),
        Some(Kind::Weights(_)) => ("weights", reference),
        Some(Kind::Field(_)) => ("field", reference),
        Some(Kind::View) => clay(sheet, reference, &mut nodes),
        Some(Kind::Surface) => {
            if !borrow(sheet, Role::Camera, &mut nodes) {
                let camera = json!({ "type": ty(Role::Camera), "position": [0, 8, 30], "target": [0, 1, 0] });
                nodes.insert(CAMERA.into(), camera);
            }
            let camera = borrowed(sheet, Role::Camera).unwrap_or(CAMERA.into());
            nodes.insert(VIEW.into(), json!({ "type": ty(Role::Render), "camera": camera, "surfaces": [reference] }));
            clay(sheet, VIEW.into(), &mut nodes)
        }
        Some(kind @ (Kind::Camera | Kind::Light)) => {
            return Err(LensError::NoPicture(kind));
        }
        None => return Err(LensError::Unknown(shown.name.clone())),
    };
    follow(sheet, &mut nodes);
    let clay = matches!(kind, Some(Kind::View | Kind::Surface));
    let mut document = Map::new();
    for key in ["trochoid", "format", "working_space", "palette", "frames", "tolerance", "include", "groups", "knobs"] {
        if let Some(value) = sheet.value.get(key) {
            document.insert(key.into(), value.clone());
        }
    }
    document.insert("nodes".into(), nodes.into());
    document.insert("outputs".into(), json!({ OUTPUT: { key: source } }));
    let text = Value::Object(document).to_string();
    match parse_within(name, &text, folder, &[], access.clone()) {
        Ok(loaded) => Ok(Lens { graph: loaded.graph, text, clay }),
        Err(LoadError::Invalid(diagnostics)) => {
            let errors = diagnostics.into_iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
            // The node's own fault takes precedence over those above it.
            let whole = subject.whole_name();
            let worst = errors.min_by_key(|diagnostic| diagnostic.node.as_deref() != Some(whole.as_str()));
            let none = || LensError::Load(LoadError::Invalid(Vec::new()));
            Err(worst.map_or_else(none, |fault| LensError::Fault(Box::new(fault))))
        }
        Err(error) => Err(LensError::Load(error)),
    }
}

/// Adds the nodes whose knobs others follow by links, and all that these depend on.
fn follow(sheet: &Sheet, nodes: &mut Map<String, Value>) {
    let linked = |value: &Value| -> Vec<usize> {
        let links = link::links(value, &Path::default());
        let names = links.into_iter().flat_map(|(_, link)| link::nodes(link));
        names.filter_map(|name| sheet.find(&name)).collect()
    };
    let mut open: Vec<usize> = sheet.value.get("knobs").map(linked).unwrap_or_default();
    open.extend(nodes.values().flat_map(linked));
    while let Some(node) = open.pop() {
        for index in sheet.upstream([node]) {
            let name = &sheet.nodes[index].name;
            if !nodes.contains_key(name) {
                let body = sheet.get(&Path::node(name)).cloned().unwrap_or_default();
                open.extend(linked(&body));
                nodes.insert(name.clone(), body);
            }
        }
    }
}

/// Returns the name of the type with a role.
fn ty(role: Role) -> &'static str {
    registry().of_role(role).map_or("", |ty| ty.declaration().name)
}

/// Returns the first node of the document with a role.
fn borrowed(sheet: &Sheet, role: Role) -> Option<String> {
    sheet.nodes.iter().find(|node| node.is(role) && !node.disabled).map(|node| node.name.clone())
}

/// Copies the document's first node with a role and its dependencies; returns whether there is one.
fn borrow(sheet: &Sheet, role: Role, nodes: &mut Map<String, Value>) -> bool {
    let Some(found) = borrowed(sheet, role).and_then(|name| sheet.find(&name)) else { return false };
    for index in group::needed(sheet, [found]) {
        let name = &sheet.nodes[index].name;
        nodes.entry(name.clone()).or_insert_with(|| sheet.get(&Path::node(name)).cloned().unwrap_or_default());
    }
    true
}

/// Shades a view like clay.
fn clay(sheet: &Sheet, view: String, nodes: &mut Map<String, Value>) -> (&'static str, String) {
    if !borrow(sheet, Role::Light, nodes) {
        nodes.insert(LIGHT.into(), json!({ "type": ty(Role::Light), "direction": [0.5, 0.6, 0.4] }));
    }
    let light = borrowed(sheet, Role::Light).unwrap_or(LIGHT.into());
    nodes.insert(CLAY.into(), json!({ "type": ty(Role::Clay), "view": view, "lights": [light] }));
    ("field", CLAY.into())
}

/// Builds a graph with one output per visible node of the subject's sheet, so that all thumbnails are evaluated at once;
/// also returns the nodes' names in the expanded document, in the order of the outputs. Returns `None` if the document is
/// invalid. Only the first 1000 visible nodes get an output.
pub(super) fn of_every_node(subject: &Subject) -> Option<(CheckedGraph, Vec<String>)> {
    let Subject { root, sheet, name, folder, access, .. } = subject;
    let mut document = root.value.as_object()?.clone();
    let (mut outputs, mut names) = (Map::new(), Vec::new());
    let prefix = sheet.prefix();
    for node in sheet.nodes.iter().filter(|node| !node.disabled) {
        let key = match node.makes.first().and_then(|(_, kind)| *kind) {
            Some(Kind::Color) => "color",
            Some(Kind::Weights(_)) => "weights",
            Some(Kind::Field(_)) => "field",
            _ => continue,
        };
        if names.len() < 1000 {
            let whole = format!("{prefix}{}", node.name);
            outputs.insert(format!("node{}", names.len()), json!({ key: whole }));
            names.push(whole);
        }
    }
    document.insert("outputs".into(), outputs.into());
    let loaded = parse_within(name, &Value::Object(document).to_string(), folder, &[], access.clone()).ok()?;
    Some((loaded.graph, names))
}

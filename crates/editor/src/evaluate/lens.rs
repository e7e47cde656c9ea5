//! What to evaluate so that a node can be looked at: a document of just that node and what it depends on, so that faults
//! elsewhere do not matter.

use super::subject::Subject;
use crate::document::{Path, Sheet, json as text};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::path;
use trochoid::{
    CheckedGraph, Diagnostic, EvalError, Format, FormatError, Kind, LoadError, NodeId, RefusedFile, Role, Severity,
    parse, registry,
};

/// The name of the output that a lens looks through.
pub const OUTPUT: &str = "look";

/// Names of nodes that a lens adds; `_` keeps them apart from what users type, numbers from what they might.
const CAMERA: &str = "_lens_camera_1";
const LIGHT: &str = "_lens_light_1";
const VIEW: &str = "_lens_view_1";
const CLAY: &str = "_lens_clay_1";

/// A node seen for itself.
#[derive(Debug)]
pub struct Lens {
    /// The graph, whose only output is [`OUTPUT`].
    pub graph: CheckedGraph,
    /// Its document.
    pub text: String,
    /// Whether what is seen is the node lit like clay, because it is no picture itself.
    pub clay: bool,
}

impl Lens {
    /// The files that it would read at a frame and may not, of each node the first one.
    pub(super) fn refused(&self, frame: i64) -> Vec<RefusedFile> {
        let graph = &self.graph;
        let context = graph.frame_context(frame, u64::MAX);
        let reached = graph.dependencies(graph.outputs().iter().map(|output| output.node), frame);
        let nodes = (0..reached.len()).filter(|index| reached[*index] && !graph.nodes()[*index].disabled);
        nodes.filter_map(|index| graph.refused(NodeId(index), &context)).collect()
    }

    /// Its graph for pictures that are so many times smaller.
    pub(super) fn drawn(&self, shrink: u32, finished: bool) -> Result<Cow<'_, CheckedGraph>, FormatError> {
        if shrink == 1 {
            return Ok(Cow::Borrowed(&self.graph));
        }
        let whole = self.graph.format();
        let side = |side: u32| side.div_ceil(shrink).max(1);
        // A coarse picture is seen for a moment only: one sample a pixel.
        let samples = if finished { whole.samples() } else { 1 };
        let format = Format::new(side(whole.width()), side(whole.height()), samples)?;
        Ok(Cow::Owned(self.graph.clone().with_scaled_format(format.with_shading(whole.shading()))))
    }

    /// An error with the place of the user's document where it has one of the lens, which has all of it on one line.
    pub(super) fn in_document(&self, mut error: EvalError, subject: &Subject) -> EvalError {
        if let EvalError::Node { place, .. } | EvalError::TooMuchMemory { place, .. } = &mut error
            && let Some(there) = self.place_in_document(place, subject)
        {
            *place = there;
        }
        error
    }

    /// The place of the user's document that a place of the lens stands for.
    fn place_in_document(&self, sought: &str, subject: &Subject) -> Option<String> {
        let graph = &self.graph;
        let sheet = &subject.sheet;
        let mut places = vec![(graph.place_of_format(), Path::default().to("format"))];
        for (index, node) in graph.nodes().iter().enumerate().filter(|(_, node)| sheet.find(&node.name).is_some()) {
            let own = Path::node(&node.name);
            let items = node.ty.declaration().items.iter();
            let items = items.map(|item| (graph.place_of(NodeId(index), Some(item.name())), own.to(item.name())));
            // That of the node itself stands for items that are not written.
            places.push((graph.place_of(NodeId(index), None), own.clone()));
            places.extend(items);
        }
        let (_, path) = places.into_iter().find(|(place, _)| place == sought)?;
        let [line, column] = text::place(&sheet.text, &path)?;
        Some(format!("{}:{line}:{column}", subject.name))
    }
}

/// Why an output of a node cannot be looked at.
#[derive(Debug, thiserror::Error)]
pub enum LensError {
    /// It makes something else than pictures.
    #[error("a {0} is no picture: connect it to a Render or a pass, and look at that")]
    NoPicture(Kind),
    /// The node has a type that there is not.
    #[error("nobody knows what \"{0}\" makes: its type is unknown")]
    Unknown(String),
    /// It, or something that it depends on, has a fault.
    #[error("{}found {}; expected {}", .0.node.as_deref().map_or(String::new(), |node| format!("{node}: ")), .0.found, .0.expected)]
    Fault(Box<Diagnostic>),
    /// Its document cannot be read.
    #[error(transparent)]
    Load(LoadError),
}

/// A graph that shows an output of a node.
///
/// # Errors
/// The node makes nothing that can be seen, or it or something that it depends on has a fault.
pub fn lens(sheet: &Sheet, node: usize, output: usize, name: &str, folder: &path::Path) -> Result<Lens, LensError> {
    let mut nodes = Map::new();
    let mut closure: Vec<usize> = sheet.upstream([node]).into_iter().collect();
    closure.sort_unstable();
    for index in closure {
        let name = &sheet.nodes[index].name;
        nodes.insert(name.clone(), sheet.get(&Path::node(name)).cloned().unwrap_or_default());
    }
    let shown = &sheet.nodes[node];
    let kind = shown.makes.get(output).and_then(|(_, kind)| *kind);
    let reference = sheet.reference(node, output);
    let (key, source) = match kind {
        Some(Kind::Color) => ("color", reference),
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
    let clay = matches!(kind, Some(Kind::View | Kind::Surface));
    let mut document = Map::new();
    for key in ["trochoid", "format", "working_space", "frames", "tolerance"] {
        if let Some(value) = sheet.value.get(key) {
            document.insert(key.into(), value.clone());
        }
    }
    document.insert("nodes".into(), nodes.into());
    document.insert("outputs".into(), json!({ OUTPUT: { key: source } }));
    let text = Value::Object(document).to_string();
    match parse(name, &text, folder, &[]) {
        Ok(loaded) => Ok(Lens { graph: loaded.graph, text, clay }),
        Err(LoadError::Invalid(diagnostics)) => {
            let errors = diagnostics.into_iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
            // The node's own fault before those above it.
            let worst = errors.min_by_key(|diagnostic| diagnostic.node.as_deref() != Some(shown.name.as_str()));
            let none = || LensError::Load(LoadError::Invalid(Vec::new()));
            Err(worst.map_or_else(none, |fault| LensError::Fault(Box::new(fault))))
        }
        Err(error) => Err(LensError::Load(error)),
    }
}

/// The name of the type that has a role.
fn ty(role: Role) -> &'static str {
    registry().of_role(role).map_or("", |ty| ty.declaration().name)
}

/// The first node of a role in the document.
fn borrowed(sheet: &Sheet, role: Role) -> Option<String> {
    sheet.nodes.iter().find(|node| node.is(role) && !node.disabled).map(|node| node.name.clone())
}

/// Brings the document's first node of a role, and whatever it depends on; whether there is one.
fn borrow(sheet: &Sheet, role: Role, nodes: &mut Map<String, Value>) -> bool {
    let Some(found) = borrowed(sheet, role).and_then(|name| sheet.find(&name)) else { return false };
    for index in sheet.upstream([found]) {
        let name = &sheet.nodes[index].name;
        nodes.entry(name.clone()).or_insert_with(|| sheet.get(&Path::node(name)).cloned().unwrap_or_default());
    }
    true
}

/// Lights a view like clay.
fn clay(sheet: &Sheet, view: String, nodes: &mut Map<String, Value>) -> (&'static str, String) {
    if !borrow(sheet, Role::Light, nodes) {
        nodes.insert(LIGHT.into(), json!({ "type": ty(Role::Light), "direction": [0.5, 0.6, 0.4] }));
    }
    let light = borrowed(sheet, Role::Light).unwrap_or(LIGHT.into());
    nodes.insert(CLAY.into(), json!({ "type": ty(Role::Clay), "view": view, "lights": [light] }));
    ("field", CLAY.into())
}

/// A graph with an output for every node that can be seen, named after it, so that all are made at once; `None` where the
/// document is invalid. Nodes beyond the first thousand go without.
pub(super) fn of_every_node(sheet: &Sheet, name: &str, folder: &path::Path) -> Option<CheckedGraph> {
    let mut document = sheet.value.as_object()?.clone();
    let mut outputs = Map::new();
    for node in sheet.nodes.iter().filter(|node| !node.disabled) {
        let key = match node.makes.first().and_then(|(_, kind)| *kind) {
            Some(Kind::Color) => "color",
            Some(Kind::Weights(_)) => "weights",
            Some(Kind::Field(_)) => "field",
            _ => continue,
        };
        if outputs.len() < 1000 {
            outputs.insert(node.name.clone(), json!({ key: node.name }));
        }
    }
    document.insert("outputs".into(), outputs.into());
    parse(name, &Value::Object(document).to_string(), folder, &[]).ok().map(|loaded| loaded.graph)
}

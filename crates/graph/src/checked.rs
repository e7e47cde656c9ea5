//! Validated graphs. Having one proves that only input and output, bad data, memory or cancellation can stop its
//! evaluation.

use crate::Tolerance;
use crate::{
    Access, Animated, DocumentPlace, FrameContext, FrameTimes, Item, Kind, KnobType, NodeId, NodeType, Recipes, Record,
    Setting, Settled, Work,
};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use trochoid_image::{Format, WorkingSpace};
use trochoid_key::{ContentKey, Key, KeyHasher};

/// A color that a document names.
#[derive(Clone, Debug, PartialEq)]
pub struct PaletteColor {
    /// Name in the document.
    pub name: String,
    /// The color in the working space.
    pub color: Animated,
    /// Place of the name, in the document or in a palette file.
    pub place: DocumentPlace,
    /// Places that use the color, in the order of the document.
    pub uses: Vec<PaletteUse>,
}

/// Place that uses a color by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaletteUse {
    /// The node.
    pub node: NodeId,
    /// Port or knob of the node, such as `a`, `colors[2]` or `stops[1].color`.
    pub item: String,
    /// Whether the color stands there by itself, not in a key.
    pub is_whole: bool,
}

/// A knob of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DocumentKnob {
    /// Name in the document.
    pub name: String,
    /// Place of its value, in the document.
    pub place: DocumentPlace,
    /// Ports that take its value as it is: node, and port such as `a`, `colors[2]` or `stops[1].color`.
    pub ports: Vec<(NodeId, String)>,
    /// Whether anything takes it.
    pub is_used: bool,
    /// Whether nothing else takes it: no formula, no knob of a node, no output.
    pub is_whole: bool,
}

/// A checked node.
#[derive(Clone)]
pub struct CheckedNode {
    /// Name in the document.
    pub name: String,
    /// Node type.
    pub ty: &'static NodeType,
    /// Knobs and connections.
    pub record: Record,
    /// Kinds of its outputs.
    pub kinds: Vec<Kind>,
    /// Whether the document disables the node; then nothing is connected to it.
    pub disabled: bool,
    /// Place in the document, or in one that it includes.
    pub place: DocumentPlace,
    /// Place of the value of each item that the document sets.
    pub places: Vec<(&'static str, DocumentPlace)>,
}

impl CheckedNode {
    /// Returns the place of an item's value; that of the node if the document does not set it.
    pub fn place_of(&self, item: &str) -> &DocumentPlace {
        self.places.iter().find(|known| known.0 == item).map_or(&self.place, |known| &known.1)
    }

    /// Whether an assignment outside of the document, such as `--set`, sets an item.
    pub fn is_assigned(&self, item: &str) -> bool {
        // Then the item has a value but no place in the document.
        !self.places.iter().any(|known| known.0 == item)
            && self.record.knobs.iter().any(|(name, value)| *name == item && *value != Setting::Unset)
    }

    /// Returns the knob that names a file, if the node has one.
    pub fn file_item(&self) -> Option<&'static str> {
        self.ty.declaration().items.iter().find_map(|item| match item {
            Item::Knob(knob) if matches!(knob.takes, KnobType::Path) => Some(knob.name),
            _ => None,
        })
    }
}

impl std::fmt::Debug for CheckedNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} \"{}\"", self.ty.declaration().name, self.name)
    }
}

/// A set that the colors of an output cannot leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Guarantee {
    /// Each channel stays between its smallest and largest control.
    Box,
    /// Colors stay in the convex hull of the controls.
    Hull,
}

impl Guarantee {
    /// Returns the word in documents and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Hull => "hull",
        }
    }

    /// Returns the guarantee with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Box, Self::Hull].into_iter().find(|guarantee| guarantee.name() == name)
    }
}

/// Sample format of an output in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 16-bit float, EXR.
    Half,
    /// 32-bit float, EXR.
    Float,
    /// 8-bit, PNG.
    Uint8,
    /// 16-bit, PNG.
    Uint16,
}

impl Precision {
    /// Words in documents.
    pub const NAMES: [&str; 4] = ["half", "float", "uint8", "uint16"];

    /// Returns the word in documents.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Returns the precision with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Half, Self::Float, Self::Uint8, Self::Uint16].into_iter().find(|precision| precision.name() == name)
    }

    /// Whether the precision is one of PNG, with integers.
    pub fn is_integer(self) -> bool {
        matches!(self, Self::Uint8 | Self::Uint16)
    }
}

/// One output of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// Name of the output.
    pub name: String,
    /// Node that the output shows.
    pub node: NodeId,
    /// Index among the outputs of that node.
    pub output: usize,
    /// Kind of the value.
    pub kind: Kind,
    /// Whether the file gets the weights of the color instead of the color.
    pub is_recipe: bool,
    /// Path of the file, relative to the document.
    pub file: Option<String>,
    /// Name of the layer in the file.
    pub layer: Option<String>,
    /// Sample format in the file; by default half for EXR (float for Fields), 8 bits for PNG.
    pub precision: Option<Precision>,
    /// Guarantee without which the command fails.
    pub require: Option<Guarantee>,
    /// Line and column of `file` in the document, or of the output if it has no file.
    pub place: [usize; 2],
}

/// State of a file: path, length and time of the last change. Files with equal states count as equal.
pub type FileState = (PathBuf, Option<(u64, Option<SystemTime>)>);

/// A use of a group. Its nodes have names that begin with its path and a slash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupUse {
    /// Names from the outermost use to this one, with slashes between them.
    pub path: String,
    /// Name of the group.
    pub group: String,
    /// Place of the use.
    pub place: DocumentPlace,
}

/// Returns the states of files, for example of those that a node reads.
pub fn file_states(files: &[PathBuf]) -> Vec<FileState> {
    let state = |path: &PathBuf| {
        let found = std::fs::metadata(path).ok();
        (path.clone(), found.map(|found| (found.len(), found.modified().ok())))
    };
    files.iter().map(state).collect()
}

/// A validated graph. Only [`crate::check()`] makes one.
#[derive(Clone, Debug)]
pub struct CheckedGraph {
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    pub(crate) format: Format,
    /// The document's own format, from which `format` differs in proxies and previews; `None` if it states none.
    pub(crate) document_format: Option<Format>,
    pub(crate) format_place: [usize; 2],
    pub(crate) space: WorkingSpace,
    pub(crate) palette: Vec<PaletteColor>,
    pub(crate) knobs: Vec<DocumentKnob>,
    pub(crate) document_files: Vec<PathBuf>,
    pub(crate) first: i64,
    pub(crate) last: i64,
    pub(crate) fps: f64,
    pub(crate) tolerance: Option<Tolerance>,
    pub(crate) nodes: Vec<CheckedNode>,
    pub(crate) groups: Vec<GroupUse>,
    pub(crate) outputs: Vec<OutputSpec>,
    pub(crate) order: Vec<NodeId>,
    pub(crate) canonical: String,
    pub(crate) access: Access,
    pub(crate) recipes: Option<Recipes>,
}

impl CheckedGraph {
    /// Returns the name of the document.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the folder that paths are relative to.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the format of the pictures.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Sets another format, for proxies and previews.
    pub fn with_format(mut self, format: Format) -> Self {
        self.format = format;
        self
    }

    /// Returns the color space in which colors mix.
    pub fn space(&self) -> WorkingSpace {
        self.space
    }

    /// Returns the colors that the document names, in its order.
    pub fn palette(&self) -> &[PaletteColor] {
        &self.palette
    }

    /// Returns the document's knobs, in its order.
    pub fn knobs(&self) -> &[DocumentKnob] {
        &self.knobs
    }

    /// Returns the other files of which the document consists: those that colors of the palette come from, and included
    /// documents.
    pub fn document_files(&self) -> &[PathBuf] {
        &self.document_files
    }

    /// Returns the first and the last frame.
    pub fn frames(&self) -> (i64, i64) {
        (self.first, self.last)
    }

    /// Returns the frames per second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// Returns the times of all frames.
    pub fn times(&self) -> FrameTimes {
        FrameTimes { count: self.first.abs_diff(self.last).saturating_add(1), fps: self.fps }
    }

    /// Returns the accuracy that the document requires of pictures, if any.
    pub fn tolerance(&self) -> Option<Tolerance> {
        self.tolerance
    }

    /// Returns all nodes; a [`NodeId`] is an index into this slice.
    pub fn nodes(&self) -> &[CheckedNode] {
        &self.nodes
    }

    /// Returns the uses of groups, whose nodes are among the graph's, each before those within it.
    pub fn groups(&self) -> &[GroupUse] {
        &self.groups
    }

    /// Returns a node.
    pub fn node(&self, id: NodeId) -> &CheckedNode {
        &self.nodes[id.0]
    }

    /// Returns the place of a node, or of one of its items: document, line and column.
    pub fn place_of(&self, id: NodeId, item: Option<&str>) -> DocumentPlace {
        let node = self.node(id);
        item.map_or(&node.place, |item| node.place_of(item)).clone()
    }

    /// Returns the place of the format: document, line and column.
    pub fn place_of_format(&self) -> DocumentPlace {
        let [line, column] = self.format_place;
        DocumentPlace { document: self.name.as_str().into(), line, column }
    }

    /// Returns the node with a name.
    pub fn find(&self, name: &str) -> Option<NodeId> {
        self.nodes.iter().position(|node| node.name == name).map(NodeId)
    }

    /// Returns all outputs.
    pub fn outputs(&self) -> &[OutputSpec] {
        &self.outputs
    }

    /// Returns all nodes, inputs before the nodes that use them. The order depends on the connections and the names of
    /// outputs, not on the names of nodes or their places in the document.
    pub fn order(&self) -> &[NodeId] {
        &self.order
    }

    /// Returns the canonical text of the document, see [`Document::canonical`](crate::Document::canonical).
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// Returns a hash of everything in the document that evaluation depends on, as 64 hexadecimal digits.
    pub fn document_hash(&self) -> String {
        blake3::hash(self.canonical.as_bytes()).to_hex().to_string()
    }

    /// Returns the data that all nodes share at a frame.
    pub fn frame_context(&self, frame: i64, memory_limit: u64) -> FrameContext {
        FrameContext {
            frame,
            time: (frame - self.first) as f64 / self.fps,
            format: self.format,
            document_format: self.document_format.unwrap_or(self.format),
            space: self.space,
            folder: self.folder.clone(),
            memory_limit,
            access: self.access.clone(),
        }
    }

    /// Returns the nodes, by name, that take longer than [`Work::HEAVY_SECONDS`] at a frame, with their work.
    pub fn heavy(&self, frame: i64) -> Vec<(&str, Work)> {
        let time = self.frame_context(frame, u64::MAX).time;
        let needed = self.dependencies(self.outputs.iter().map(|output| output.node), frame);
        let nodes = self.nodes.iter().enumerate().filter(|(index, _)| needed[*index]);
        let work = nodes.filter_map(|(index, node)| {
            Some((node.name.as_str(), self.settle(NodeId(index), frame).node().work(self.format, time)?))
        });
        work.filter(|(_, work)| work.is_heavy()).collect()
    }

    /// Returns a node at a frame.
    pub fn settle(&self, id: NodeId, frame: i64) -> Settled {
        let node = &self.nodes[id.0];
        node.ty.settle(node.record.settle(frame as f64))
    }

    /// Marks the roots and all nodes upstream of them.
    pub fn upstream(&self, roots: impl IntoIterator<Item = NodeId>) -> Vec<bool> {
        self.walk(roots, |id, open| self.nodes[id.0].record.each_node(|node| open.push(node)))
    }

    /// Marks the roots and all nodes that they depend on at a frame. A node that passes one of its inputs through
    /// depends only on that input.
    pub fn dependencies(&self, roots: impl IntoIterator<Item = NodeId>, frame: i64) -> Vec<bool> {
        self.walk(roots, |id, open| {
            let settled = self.settle(id, frame);
            settled.each_needed(|node| open.push(node));
        })
    }

    fn walk(
        &self,
        roots: impl IntoIterator<Item = NodeId>,
        mut inputs: impl FnMut(NodeId, &mut Vec<NodeId>),
    ) -> Vec<bool> {
        let mut seen = vec![false; self.nodes.len()];
        let mut open: Vec<NodeId> = roots.into_iter().collect();
        while let Some(id) = open.pop() {
            if !std::mem::replace(&mut seen[id.0], true) {
                inputs(id, &mut open);
            }
        }
        seen
    }

    /// Returns the files that the nodes marked in `needed` read at a frame, sorted and without duplicates.
    pub fn files(&self, needed: &[bool], context: &FrameContext) -> Vec<PathBuf> {
        let nodes = (0..self.nodes.len()).filter(|index| needed[*index]).map(NodeId);
        let mut files: Vec<PathBuf> = nodes.flat_map(|id| self.files_of(id, context)).collect();
        files.sort();
        files.dedup();
        files
    }

    /// Returns the files that a node reads at a frame.
    pub fn files_of(&self, id: NodeId, context: &FrameContext) -> Vec<PathBuf> {
        self.settle(id, context.frame).stage().map_or_else(Vec::new, |stage| stage.files(context))
    }

    /// Returns the content keys at a frame of all nodes that are in `settled`: equal keys mean equal results.
    ///
    /// A key covers the node's type and revision, the knobs at the frame, the keys of everything connected, and time
    /// and format if the node depends on them. Files count by path, length and time of change. A connected node that
    /// is not in `settled` counts as nothing: its result must not matter.
    pub fn keys(&self, settled: &[Option<Settled>], context: &FrameContext) -> Vec<Key> {
        let mut keys = vec![Key::default(); self.nodes.len()];
        for &id in &self.order {
            let Some(settled) = &settled[id.0] else { continue };
            let ty = self.nodes[id.0].ty;
            let declaration = ty.declaration();
            let mut hasher = KeyHasher::new();
            (declaration.name, declaration.revision, self.space).feed(&mut hasher);
            settled.feed(&keys, &mut hasher);
            if let Some(stage) = settled.stage() {
                stage.depends_on_time().then_some(context.time).feed(&mut hasher);
                stage.depends_on_format().then_some((context.format, context.document_format)).feed(&mut hasher);
                file_states(&stage.files(context)).feed(&mut hasher);
            }
            keys[id.0] = hasher.finish();
        }
        keys
    }
}

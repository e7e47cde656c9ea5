//! A validated graph: having one is the proof that only input and output, bad data, memory or cancellation
//! can stop its evaluation.

use crate::Tolerance;
use crate::{Access, FrameContext, Item, Kind, NodeId, NodeType, Record, Setting, Settled, Takes, Work};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use trochoid_image::{Format, WorkingSpace};
use trochoid_key::{ContentKey, Key, KeyHasher};

/// A checked node.
#[derive(Clone)]
pub struct CheckedNode {
    /// Name in the document.
    pub name: String,
    /// Its type.
    pub ty: &'static NodeType,
    /// Knobs and connections.
    pub record: Record,
    /// Kinds of its outputs.
    pub kinds: Vec<Kind>,
    /// Whether the document disables it; nothing is connected to it then.
    pub disabled: bool,
    /// Line and column in the document.
    pub place: [usize; 2],
    /// Line and column of the value of each item that is written there.
    pub places: Vec<(&'static str, [usize; 2])>,
}

impl CheckedNode {
    /// Line and column of an item's value in the document; those of the node where it is not written.
    pub fn place_of(&self, item: &str) -> [usize; 2] {
        self.places.iter().find(|known| known.0 == item).map_or(self.place, |known| known.1)
    }

    /// Whether an assignment beside the document, such as `--set`, sets an item.
    pub fn is_assigned(&self, item: &str) -> bool {
        // It stands nowhere in the document then.
        !self.places.iter().any(|known| known.0 == item)
            && self.record.knobs.iter().any(|(name, value)| *name == item && *value != Setting::Unset)
    }

    /// The knob that names a file, if it has one.
    pub fn file_item(&self) -> Option<&'static str> {
        self.ty.declaration().items.iter().find_map(|item| match item {
            Item::Knob(knob) if matches!(knob.takes, Takes::Path) => Some(knob.name),
            _ => None,
        })
    }
}

impl std::fmt::Debug for CheckedNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} \"{}\"", self.ty.declaration().name, self.name)
    }
}

/// What cannot be left by an output's colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Guarantee {
    /// Each channel stays between its least and greatest control.
    Box,
    /// Colors stay in the convex hull of the controls.
    Hull,
}

impl Guarantee {
    /// The word in documents and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Hull => "hull",
        }
    }

    /// The guarantee of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Box, Self::Hull].into_iter().find(|guarantee| guarantee.name() == name)
    }
}

/// How an output's samples are stored.
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
    /// The words in documents.
    pub const NAMES: [&str; 4] = ["half", "float", "uint8", "uint16"];

    /// The word in documents.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The precision of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Half, Self::Float, Self::Uint8, Self::Uint16].into_iter().find(|precision| precision.name() == name)
    }

    /// Whether it is one of PNG's.
    pub fn is_integer(self) -> bool {
        matches!(self, Self::Uint8 | Self::Uint16)
    }
}

/// One output of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// Its name.
    pub name: String,
    /// The node that it shows.
    pub node: NodeId,
    /// Index of that node's output.
    pub output: usize,
    /// Kind of the value.
    pub kind: Kind,
    /// Where it is written, relative to the document.
    pub file: Option<String>,
    /// Name of its layer in the file.
    pub layer: Option<String>,
    /// How it is stored; by default half for EXR, 8 bits for PNG.
    pub precision: Option<Precision>,
    /// What must hold, or the command fails.
    pub require: Option<Guarantee>,
    /// Line and column of `file` in the document, or of the output where there is none.
    pub place: [usize; 2],
}

/// A file by its path, its length and the time of its last change: one that has the same ones is the same.
pub type FileState = (PathBuf, Option<(u64, Option<SystemTime>)>);

/// The states of files, such as a node reads.
pub fn file_states(files: &[PathBuf]) -> Vec<FileState> {
    let state = |path: &PathBuf| {
        let found = std::fs::metadata(path).ok();
        (path.clone(), found.map(|found| (found.len(), found.modified().ok())))
    };
    files.iter().map(state).collect()
}

/// A validated graph. Made by [`crate::check()`] only.
#[derive(Clone, Debug)]
pub struct CheckedGraph {
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    pub(crate) format: Format,
    /// The document's own.
    pub(crate) whole: Format,
    pub(crate) format_place: [usize; 2],
    pub(crate) space: WorkingSpace,
    pub(crate) first: i64,
    pub(crate) last: i64,
    pub(crate) fps: f64,
    pub(crate) tolerance: Option<Tolerance>,
    pub(crate) nodes: Vec<CheckedNode>,
    pub(crate) outputs: Vec<OutputSpec>,
    pub(crate) order: Vec<NodeId>,
    pub(crate) canonical: String,
    pub(crate) access: Access,
}

impl CheckedGraph {
    /// The document's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder that paths are relative to.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The pictures' format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The same graph at another format, for proxies and previews.
    pub fn with_format(mut self, format: Format) -> Self {
        self.format = format;
        self
    }

    /// The space in which colors mix.
    pub fn space(&self) -> WorkingSpace {
        self.space
    }

    /// First and last frame.
    pub fn frames(&self) -> (i64, i64) {
        (self.first, self.last)
    }

    /// Frames per second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// How accurate pictures are asked to be, where the document says so.
    pub fn tolerance(&self) -> Option<Tolerance> {
        self.tolerance
    }

    /// All nodes; a [`NodeId`] is an index here.
    pub fn nodes(&self) -> &[CheckedNode] {
        &self.nodes
    }

    /// A node.
    pub fn node(&self, id: NodeId) -> &CheckedNode {
        &self.nodes[id.0]
    }

    /// Where a node stands, or one of its items: document, line and column.
    pub fn place_of(&self, id: NodeId, item: Option<&str>) -> String {
        let node = self.node(id);
        let [line, column] = item.map_or(node.place, |item| node.place_of(item));
        format!("{}:{line}:{column}", self.name)
    }

    /// Where the document says how large pictures are: document, line and column.
    pub fn place_of_format(&self) -> String {
        let [line, column] = self.format_place;
        format!("{}:{line}:{column}", self.name)
    }

    /// The node of that name.
    pub fn find(&self, name: &str) -> Option<NodeId> {
        self.nodes.iter().position(|node| node.name == name).map(NodeId)
    }

    /// All outputs.
    pub fn outputs(&self) -> &[OutputSpec] {
        &self.outputs
    }

    /// All nodes, inputs before those that use them.
    pub fn order(&self) -> &[NodeId] {
        &self.order
    }

    /// The document's meaning as text, see [`Document::canonical`](crate::Document::canonical).
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// A hash of everything in the document that evaluation depends on, 64 hexadecimal digits.
    pub fn document_hash(&self) -> String {
        blake3::hash(self.canonical.as_bytes()).to_hex().to_string()
    }

    /// What all nodes share at a frame.
    pub fn frame_context(&self, frame: i64, memory_limit: u64) -> FrameContext {
        FrameContext {
            frame,
            time: (frame - self.first) as f64 / self.fps,
            format: self.format,
            whole: self.whole,
            space: self.space,
            folder: self.folder.clone(),
            memory_limit,
            access: self.access.clone(),
        }
    }

    /// What nodes take so long at a frame that it should be said, see [`Work::MOST`]: each with its name.
    pub fn heavy(&self, frame: i64) -> Vec<(&str, Work)> {
        let time = self.frame_context(frame, u64::MAX).time;
        let needed = self.reached(self.outputs.iter().map(|output| output.node), frame);
        let nodes = self.nodes.iter().enumerate().filter(|(index, _)| needed[*index]);
        let work = nodes.filter_map(|(index, node)| {
            Some((node.name.as_str(), self.settle(NodeId(index), frame).node().work(self.format, time)?))
        });
        work.filter(|(_, work)| work.is_heavy()).collect()
    }

    /// A node at a frame.
    pub fn settle(&self, id: NodeId, frame: i64) -> Settled {
        let node = &self.nodes[id.0];
        node.ty.settle(node.record.settle(frame as f64))
    }

    /// Everything that is connected to the roots, themselves included.
    pub fn upstream(&self, roots: impl IntoIterator<Item = NodeId>) -> Vec<bool> {
        self.walk(roots, |id, open| self.nodes[id.0].record.each_node(|node| open.push(node)))
    }

    /// Everything that the roots depend on at a frame, themselves included: of a node that hands one of its inputs on,
    /// only that input.
    pub fn reached(&self, roots: impl IntoIterator<Item = NodeId>, frame: i64) -> Vec<bool> {
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

    /// Files that any node in `needed` reads at a frame.
    pub fn files(&self, needed: &[bool], context: &FrameContext) -> Vec<PathBuf> {
        let nodes = (0..self.nodes.len()).filter(|index| needed[*index]).map(NodeId);
        let mut files: Vec<PathBuf> = nodes.flat_map(|id| self.files_of(id, context)).collect();
        files.sort();
        files.dedup();
        files
    }

    /// Files that a node reads at a frame.
    pub fn files_of(&self, id: NodeId, context: &FrameContext) -> Vec<PathBuf> {
        self.settle(id, context.frame).stage().map_or_else(Vec::new, |stage| stage.files(context))
    }

    /// Content keys at a frame of all nodes that have their knobs in `settled`: equal keys mean equal results.
    ///
    /// A key covers type and its revision, knobs at the frame, the keys of everything connected, and, where
    /// the node says that it depends on them, time and format. Files count by path, length and time of change. A
    /// connected node without knobs in `settled` counts as nothing: its result must not matter.
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
                stage.timed().then_some(context.time).feed(&mut hasher);
                stage.formatted().then_some((context.format, context.whole)).feed(&mut hasher);
                file_states(&stage.files(context)).feed(&mut hasher);
            }
            keys[id.0] = hasher.finish();
        }
        keys
    }
}

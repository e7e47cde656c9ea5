//! The contract between nodes and engine.
//!
//! A node type is one value that implements [`NodeType`]: its declaration, the checks that one knob's range
//! cannot express, and its body. A body is either [`Pointwise`] (it lowers to the closed program) or a
//! [`Stage`] (it prepares once a frame, then fills tiles).
//!
//! An implementor **must** be deterministic, give the same value at a sample whatever the tile, and fill
//! exactly the planes asked for. It **may** keep what `prepare` made. It **must not** read clocks, global
//! state or files outside `prepare`.

use crate::{Builder, ChannelSet, Declaration, Kind, NodeId, Settled, Source, Value, ViewChannel};
use std::any::Any;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trochoid_image::{Format, Rgb, Window, WorkingSpace};

/// A type of node.
pub trait NodeType: Send + Sync + 'static {
    /// Knobs, ports, outputs and documentation.
    fn declaration(&self) -> &'static Declaration;

    /// Kinds of the outputs, where knobs or connections decide them; by default as declared.
    fn outputs(&self, node: &Settled) -> Vec<Kind> {
        let _ = node;
        self.declaration().outputs.iter().map(|output| output.kind).collect()
    }

    /// Reports what ranges of single knobs cannot express. Called at every key frame.
    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let _ = (node, check);
    }

    /// What a user may want to know of the node at a frame, in sentences: shown by `trochoid check`.
    fn notes(&self, node: &Settled) -> Vec<String> {
        let _ = node;
        Vec::new()
    }

    /// How the node computes.
    fn body(&self) -> Body<'_>;
}

/// How a node computes.
pub enum Body<'a> {
    /// Each output sample depends on the input samples at the same place, by operations of the closed program.
    Pointwise(&'a dyn Pointwise),
    /// Anything else.
    Stage(&'a dyn Stage),
}

/// A back-end node that lowers to the closed program.
pub trait Pointwise {
    /// Appends the node's operations and returns its output.
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value;

    /// The same in f64 at one sample, straight from the formula.
    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference;
}

/// A front-end node, or a filter: prepares once a frame, then fills tiles.
pub trait Stage {
    /// Channels that the node asks of its view, where the given outputs are wanted.
    fn asks(&self, node: &Settled, wanted: &[bool]) -> ChannelSet {
        let _ = (node, wanted);
        ChannelSet::EMPTY
    }

    /// Channels that the node uses where its view supplies them, and does without elsewhere.
    fn prefers(&self, node: &Settled, wanted: &[bool]) -> ChannelSet {
        let _ = (node, wanted);
        ChannelSet::EMPTY
    }

    /// Channels that a node with a View as output can supply.
    fn supplies(&self, node: &Settled) -> ChannelSet {
        let _ = node;
        ChannelSet::of(ViewChannel::ALL)
    }

    /// Certain bounds of an output channel, known before anything is prepared.
    fn interval(&self, node: &Settled, output: usize, channel: usize) -> Option<(f64, f64)> {
        let _ = (node, output, channel);
        None
    }

    /// How an output varies over the picture.
    fn variance(&self, node: &Settled, output: usize) -> Variance {
        let _ = (node, output);
        Variance::Pixel
    }

    /// Whether the result depends on the frame's time even where no knob is keyed.
    fn timed(&self) -> bool {
        false
    }

    /// Whether the result depends on the picture's format.
    fn formatted(&self) -> bool {
        true
    }

    /// Files that the node reads at a frame, for keys and `--resume`.
    fn files(&self, node: &Settled, frame: &FrameContext) -> Vec<PathBuf> {
        let _ = (node, frame);
        Vec::new()
    }

    /// Does once a frame what does not depend on the tile: simulate, build, decode.
    ///
    /// # Errors
    /// Files cannot be read, or their data break the contract of the kind.
    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError>;
}

/// What a stage prepared for one frame.
pub trait Prepared: Send + Sync {
    /// The surface, camera or light that other nodes take.
    fn handle(&self) -> Option<Handle> {
        None
    }

    /// Every color that this node adds to the palette.
    fn controls(&self) -> Vec<Rgb> {
        Vec::new()
    }

    /// Fills the planes asked for over one block of samples.
    ///
    /// # Errors
    /// Inputs break the contract of their kind at some pixel.
    fn fill(&self, block: &Block, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let _ = (block, inputs, outputs);
        Ok(())
    }

    /// All outputs in f64 at one sample, straight from the formula.
    ///
    /// # Errors
    /// As [`Prepared::fill`].
    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError>;

    /// Values set to the nearest legal one because the document says `repair`.
    fn repaired(&self) -> u64 {
        0
    }

    /// Memory held, bytes.
    fn bytes(&self) -> usize {
        0
    }
}

/// What a front-end node makes and another takes: a surface, a camera or a light.
pub type Handle = Arc<dyn Any + Send + Sync>;

/// How a value varies over the picture; ordered from least to most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variance {
    /// The same everywhere.
    Constant,
    /// Depends on x alone.
    Column,
    /// Depends on y alone.
    Row,
    /// Depends on both.
    Pixel,
}

impl Variance {
    /// How something varies that depends on both.
    pub fn join(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant, other) => other,
            (this, Self::Constant) => this,
            (this, other) if this == other => this,
            _ => Self::Pixel,
        }
    }
}

/// Why a node could not evaluate: bad input data, or input and output.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct NodeError {
    /// Place, what was found, what was expected, and what to do.
    pub message: String,
}

impl NodeError {
    /// An error from anything that can be shown.
    pub fn new(message: impl ToString) -> Self {
        Self { message: message.to_string() }
    }
}

/// What all nodes of one frame share.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameContext {
    /// The frame's number.
    pub frame: i64,
    /// Seconds since the first frame.
    pub time: f64,
    /// The document's picture format.
    pub format: Format,
    /// The document's working space.
    pub space: WorkingSpace,
    /// Folder that paths in the document are relative to.
    pub folder: PathBuf,
    /// Most memory that decoding one file may take, bytes.
    pub memory_limit: u64,
}

impl FrameContext {
    /// A path of the document, with `####` and `%04d` replaced by the frame.
    pub fn path(&self, text: &str) -> PathBuf {
        let text = expand_frame(text, self.frame);
        let path = Path::new(&text);
        if path.is_absolute() { path.into() } else { self.folder.join(path) }
    }
}

/// Replaces the first run of `#`, or the first `%0Nd`, by the frame's number, padded with zeros.
///
/// ```
/// use trochoid_graph::expand_frame;
/// assert_eq!(expand_frame("a.####.exr", 12), "a.0012.exr");
/// assert_eq!(expand_frame("a.%03d.exr", 12), "a.012.exr");
/// assert_eq!(expand_frame("a.exr", 12), "a.exr");
/// ```
pub fn expand_frame(pattern: &str, frame: i64) -> String {
    let pad = |width: usize| {
        let sign = if frame < 0 { "-" } else { "" };
        format!("{sign}{:0width$}", frame.unsigned_abs())
    };
    if let Some(start) = pattern.find('#') {
        let width = pattern[start..].chars().take_while(|&c| c == '#').count();
        return format!("{}{}{}", &pattern[..start], pad(width), &pattern[start + width..]);
    }
    if let Some(start) = pattern.find('%')
        && let Some(end) = pattern[start..].find('d').map(|at| start + at)
        && let Ok(width) = pattern[start + 1..end].parse::<usize>()
        && width <= 16
    {
        return format!("{}{}{}", &pattern[..start], pad(width), &pattern[end + 1..]);
    }
    pattern.into()
}

/// What [`Stage::prepare`] is given.
pub struct Prepare<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// For each output, which of its channels are wanted.
    pub wanted: &'a [Vec<bool>],
    handles: &'a dyn Fn(NodeId) -> Option<Handle>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Prepare<'a> {
    /// Made by the engine.
    pub fn new(
        frame: &'a FrameContext,
        wanted: &'a [Vec<bool>],
        handles: &'a dyn Fn(NodeId) -> Option<Handle>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        Self { frame, wanted, handles, cancelled }
    }

    /// The handles of everything connected to a port, as `T`.
    ///
    /// # Errors
    /// The connected node hands on something else: a bug of that node, reported rather than hidden.
    pub fn handles<T: Clone + 'static>(&self, node: &Settled, port: &str) -> Result<Vec<T>, NodeError> {
        node.all(port)
            .iter()
            .filter_map(|source| if let Source::Output { node, .. } = source { Some(*node) } else { None })
            .map(|id| {
                (self.handles)(id).and_then(|handle| handle.downcast_ref::<T>().cloned()).ok_or_else(|| {
                    NodeError::new(format!("\"{port}\" is connected to a node that hands on nothing usable"))
                })
            })
            .collect()
    }

    /// The handle of the first node connected to a port, whatever it holds; `None` where the port is open.
    pub fn handle_of(&self, node: &Settled, port: &str) -> Option<Handle> {
        match node.all(port).first() {
            Some(Source::Output { node, .. }) => (self.handles)(*node),
            _ => None,
        }
    }

    /// Whether the user has asked to stop.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }
}

/// A block of samples: one sample of each pixel of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The pixels.
    pub window: Window,
    /// Where in its pixel the sample lies, from the upper left corner, in pixels.
    pub offset: [f64; 2],
}

/// The channels of one connection over a block, each where asked for.
pub type Connection<'a> = Vec<Option<&'a [f32]>>;

/// The planes connected to a stage's ports over a block, row by row.
pub struct Inputs<'a> {
    planes: &'a [(&'static str, Vec<Connection<'a>>)],
}

impl<'a> Inputs<'a> {
    /// Made by the engine: for each port, for each connection, for each channel, its plane where asked for.
    pub fn new(planes: &'a [(&'static str, Vec<Connection<'a>>)]) -> Self {
        Self { planes }
    }

    /// The channels of connection `index` of a port.
    ///
    /// # Panics
    /// The node declares no such port, or has no such connection.
    pub fn planes(&self, port: &str, index: usize) -> &[Option<&'a [f32]>] {
        match self.planes.iter().find(|(name, _)| *name == port) {
            Some((_, connections)) => &connections[index],
            None => unreachable!("the node type does not declare \"{port}\""),
        }
    }

    /// A channel of the view connected to a port that the node prefers, where the view supplies it.
    pub fn view_if_any(&self, port: &str, channel: ViewChannel) -> Option<&'a [f32]> {
        self.planes(port, 0)[channel as usize]
    }

    /// A channel of the view connected to a port.
    ///
    /// # Panics
    /// The node did not ask for it: a bug of that node, caught by its first test.
    pub fn view(&self, port: &str, channel: ViewChannel) -> &'a [f32] {
        match self.planes(port, 0)[channel as usize] {
            Some(plane) => plane,
            None => unreachable!("the node did not ask for {channel:?}"),
        }
    }
}

/// The planes that a stage is to fill over a block.
pub struct Outputs<'a> {
    planes: Vec<Vec<Option<&'a mut [f32]>>>,
}

impl<'a> Outputs<'a> {
    /// Made by the engine: for each output, for each channel, its plane where wanted.
    pub fn new(planes: Vec<Vec<Option<&'a mut [f32]>>>) -> Self {
        Self { planes }
    }

    /// Takes the plane of a channel, or `None` where nobody wants it.
    pub fn take(&mut self, output: usize, channel: usize) -> Option<&'a mut [f32]> {
        self.planes.get_mut(output)?.get_mut(channel)?.take()
    }
}

/// What [`Pointwise::lower`] is given.
pub struct Lowering<'a> {
    /// Appends operations.
    pub build: Builder<'a>,
    inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Value,
}

impl<'a> Lowering<'a> {
    /// Made by the engine. `inputs` gives the values of everything that the node is connected to.
    pub fn new(build: Builder<'a>, inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Value) -> Self {
        Self { build, inputs }
    }

    /// A connected or literal color.
    pub fn color(&mut self, source: &Source<Vec<f64>>) -> crate::Color {
        if let Some([r, g, b]) = source.color() {
            return self.build.control([r as f32, g as f32, b as f32]);
        }
        match (self.inputs)(source) {
            Value::Color(color) => color,
            other => unreachable!("checked to be a Color: {other:?}"),
        }
    }

    /// A connected or literal mask.
    pub fn mask(&mut self, source: &Source<Vec<f64>>) -> crate::Mask {
        if let Some(number) = source.number() {
            return self.build.constant_mask(number as f32);
        }
        match (self.inputs)(source) {
            Value::Weights(weights) if weights.ways() == 2 => self.build.weight(&weights, 1),
            other => unreachable!("checked to be a mask: {other:?}"),
        }
    }

    /// A connected or literal field of one component; a mask is forgotten to be one.
    pub fn scalar(&mut self, source: &Source<Vec<f64>>) -> crate::Scalar {
        if let Some(number) = source.number() {
            return self.build.constant(number as f32);
        }
        match (self.inputs)(source) {
            Value::Field(components) if components.len() == 1 => components[0],
            Value::Weights(weights) if weights.ways() == 2 => self.build.weight(&weights, 1).field(),
            other => unreachable!("checked to be one number: {other:?}"),
        }
    }

    /// Connected or literal weights.
    pub fn weights(&mut self, source: &Source<Vec<f64>>) -> crate::Weights {
        if let Source::Numbers(numbers) = source {
            return self.build.literal_weights(numbers);
        }
        match (self.inputs)(source) {
            Value::Weights(weights) => weights,
            other => unreachable!("checked to be Weights: {other:?}"),
        }
    }
}

/// A value of the f64 reference at one sample.
#[derive(Clone)]
pub enum Reference {
    /// Color.
    Color([f64; 3]),
    /// Mask: t.
    Mask(f64),
    /// Weights of n ≠ 2 controls.
    Weights(Vec<f64>),
    /// Field.
    Field(Vec<f64>),
    /// View: a value per channel.
    View(Vec<f64>),
    /// Surface, camera or light.
    Handle(Handle),
}

/// What a reference evaluation is given at one sample.
pub struct References<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// The sample's place in the picture, in pixels.
    pub at: [f64; 2],
    inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Reference,
}

impl<'a> References<'a> {
    /// Made by the engine.
    pub fn new(frame: &'a FrameContext, at: [f64; 2], inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Reference) -> Self {
        Self { frame, at, inputs }
    }

    fn value(&self, source: &Source<Vec<f64>>) -> Reference {
        match source {
            Source::Output { .. } => (self.inputs)(source),
            Source::Number(values) => Reference::Field(vec![values[0]]),
            Source::Color(values) => Reference::Color([values[0], values[1], values[2]]),
            Source::Numbers(numbers) => Reference::Weights(numbers.clone()),
        }
    }

    /// A connected or literal color.
    pub fn color(&self, source: &Source<Vec<f64>>) -> [f64; 3] {
        match self.value(source) {
            Reference::Color(color) => color,
            _ => unreachable!("checked to be a Color"),
        }
    }

    /// A connected or literal mask, or a field of one component.
    pub fn scalar(&self, source: &Source<Vec<f64>>) -> f64 {
        match self.value(source) {
            Reference::Mask(t) => t,
            Reference::Field(components) => components[0],
            _ => unreachable!("checked to be one number"),
        }
    }

    /// Connected or literal weights, one number a control.
    pub fn weights(&self, source: &Source<Vec<f64>>) -> Vec<f64> {
        match self.value(source) {
            Reference::Mask(t) => vec![1.0 - t, t],
            Reference::Weights(weights) => weights,
            _ => unreachable!("checked to be Weights"),
        }
    }

    /// A channel of a connected view.
    pub fn view(&self, source: &Source<Vec<f64>>, channel: ViewChannel) -> f64 {
        match self.value(source) {
            Reference::View(channels) => channels[channel as usize],
            _ => unreachable!("checked to be a View"),
        }
    }
}

/// Collects what [`NodeType::check`] finds.
pub struct Check<'a> {
    kinds: &'a dyn Fn(&Source<Vec<f64>>) -> Option<Kind>,
    faults: Vec<Fault>,
}

/// A fault or warning within one node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The port or knob.
    pub item: &'static str,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do.
    pub remedy: String,
    /// Whether it is only a warning.
    pub warning: bool,
}

impl<'a> Check<'a> {
    /// Made by validation; `kinds` gives the kind of a connection, where it is known.
    pub fn new(kinds: &'a dyn Fn(&Source<Vec<f64>>) -> Option<Kind>) -> Self {
        Self { kinds, faults: Vec::new() }
    }

    /// The kind of a connection or literal, where known.
    pub fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind> {
        (self.kinds)(source)
    }

    /// Reports an error.
    pub fn error(&mut self, item: &'static str, found: impl ToString, expected: impl ToString, remedy: impl ToString) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: false });
    }

    /// Reports a warning.
    pub fn warning(
        &mut self,
        item: &'static str,
        found: impl ToString,
        expected: impl ToString,
        remedy: impl ToString,
    ) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: true });
    }

    /// Everything reported.
    pub fn into_faults(self) -> Vec<Fault> {
        self.faults
    }
}

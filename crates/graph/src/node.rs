//! The contract between nodes and engine.
//!
//! A node type is a struct whose fields are its ports and knobs: `#[derive(Node)]` makes its [`Declaration`] of it. A value of it
//! is a node at one frame. It implements [`Node`]: the checks that one knob's range cannot express, and its body. A body is either
//! [`Pointwise`] (it lowers to the closed program) or a [`Stage`] (it prepares once a frame, then fills tiles).
//!
//! An implementor **must** be deterministic, give the same value at a sample whatever the tile, and fill
//! exactly the planes asked for. It **may** keep what `prepare` made, and read on from files that `prepare` opened. It
//! **must not** read clocks, global state, or open files outside `prepare`.

use crate::{
    Block, Bounding, ChannelSet, Check, Declaration, FrameContext, Inputs, ItemName, Items, Kind, Lowering, MemoryUse,
    NoBound, NodeError, Outputs, PortId, Prepare, Reader, Reckoning, Reference, References, Settled, Source, Spectrum,
    Stability, Value, Values, Work,
};
use std::any::Any;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid_image::{Format, Rgb, Window};

/// A type of node: its declaration, and how its nodes are read.
pub struct NodeType {
    declaration: &'static Declaration,
    read: fn(&Values) -> Arc<dyn Node>,
}

impl NodeType {
    /// The type that a struct declares.
    pub const fn of<T: Declare + Node>() -> Self {
        Self { declaration: T::DECLARATION, read: |values| Arc::new(T::read(&mut Reader::new(values))) }
    }

    /// Knobs, ports, outputs and documentation.
    pub fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    /// A node of this type at one frame.
    pub fn settle(&'static self, values: Values) -> Settled {
        Settled::new(self, values)
    }

    pub(crate) fn read(&self, values: &Values) -> Arc<dyn Node> {
        (self.read)(values)
    }
}

/// A struct whose fields are the ports and knobs of a node. Made by `#[derive(Node)]`.
pub trait Declare: Items {
    /// Everything that is said about the type, once.
    const DECLARATION: &'static Declaration;
}

/// A node at one frame.
pub trait Node: Any + Send + Sync {
    /// Kinds of the outputs, where knobs or the number of connections decide them; else as declared. Of a node
    /// with an output of [`Kind::ANY`], that output has the kind of the node's first connection.
    fn kinds(&self) -> Option<Vec<Kind>> {
        None
    }

    /// The connection that a pointwise node hands on unchanged.
    ///
    /// Nothing else that is connected is then planned, evaluated or read from disk, whatever the switches of an engine
    /// say, and [`Pointwise::lower`] and [`Pointwise::reference`] may ask for nothing else. Called before `check`, so
    /// knobs may be out of range and ports empty.
    fn identity(&self) -> Option<&Source<Vec<f64>>> {
        None
    }

    /// Reports what ranges of single knobs cannot express. Called at every key frame.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// About how long the node itself takes for a frame of a format, where legal knobs can make that very long:
    /// validation warns of it, see [`Work::MOST`]. `time` is that of the frame, in seconds since the first one, for
    /// what has to be stepped up to there.
    fn work(&self, format: Format, time: f64) -> Option<Work> {
        let _ = (format, time);
        None
    }

    /// What a user may want to know of the node, in sentences: shown by `trochoid check`.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Of a node that time moves, how its numbers behave.
    fn dynamics(&self) -> Option<&dyn Dynamics> {
        None
    }

    /// How the node computes.
    fn body(&self) -> Body<'_>;
}

/// How the numbers of a node behave that time moves.
pub trait Dynamics {
    /// How they behave in the long run: theory beside measurements, which may take some seconds. Shown by `trochoid stability`.
    fn stability(&self) -> Option<Stability> {
        None
    }

    /// Of a sea, the waves that it is made of.
    fn spectrum(&self) -> Option<Spectrum> {
        None
    }

    /// Of a sea, where the paths lie that its lists have.
    fn paths(&self) -> Option<Paths> {
        None
    }
}

/// Where paths lie that records of lists have: points x, z, x, z, … from an origin on, in meters.
#[derive(Clone, Debug, PartialEq)]
pub struct Paths {
    /// x, y and z of the point from which they are measured.
    pub origin: [f64; 3],
    /// The knob of a record that has one.
    pub knob: ItemName,
    /// The lists.
    pub lists: Vec<ItemName>,
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
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value;

    /// The same in f64 at one sample, straight from the formula.
    fn reference(&self, inputs: &References<'_>) -> Reference;
}

/// A front-end node, or a filter: prepares once a frame, then fills tiles.
pub trait Stage {
    /// Channels that the node asks of its view, where the given outputs are wanted.
    fn asks(&self, wanted: &[bool]) -> ChannelSet {
        let _ = wanted;
        ChannelSet::EMPTY
    }

    /// Channels that the node uses where its view supplies them, and does without elsewhere.
    fn prefers(&self, wanted: &[bool]) -> ChannelSet {
        let _ = wanted;
        ChannelSet::EMPTY
    }

    /// Channels that a node with a View as output can supply.
    fn supplies(&self) -> ChannelSet {
        ChannelSet::ALL
    }

    /// Channels that no setting could make a node with a View as output supply.
    fn lacks(&self) -> ChannelSet {
        ChannelSet::EMPTY
    }

    /// Certain bounds of an output channel, known before anything is prepared.
    fn interval(&self, output: usize, channel: usize) -> Option<(f64, f64)> {
        let _ = (output, channel);
        None
    }

    /// How an output varies over the picture.
    fn variance(&self, output: usize) -> Variance {
        let _ = output;
        Variance::Pixel
    }

    /// Which samples of a pixel may share a result, where the document shades by the pixel.
    fn rate(&self) -> Rate {
        Rate::Sample
    }

    /// What of the images connected to a port is needed to fill `window`: of a filter, more than the window itself.
    ///
    /// A larger window must not need less, and it must grow by as much wherever it lies. May reach beyond the picture:
    /// engines clamp it to where the image lies, see [`Prepared::data_window`].
    fn regions_of_interest(&self, port: PortId, window: Window, format: Format) -> Window {
        let _ = (port, format);
        window
    }

    /// The same for samples after a pixel's first one, where [`Prepared::find`] has found what lies beyond: no more than
    /// that.
    fn regions_once_found(&self, port: PortId, window: Window, format: Format) -> Window {
        self.regions_of_interest(port, window, format)
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
    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        let _ = frame;
        Vec::new()
    }

    /// About how much memory the node takes at a frame, where knobs, the format or files can make that much: plans add it up,
    /// and refuse what is too much before anything is prepared. May read headers of files; one that cannot be read counts as
    /// nothing, since [`prepare`](Self::prepare) says what is wrong with it.
    fn memory(&self, reckoning: &Reckoning<'_>) -> MemoryUse {
        let _ = reckoning;
        MemoryUse::default()
    }

    /// Looks at the headers of the node's files at a frame, and at nothing else of them.
    ///
    /// # Errors
    /// What [`prepare`](Self::prepare) would say of them. Files that do not exist are not asked for.
    fn examine(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let _ = (frame, wanted);
        Ok(())
    }

    /// Does once a frame what does not depend on the tile: simulate, build, decode.
    ///
    /// # Errors
    /// Files cannot be read, or their data break the contract of the kind: here, or in [`Prepared::fill`] where they are
    /// only read there.
    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError>;
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

    /// Where the node's images have pixels of their own, in the document's pixels; engines add the picture to it.
    ///
    /// Nothing is ever filled beyond it: what lies there repeats the nearest pixel within. By default that is the
    /// picture. Only what has pixels beyond says more: a file with overscan, and a filter of one. `inputs` gives the
    /// same for all that is connected to a port; any pointwise node between ends its image at the picture, so that an
    /// operand without weight, which may be left out, cannot matter.
    fn data_window(&self, picture: Window, inputs: &dyn Fn(PortId) -> Window) -> Window {
        let _ = inputs;
        picture
    }

    /// Rows that are best asked for together, over the full width, where the node reads them from a file in blocks;
    /// `None` for no preference.
    fn rows_per_band(&self) -> Option<usize> {
        None
    }

    /// What can be found once for all samples of the pixels of a block, where the document shades by the pixel: asked with
    /// what their first sample is given, and handed to [`Prepared::fill`] at each of them ([`Inputs::found`]).
    ///
    /// # Errors
    /// As [`Prepared::fill`].
    fn find(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<Option<Found>, NodeError> {
        let _ = (block, inputs);
        Ok(None)
    }

    /// Fills the planes asked for over one block of samples.
    ///
    /// A filter sees each sample of the pixel apart: the samples of all pixels at one offset are an image to it.
    ///
    /// # Errors
    /// Inputs break the contract of their kind at some pixel, or a file does that is read on demand.
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let _ = (block, inputs, outputs);
        Ok(())
    }

    /// Bounds how far each plane that [`fill`](Self::fill) filled may lie from [`reference`](Self::reference), at every sample
    /// of a block: fills the same planes with [`Bound`](crate::Bound)s, encoded. A reference is asked with inputs that lie
    /// within their own bounds.
    ///
    /// # Errors
    /// No honest bound is known.
    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let _ = (bounding, outputs);
        Err(NoBound("its method has none"))
    }

    /// All outputs in f64 at one sample, straight from the formula.
    ///
    /// # Errors
    /// As [`Prepared::fill`].
    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError>;

    /// Values set to the nearest legal one because the document says `repair`; of a file that is read on demand, among
    /// the rows that were needed. Each counts once, however often it is read.
    fn repaired(&self) -> u64 {
        0
    }

    /// What of the node's work is not done because it makes no difference at this frame: waves that no pixel resolves,
    /// drops beside the picture. May take a while; asked only where someone wants to know.
    fn left_out(&self) -> Vec<Omission> {
        Vec::new()
    }

    /// Memory held, bytes.
    fn bytes(&self) -> usize {
        0
    }
}

/// Work that a stage spares itself at a frame, see [`Prepared::left_out`].
#[derive(Clone, Debug, PartialEq)]
pub struct Omission {
    /// The port, and the connection within it, whose work it is; `None` where it is the node's own.
    pub port: Option<(PortId, usize)>,
    /// What is left out, in the plural, such as "waves".
    pub what: &'static str,
    /// How many are left out: a count, or the mean of counts.
    pub count: f64,
    /// Of how many.
    pub of: f64,
    /// Why they make no difference: what follows "because".
    pub why: &'static str,
}

/// What a stage found once for several samples of a block's pixels.
pub type Found = Arc<dyn Any + Send + Sync>;

/// What a front-end node makes and another takes: a surface, a camera or a light.
pub type Handle = Arc<dyn Any + Send + Sync>;

/// Which samples of a pixel may share a stage's result, where the document shades by the pixel
/// ([`Shading`](trochoid_image::Shading)).
///
/// Whatever is not of [`Rate::Sample`] may be asked for single pixels, and takes places from [`Block::pixels`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// None: it has edges of its own, or looks around.
    Sample,
    /// Those that see the same surface: it varies smoothly over each, and takes its inputs where it stands.
    Surface,
    /// All: it varies smoothly over the whole picture.
    Pixel,
}

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

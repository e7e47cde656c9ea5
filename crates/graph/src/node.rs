//! The contract between nodes and engine.
//!
//! A node type is a struct whose fields are its ports and knobs; `#[derive(Node)]` makes its [`Declaration`] from
//! them. A value of the struct is a node at one frame. The struct implements [`Node`]: the checks that the range of a
//! single knob cannot express. Its body is either [`Pointwise`] (it lowers to the closed program) or a
//! [`Stage`] (it prepares once per frame, then fills tiles).
//!
//! An implementation **must** be deterministic, give the same value at a sample in every tile, and fill exactly the
//! planes that are requested. It **may** keep the results of `prepare`, and continue reading files that `prepare`
//! opened. It **must not** read clocks or global state, or open files outside of `prepare`.

use crate::{
    Block, Bounding, ChannelSet, Check, Declaration, FrameContext, FrameTimes, Inputs, ItemName, Items, Kind, Lowering,
    MemoryContext, MemoryUse, NoBound, NodeError, Outputs, PortId, Prepare, Profile, ProfileLine, Reached, Reader,
    Reference, References, Settled, Source, Spectrum, Stability, StepErrors, Value, Values, Work,
};
use std::any::Any;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid_image::{Format, Rgb, Window};

/// A node type: its declaration, and the function that reads its nodes.
pub struct NodeType {
    declaration: &'static Declaration,
    read: fn(&Values) -> Arc<dyn Node>,
}

impl NodeType {
    /// Returns the type that a struct declares.
    pub const fn of<T: Declare + Node>() -> Self {
        Self { declaration: T::DECLARATION, read: |values| Arc::new(T::read(&mut Reader::new(values))) }
    }

    /// Returns the declaration: knobs, ports, outputs and documentation.
    pub fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    /// Makes a node of this type at one frame.
    pub fn settle(&'static self, values: Values) -> Settled {
        Settled::new(self, values)
    }

    pub(crate) fn read(&self, values: &Values) -> Arc<dyn Node> {
        (self.read)(values)
    }
}

/// A struct whose fields are the ports and knobs of a node. Made by `#[derive(Node)]`.
pub trait Declare: Items {
    /// Declaration of the type.
    const DECLARATION: &'static Declaration;
}

/// A node at one frame.
pub trait Node: Computes + Any + Send + Sync {
    /// Returns the kinds of the outputs if knobs or the number of connections decide them; `None` if they are as
    /// declared. An output of [`Kind::ANY`] has the kind of the node's first connection.
    fn kinds(&self) -> Option<Vec<Kind>> {
        None
    }

    /// Returns the connection that a pointwise node passes through unchanged.
    ///
    /// The engine then plans, evaluates and reads none of the other connections, whatever its switches, and
    /// [`Pointwise::lower`] and [`Pointwise::reference`] may use no other. Called before `check`, so knobs may be out
    /// of range and ports empty.
    fn identity(&self) -> Option<&Source<Vec<f64>>> {
        None
    }

    /// Reports faults that the ranges of single knobs cannot express. Called at the first and last frame and at every
    /// keyframe.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// Estimates the time that the node itself takes for a frame of a format, if legal knobs can make it very long;
    /// validation warns beyond [`Work::HEAVY_SECONDS`]. `time` is in seconds since the first frame, for simulations that step
    /// up to the frame.
    fn work(&self, format: Format, time: f64) -> Option<Work> {
        let _ = (format, time);
        None
    }

    /// Returns remarks about the node for users, in sentences, which `trochoid check` shows; `times` are those of the
    /// document's frames.
    fn notes(&self, times: FrameTimes) -> Vec<String> {
        let _ = times;
        Vec::new()
    }

    /// Returns the numerical behavior over time, for nodes that have any.
    fn dynamics(&self) -> Option<&dyn Dynamics> {
        None
    }
}

/// The trait that a node computes by. `#[derive(Node)]` implements it for a struct that declares `stage` or `pointwise`.
pub trait Computes {
    /// Returns the node's body.
    fn body(&self) -> Body<'_>;
}

/// Numerical behavior of a node that changes over time.
pub trait Dynamics {
    /// Measures what f32 loses over a number of steps, in comparison with f64, for the node's settings and others like
    /// them; may take a minute. `None` if the node carries no state, or soon after `stop` says that it is no longer
    /// needed. Shown by `trochoid stability --steps`.
    fn step_errors(&self, steps: u64, stop: &(dyn Fn() -> bool + Sync)) -> Option<StepErrors> {
        let _ = (steps, stop);
        None
    }

    /// Compares predicted with measured stability, which may take some seconds. Shown by `trochoid stability`.
    fn stability(&self) -> Option<Stability> {
        None
    }

    /// Returns the waves of a sea.
    fn spectrum(&self) -> Option<Spectrum> {
        None
    }

    /// Returns the surface of a sea above a line, at a time in seconds since the first frame; `None` if the node has no
    /// surface, or one that takes seconds to simulate.
    fn profile(&self, line: &ProfileLine, time: f64) -> Option<Profile> {
        let _ = (line, time);
        None
    }

    /// Returns what a simulated sea reaches at these times, as far as it gets within some seconds of work; `None` if the
    /// node simulates nothing, or soon after `stop` says that it is no longer needed.
    fn reached(&self, times: FrameTimes, stop: &dyn Fn() -> bool) -> Option<Reached> {
        let _ = (times, stop);
        None
    }

    /// Returns the paths in the lists of a sea.
    fn paths(&self) -> Option<Paths> {
        None
    }
}

/// Paths in the records of lists: points x, z, x, z, … relative to an origin, in meters.
#[derive(Clone, Debug, PartialEq)]
pub struct Paths {
    /// Origin of the paths: x, y and z in meters.
    pub origin: [f64; 3],
    /// Knob of a record that holds its path.
    pub knob: ItemName,
    /// Lists whose records have the knob.
    pub lists: Vec<ItemName>,
}

/// Body of a node: how it computes.
pub enum Body<'a> {
    /// Each output sample depends only on the input samples at the same place, by operations of the closed program.
    Pointwise(&'a dyn Pointwise),
    /// Any other computation.
    Stage(&'a dyn Stage),
}

/// A back-end node that lowers to the closed program.
pub trait Pointwise {
    /// Appends the node's operations and returns its output.
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value;

    /// Evaluates the node in f64 at one sample, straight from the formula.
    fn reference(&self, inputs: &References<'_>) -> Reference;
}

/// A front-end node or a filter: prepares once per frame, then fills tiles.
pub trait Stage {
    /// Returns the channels of its view that the node requires for the wanted outputs.
    fn required_channels(&self, wanted: &[bool]) -> ChannelSet {
        let _ = wanted;
        ChannelSet::EMPTY
    }

    /// Returns the channels that the node uses if its view supplies them, but does not require.
    fn optional_channels(&self, wanted: &[bool]) -> ChannelSet {
        let _ = wanted;
        ChannelSet::EMPTY
    }

    /// Returns the channels that a node with a View as output can supply.
    fn supplied_channels(&self) -> ChannelSet {
        ChannelSet::ALL
    }

    /// Returns the channels that a node with a View as output can supply with no setting at all.
    fn impossible_channels(&self) -> ChannelSet {
        ChannelSet::EMPTY
    }

    /// Returns guaranteed bounds of an output channel that are known before anything is prepared.
    fn interval(&self, output: usize, channel: usize) -> Option<(f64, f64)> {
        let _ = (output, channel);
        None
    }

    /// Returns how an output varies over the picture.
    fn variance(&self, output: usize) -> Variance {
        let _ = output;
        Variance::Pixel
    }

    /// Returns which samples of a pixel may share a result if the document shades per pixel.
    fn rate(&self) -> Rate {
        Rate::Sample
    }

    /// Returns whether the stage may be called for single pixels: its result depends only on inputs at the same place, and it
    /// takes positions from [`Block::pixels`].
    fn is_pixelwise(&self) -> bool {
        self.rate() != Rate::Sample
    }

    /// Returns whether a pixel takes so long to fill that it pays to find out first where the stage shows.
    fn is_costly(&self) -> bool {
        false
    }

    /// Returns the region of interest: the part of the images at a port that is needed to fill `window`. For a filter
    /// it is larger than the window itself.
    ///
    /// A larger window must not need less, and the margin must not depend on the window's position. The region may
    /// extend beyond the picture: engines clamp it to the image's data window, see [`Prepared::data_window`].
    fn regions_of_interest(&self, port: PortId, window: Window, format: Format) -> Window {
        let _ = (port, format);
        window
    }

    /// Returns the region of interest for the samples after a pixel's first one, if [`Prepared::find`] has already
    /// used the rest. Never larger than [`regions_of_interest`](Self::regions_of_interest).
    fn regions_after_find(&self, port: PortId, window: Window, format: Format) -> Window {
        self.regions_of_interest(port, window, format)
    }

    /// Returns whether planes of which the stage needs more than its block may hold more than the region of interest: whole
    /// rows of an image that is in memory need no copy. A stage that works on all pixels of its planes should say no.
    fn takes_whole_rows(&self) -> bool {
        false
    }

    /// Whether the result depends on the frame's time even if no knob is keyed.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Whether the result depends on the picture's format.
    fn depends_on_format(&self) -> bool {
        true
    }

    /// Returns the files that the node reads at a frame, for content keys and `--resume`.
    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        let _ = frame;
        Vec::new()
    }

    /// Estimates the memory that the node takes at a frame, if knobs, the format or files can make it large. Plans
    /// add the estimates up, and refuse a frame that takes too much before anything is prepared. May read headers of
    /// files; a file that cannot be read counts as nothing, since [`prepare`](Self::prepare) reports it.
    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let _ = context;
        MemoryUse::default()
    }

    /// Checks the headers, and nothing else, of the node's files at a frame.
    ///
    /// # Errors
    /// The errors that [`prepare`](Self::prepare) would report for the headers. Never called for files that do not
    /// exist.
    fn check_headers(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let _ = (frame, wanted);
        Ok(())
    }

    /// Returns remarks about the node's files at a frame for users, in sentences, which `trochoid check` shows. Never called
    /// for files that do not exist. Has the handles of connected nodes that need neither files nor other nodes, such as
    /// cameras.
    fn file_notes(&self, prepare: &Prepare<'_>) -> Vec<String> {
        let _ = prepare;
        Vec::new()
    }

    /// Does the work that is independent of tiles once per frame: simulates, builds, decodes.
    ///
    /// # Errors
    /// Files cannot be read, or their data break the contract of the kind. Files that are read on demand fail in
    /// [`Prepared::fill`] instead.
    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError>;
}

/// Replaced value, and what made it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// Column and row of its pixel.
    pub pixel: [i64; 2],
    /// What made it, such as `sqrt(a) with a = -0.5`.
    pub cause: String,
}

/// A stage prepared for one frame.
pub trait Prepared: Send + Sync {
    /// Returns the surface, camera or light that other nodes take.
    fn handle(&self) -> Option<Handle> {
        None
    }

    /// Returns the control colors that this node adds to the palette.
    fn controls(&self) -> Vec<Rgb> {
        Vec::new()
    }

    /// Returns the data window of the node's images, in the document's pixels; engines enlarge it to include the
    /// picture.
    ///
    /// Nothing is filled outside of the data window: there, the nearest pixel inside repeats. By default it is the
    /// picture. Only nodes with overscan return more: a file with overscan, or a filter of one. `inputs` returns the
    /// data window of everything connected to a port. A pointwise node in between cuts its image off at the picture,
    /// so that an operand without weight, which may be left out, has no influence.
    fn data_window(&self, picture: Window, inputs: &dyn Fn(PortId) -> Window) -> Window {
        let _ = inputs;
        picture
    }

    /// Returns the number of full-width rows that are best requested together, for nodes that read a file in blocks;
    /// `None` for no preference.
    fn rows_per_band(&self) -> Option<usize> {
        None
    }

    /// Computes results that all samples of the block's pixels share, if the document shades per pixel. Called with
    /// the inputs of the pixels' first sample; [`Prepared::fill`] gets the result at each of the samples
    /// ([`Inputs::found`]).
    ///
    /// # Errors
    /// As [`Prepared::fill`].
    fn find(&self, block: &Block<'_>, inputs: &Inputs<'_>) -> Result<Option<SharedResult>, NodeError> {
        let _ = (block, inputs);
        Ok(None)
    }

    /// Fills the requested planes over one block of samples.
    ///
    /// A filter treats each sample offset separately: the samples of all pixels at one offset form an image.
    ///
    /// # Errors
    /// Inputs, or a file that is read on demand, break the contract of their kind at some pixel.
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let _ = (block, inputs, outputs);
        Ok(())
    }

    /// Bounds the difference between each plane that [`fill`](Self::fill) filled and [`reference`](Self::reference),
    /// at every sample of a block: fills the same planes with encoded [`Bound`](crate::Bound)s. The inputs of the
    /// reference lie within their own bounds.
    ///
    /// # Errors
    /// No valid bound is known.
    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let _ = (bounding, outputs);
        Err(NoBound("its method has none"))
    }

    /// Evaluates all outputs in f64 at one sample, straight from the formula.
    ///
    /// # Errors
    /// As [`Prepared::fill`].
    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError>;

    /// Returns the number of values that were set to the nearest legal one because of the `repair` knob. A file that
    /// is read on demand counts only the rows that were needed. Each value counts once, however often it is read.
    fn repaired(&self) -> u64 {
        0
    }

    /// Returns the first of the replaced values, if the node knows more of it than its file.
    fn first_repaired(&self) -> Option<Repair> {
        None
    }

    /// Returns the number of its parts that were prepared for an earlier frame, such as views of surfaces that do not move.
    fn kept(&self) -> usize {
        0
    }

    /// Returns the connections, as ports and indices within them, of which nothing is in the picture: surfaces that a
    /// view lists in vain, which their author should know.
    fn unseen(&self) -> Vec<(PortId, usize)> {
        Vec::new()
    }

    /// Returns the work that the node skips because it makes no difference at this frame: waves that no pixel resolves,
    /// drops outside of the picture. May take a while; called only on request.
    fn left_out(&self) -> Vec<Omission> {
        Vec::new()
    }

    /// Returns the memory held, in bytes.
    fn bytes(&self) -> usize {
        0
    }
}

/// Work that a stage skips at a frame, see [`Prepared::left_out`].
#[derive(Clone, Debug, PartialEq)]
pub struct Omission {
    /// Port, and index of the connection within it, whose work is skipped; `None` for the node's own work.
    pub port: Option<(PortId, usize)>,
    /// Name of the skipped items, in the plural, such as "waves".
    pub what: &'static str,
    /// Number of skipped items: a count, or the mean of counts.
    pub count: f64,
    /// Total number of items.
    pub of: f64,
    /// Reason why they make no difference: the words after "because".
    pub why: &'static str,
}

/// Result of [`Prepared::find`], shared by several samples of a block's pixels.
pub type SharedResult = Arc<dyn Any + Send + Sync>;

/// A surface, camera or light that one front-end node makes and another takes.
pub type Handle = Arc<dyn Any + Send + Sync>;

/// Samples of a pixel that may share a stage's result if the document shades per pixel
/// ([`Shading`](trochoid_image::Shading)).
///
/// Stages of any rate but [`Rate::Sample`] may be called for single pixels ([`Stage::is_pixelwise`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// None: the result has edges of its own, or depends on neighboring pixels.
    Sample,
    /// Samples that see the same surface: the result varies smoothly over each surface and depends only on inputs at
    /// the same place.
    Surface,
    /// All: the result varies smoothly over the whole picture.
    Pixel,
}

/// How a value varies over the picture; ordered from least to most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variance {
    /// Constant over the picture.
    Constant,
    /// Depends on x only.
    Column,
    /// Depends on y only.
    Row,
    /// Depends on x and y.
    Pixel,
}

impl Variance {
    /// Returns the variance of a value that depends on values of both variances.
    pub fn join(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant, other) => other,
            (this, Self::Constant) => this,
            (this, other) if this == other => this,
            _ => Self::Pixel,
        }
    }
}

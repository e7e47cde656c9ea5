//! Results of an evaluation: pictures, what was counted on them, and where the time went.

use super::buffer_fault::BufferFault;
use super::foreign::ForeignError;
use crate::LeftOut;
use std::sync::Arc;
use trochoid_graph::{CheckedGraph, DocumentPlace, Guarantee, Kind, NodeError, NodeId, Repair, in_bytes};
use trochoid_image::{Plane, Rgb, Window};
use trochoid_weights::{Audit, Hull};

/// Why a plan could not be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EvalError {
    /// A node could not read its files, or its input data are illegal.
    #[error("{place}: node \"{node}\" ({ty}): {error}")]
    Node {
        /// Document, line and column: those of the file's name if the node reads a file.
        place: Box<DocumentPlace>,
        /// The node's name.
        node: String,
        /// The node's type.
        ty: String,
        /// The node's message.
        error: NodeError,
    },
    /// A bound buffer does not fit its node.
    #[error("buffer bound to \"{node}\": {reason}")]
    Buffer {
        /// The node's name.
        node: String,
        /// Reason why it does not fit.
        reason: BufferFault,
    },
    /// The frame takes more memory than [`Settings::memory_limit`](crate::Settings::memory_limit), according to the
    /// estimate or to what a node then really held.
    #[error(
        "{place}: found a frame that takes about {}: {found}; expected at most {}: {remedy}",
        in_bytes(*total), in_bytes(*limit)
    )]
    TooMuchMemory {
        /// Document, line and column of the largest taker.
        place: Box<DocumentPlace>,
        /// Largest takers, in words.
        found: String,
        /// Bytes needed.
        total: u64,
        /// Bytes allowed.
        limit: u64,
        /// What to make smaller.
        remedy: &'static str,
    },
    /// Memory for the pictures could not be allocated.
    #[error("out of memory for {bytes} bytes of pictures: evaluate a smaller region")]
    Memory {
        /// Bytes requested.
        bytes: usize,
    },
    /// The sink could not store the rows.
    #[error(transparent)]
    Sink(ForeignError),
    /// The threads could not be started.
    #[error("threads could not be started: {0}")]
    Threads(#[source] ForeignError),
    /// The monitor asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl EvalError {
    /// Makes an error of a node's message, with its place in the document.
    pub(crate) fn of(graph: &CheckedGraph, id: NodeId, error: NodeError) -> Self {
        let node = graph.node(id);
        Self::Node {
            place: graph.place_of(id, node.file_item()).into(),
            node: node.name.clone(),
            ty: node.ty.declaration().name.into(),
            error,
        }
    }

    /// Returns whether a node has given up a reference at one sample, because it takes too much effort there.
    pub(crate) fn is_given_up(&self) -> bool {
        matches!(self, Self::Node { error: NodeError::GivenUp(_), .. })
    }
}

/// Observes an evaluation; called from many threads.
pub trait Monitor: Sync {
    /// A node is about to prepare.
    fn preparing(&self, node: &str) {
        let _ = node;
    }

    /// `done` of `total` tiles are done.
    fn progress(&self, done: usize, total: usize) {
        let _ = (done, total);
    }

    /// Returns whether the evaluation should stop as soon as it can.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Monitor that observes nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {}

/// An evaluated frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Frame number.
    pub number: i64,
    /// Pixels that were evaluated.
    pub window: Window,
    /// One picture per output.
    pub pictures: Vec<Picture>,
    /// Report on each node of the graph.
    pub nodes: Vec<NodeReport>,
    /// Seconds by phase.
    pub seconds: Phases,
    /// Number of threads used.
    pub threads: usize,
}

/// Seconds by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases {
    /// Preparing stages: simulating, building, decoding.
    pub prepare: f64,
    /// Building the convex hulls of the control colors.
    pub hull: f64,
    /// Filling tiles and running the pointwise program.
    pub tiles: f64,
}

/// One output's picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The output's index in the graph.
    pub output: usize,
    /// The output's kind.
    pub kind: Kind,
    /// One plane per channel; colors are in the working space.
    pub planes: Vec<Plane>,
    /// Region that the colors cannot leave; `None` for other kinds.
    pub guarantee: Option<Guarantee>,
    /// Counts on the f32 pixels, before any rounding or encoding.
    pub audit: Audit,
    /// Number of distinct control colors. An image, and a color of the caller, count with the corners of the hull of their
    /// pixels: one that is the same everywhere counts once. Above 64 of one image, equal ones of several count each.
    pub control_count: usize,
    /// Up to 64 of the control colors.
    pub control_colors: Vec<Rgb>,
    /// Convex hull of all control colors, against which pixels were checked; `None` for other kinds.
    pub hull: Option<Arc<Hull>>,
    /// Rounding margin within which a pixel counts as inside of the hull.
    pub margin: f64,
}

/// Report on a node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeReport {
    /// The node's name.
    pub name: String,
    /// The node's type.
    pub ty: &'static str,
    /// What happened to it.
    pub state: State,
    /// Seconds, summed over all threads.
    pub seconds: f64,
    /// Whether the seconds are an estimated share of the fused program's time instead of a measurement.
    pub estimated: bool,
    /// Number of samples that it computed.
    pub pixels: u64,
    /// Memory that it holds, in bytes.
    pub bytes: usize,
    /// Number of parts of what it prepared that an earlier frame had prepared.
    pub kept: usize,
    /// Number of illegal input values that were replaced by the nearest legal value.
    pub repaired: u64,
    /// The first of these values, in the order of rows, if the node knows what made it.
    pub first_repaired: Option<Repair>,
    /// Names of the connected nodes of which nothing is in the picture, such as surfaces that a view lists.
    pub unseen: Vec<String>,
}

/// What happened to a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It was evaluated.
    Evaluated,
    /// Its result from an earlier frame was used.
    Cached,
    /// It was left out.
    LeftOut(LeftOut),
}

impl State {
    /// Returns the word for it in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Evaluated => "evaluated",
            Self::Cached => "cached",
            Self::LeftOut(_) => "left_out",
        }
    }
}

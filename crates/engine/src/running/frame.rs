//! What an evaluation gives: pictures, what was counted on them, and where the time went.

use super::buffers::BufferFault;
use super::foreign::ForeignError;
use crate::LeftOut;
use std::sync::Arc;
use trochoid_graph::{CheckedGraph, Guarantee, Kind, NodeError, NodeId, in_bytes};
use trochoid_image::{Plane, Rgb, Window};
use trochoid_weights::{Audit, Hull};

/// Why a plan could not be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EvalError {
    /// A node could not read its files, or its input data are illegal.
    #[error("{place}: node \"{node}\" ({ty}): {message}")]
    Node {
        /// Document, line and column: of the file's name where the node reads one.
        place: String,
        /// The node's name.
        node: String,
        /// Its type.
        ty: String,
        /// What it says.
        message: String,
    },
    /// A bound buffer does not fit.
    #[error("buffer bound to \"{node}\": {reason}")]
    Buffer {
        /// The node's name.
        node: String,
        /// What does not fit.
        reason: BufferFault,
    },
    /// The frame takes more memory than allowed: as it was reckoned before anything was prepared, or as a node then held.
    #[error(
        "{place}: found a frame that takes about {}: {found}; expected at most {}: {remedy}; or allow more memory (--memory, or Settings::memory_limit)",
        in_bytes(*total), in_bytes(*limit)
    )]
    TooMuchMemory {
        /// Where the document has what takes most: document, line and column.
        place: String,
        /// The largest takers, in words.
        found: String,
        /// Bytes needed.
        total: u64,
        /// Bytes allowed.
        limit: u64,
        /// What to make smaller.
        remedy: &'static str,
    },
    /// Memory for the pictures could not be had.
    #[error("out of memory for {bytes} bytes of pictures: evaluate a smaller region")]
    Memory {
        /// Bytes asked for.
        bytes: usize,
    },
    /// The sink could not store what it was given.
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
    /// What a node says, with its place.
    pub(crate) fn of(graph: &CheckedGraph, id: NodeId, error: NodeError) -> Self {
        let node = graph.node(id);
        Self::Node {
            place: graph.place_of(id, node.file_item()),
            node: node.name.clone(),
            ty: node.ty.declaration().name.into(),
            message: error.to_string().replace(NodeError::NODE, &node.name),
        }
    }
}

/// Observes an evaluation; called from many threads.
pub trait Monitor: Sync {
    /// A node is about to prepare.
    fn preparing(&self, node: &str) {
        let _ = node;
    }

    /// So many of all tiles are done.
    fn progress(&self, done: usize, total: usize) {
        let _ = (done, total);
    }

    /// Whether the evaluation should stop as soon as it can.
    fn cancelled(&self) -> bool {
        false
    }
}

/// A monitor that observes nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {}

/// An evaluated frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The frame's number.
    pub number: i64,
    /// The pixels evaluated.
    pub window: Window,
    /// One picture an output.
    pub pictures: Vec<Picture>,
    /// What each node of the graph did.
    pub nodes: Vec<NodeReport>,
    /// Seconds by phase.
    pub seconds: Phases,
    /// Threads used.
    pub threads: usize,
}

/// Seconds by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases {
    /// Preparing stages: simulate, build, decode.
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
    /// Its kind.
    pub kind: Kind,
    /// One plane a channel, in the working space for colors.
    pub planes: Vec<Plane>,
    /// What cannot be left; `None` for pictures that are no colors.
    pub guarantee: Option<Guarantee>,
    /// What was counted on the f32 pixels, before any rounding or encoding.
    pub audit: Audit,
    /// Number of distinct control colors: vertices of the hull where an image is among them.
    pub control_count: usize,
    /// Up to 64 of them.
    pub control_colors: Vec<Rgb>,
    /// The hull of all of them, which pixels were held against; `None` for pictures that are no colors.
    pub hull: Option<Arc<Hull>>,
    /// The printed margin of rounding within which a pixel counts as inside.
    pub margin: f64,
}

/// What a node did.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeReport {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: &'static str,
    /// What became of it.
    pub state: State,
    /// Seconds on all threads together.
    pub seconds: f64,
    /// Whether the seconds are shared out within the fused program rather than measured.
    pub estimated: bool,
    /// Samples that it computed.
    pub pixels: u64,
    /// Memory that it holds, bytes.
    pub bytes: usize,
    /// Illegal input values set to the nearest legal one.
    pub repaired: u64,
}

/// What became of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It was evaluated.
    Evaluated,
    /// Its result of an earlier frame was used.
    Cached,
    /// It was left out.
    LeftOut(LeftOut),
}

impl State {
    /// The word in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Evaluated => "evaluated",
            Self::Cached => "cached",
            Self::LeftOut(_) => "left_out",
        }
    }
}

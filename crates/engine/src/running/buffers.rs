//! Buffers of the caller that replace nodes.

use crate::kernel::Plane;
use crate::{EvalError, Plan};
use std::collections::HashMap;
use trochoid_graph::{Kind, Slot};
use trochoid_image::Window;

/// The caller's f32 buffers by node name, one slice per channel.
///
/// A picture's buffers cover its display window row by row; a batch's buffers hold one number per sample.
#[derive(Clone, Debug, Default)]
pub struct Buffers<'b> {
    planes: HashMap<String, Vec<&'b [f32]>>,
}

/// Why a buffer does not fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BufferFault {
    /// The node is bound, and has none.
    #[error("no buffer is given: add it with Buffers::with")]
    None,
    /// It has too many channels, or too few.
    #[error("found {found} channels; a {kind} has {}", kind.channels())]
    Channels {
        /// Those given.
        found: usize,
        /// What the node makes.
        kind: Kind,
    },
    /// A channel is too long, or too short.
    #[error("channel {channel} has {found} samples; expected {expected}")]
    Length {
        /// The channel.
        channel: usize,
        /// Its samples.
        found: usize,
        /// Samples of the picture or batch.
        expected: usize,
    },
    /// A sample is not legal for what the node makes.
    #[error("found {found} at sample {sample} of channel {channel}; expected {} in a {kind}", rule(*kind).1)]
    Value {
        /// The channel.
        channel: usize,
        /// The sample.
        sample: usize,
        /// What it holds.
        found: f32,
        /// What the node makes.
        kind: Kind,
    },
    /// The weights of a sample do not sum to 1.
    #[error("the weights of sample {sample} sum to {sum}; expected 1")]
    Sum {
        /// The sample.
        sample: usize,
        /// Their sum.
        sum: f64,
    },
    /// The slices to be filled are of another number or length.
    #[error("found {found} output slices; expected {expected} of {samples} samples")]
    Outputs {
        /// Those given.
        found: usize,
        /// Channels of the output.
        expected: usize,
        /// Samples of the batch.
        samples: usize,
    },
}

impl<'b> Buffers<'b> {
    /// Returns an empty set of buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the channels that replace a node's first output: three for a Color, one for a mask, n for Weights(n) and
    /// for a Field of n components.
    #[must_use]
    pub fn with(mut self, node: &str, channels: &[&'b [f32]]) -> Self {
        self.planes.insert(node.into(), channels.to_vec());
        self
    }

    /// Returns the names of the bound nodes.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.planes.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    pub(crate) fn get(&self, node: &str) -> Option<&[&'b [f32]]> {
        self.planes.get(node).map(Vec::as_slice)
    }

    /// Checks the number and length of one node's buffers against its kind.
    pub(crate) fn validate(&self, node: &str, kind: Kind, length: usize) -> Result<(), EvalError> {
        let fault = |reason: BufferFault| EvalError::Buffer { node: node.into(), reason };
        let planes = self.get(node).ok_or_else(|| fault(BufferFault::None))?;
        if planes.len() != kind.channels() {
            return Err(fault(BufferFault::Channels { found: planes.len(), kind }));
        }
        for (channel, plane) in planes.iter().enumerate() {
            if plane.len() != length {
                return Err(fault(BufferFault::Length { channel, found: plane.len(), expected: length }));
            }
        }
        Ok(())
    }

    /// Checks every value of one node's buffers: the values that programs otherwise check while they run, and the
    /// sums of weights.
    pub(crate) fn validate_values(&self, node: &str, kind: Kind) -> Result<(), EvalError> {
        let planes = self.get(node).unwrap_or_default();
        for (channel, plane) in planes.iter().enumerate() {
            check(node, kind, channel, plane, 0)?;
        }
        let length = planes.first().map_or(0, |plane| plane.len());
        if let Kind::Weights(n) = kind
            && n > 2
        {
            let sum = |at: usize| planes.iter().map(|plane| f64::from(plane[at])).sum::<f64>();
            if let Some(at) = (0..length).find(|&at| (sum(at) - 1.0).abs() > 1e-3) {
                let reason = BufferFault::Sum { sample: at, sum: sum(at) };
                return Err(EvalError::Buffer { node: node.into(), reason });
            }
        }
        Ok(())
    }

    /// Returns copies of the caller's planes over a tile with −0 turned into 0, by index among `slots`, or the first
    /// illegal value as an error.
    pub(crate) fn normalized(
        &self,
        plan: &Plan<'_>,
        slots: &[Slot],
        planes: &[Plane<'_>],
        tile: Window,
    ) -> Result<Vec<(usize, Vec<f32>)>, EvalError> {
        let mut copies = Vec::new();
        for (index, (slot, plane)) in slots.iter().zip(planes).enumerate().filter(|(_, (s, _))| plan.bound[s.node.0]) {
            let node = plan.graph.node(slot.node);
            let mut copy = Vec::with_capacity(tile.area());
            for y in 0..tile.height() {
                let row = plane.row(y, tile.width());
                check(&node.name, node.kinds[slot.output], slot.channel, row, plane.start + y * plane.stride)?;
                copy.extend(row.iter().map(|v| v + 0.0));
            }
            copies.push((index, copy));
        }
        Ok(copies)
    }
}

/// Returns a test of the samples that a buffer of a kind may hold, and its description.
fn rule(kind: Kind) -> (fn(&f32) -> bool, &'static str) {
    match kind {
        Kind::Color => (|v| v.is_finite() && *v >= 0.0, "finite numbers ≥ 0"),
        Kind::Weights(_) => (|v| (0.0..=1.0).contains(v), "numbers in [0, 1]"),
        _ => (|v| !v.is_nan(), "no NaN"),
    }
}

/// Checks samples of a buffer against its kind. `start` is the index of the first of them in the buffer.
fn check(node: &str, kind: Kind, channel: usize, samples: &[f32], start: usize) -> Result<(), EvalError> {
    let (legal, _) = rule(kind);
    match samples.iter().position(|v| !legal(v)) {
        Some(at) => {
            let (found, at) = (samples[at], start + at);
            let reason = BufferFault::Value { channel, sample: at, found, kind };
            Err(EvalError::Buffer { node: node.into(), reason })
        }
        None => Ok(()),
    }
}

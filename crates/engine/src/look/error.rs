//! Why a batch is refused, or cannot be made at all.

use crate::BufferFault;
use trochoid_graph::Diagnostic;

/// The output needs more than samples one by one: nodes that are neither inputs nor pointwise.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .faults.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n"))]
pub struct NotPointwise {
    /// A fault for each node that is in the way, in the order of the document. Once all of them are inputs, there is none.
    pub faults: Vec<Diagnostic>,
}

/// Reason that a batch is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadeError {
    /// A wrong number of channels.
    #[error("found {found} channels of {what}; expected {expected}")]
    Channels {
        /// `inputs` or `outputs`.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number that the look has.
        expected: usize,
    },
    /// A channel ends before the last sample.
    #[error("channel {channel} of the {what} has {found} samples; expected {expected}")]
    Short {
        /// `inputs` or `outputs`.
        what: &'static str,
        /// Index of the channel.
        channel: usize,
        /// Number of samples that it has.
        found: usize,
        /// Number of samples of the batch.
        expected: usize,
    },
    /// A sample of an input is illegal. What was written is undefined.
    #[error("\"{name}\": {fault}")]
    Illegal {
        /// Index of the slot.
        slot: usize,
        /// Name of the slot.
        name: String,
        /// Index of the sample in the batch.
        sample: usize,
        /// What is wrong with it.
        fault: BufferFault,
    },
}

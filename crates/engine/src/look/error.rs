//! Why a batch is refused.

use crate::BufferFault;

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

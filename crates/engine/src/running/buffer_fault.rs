//! Reasons that a buffer of the caller is refused.

use trochoid_graph::Kind;

/// Reason that a buffer is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BufferFault {
    /// The node is bound but has no buffer.
    #[error("no buffer is given: add it with Buffers::with")]
    None,
    /// Wrong number of channels.
    #[error("found {found} channels; a {kind} has {}", kind.channels())]
    Channels {
        /// Number given.
        found: usize,
        /// Kind of the node's output.
        kind: Kind,
    },
    /// Wrong number of samples in a channel.
    #[error("channel {channel} has {found} samples; expected {expected}")]
    Length {
        /// Channel.
        channel: usize,
        /// Number of its samples.
        found: usize,
        /// Number of samples of the picture or batch.
        expected: usize,
    },
    /// A sample is illegal for the kind.
    #[error("found {found} at sample {sample} of channel {channel}; expected {} in a {kind}", rule(*kind).1)]
    Value {
        /// Channel.
        channel: usize,
        /// Sample.
        sample: usize,
        /// Value of the sample.
        found: f32,
        /// Kind of the node's output.
        kind: Kind,
    },
    /// The weights of a sample do not sum to 1.
    #[error("the weights of sample {sample} sum to {sum}; expected 1")]
    Sum {
        /// Sample.
        sample: usize,
        /// Sum of its weights.
        sum: f64,
    },
    /// The output slices have a wrong number or length.
    #[error("found {found} output slices; expected {expected} of {samples} samples")]
    Outputs {
        /// Number given.
        found: usize,
        /// Number of channels of the output.
        expected: usize,
        /// Number of samples of the batch.
        samples: usize,
    },
}

/// Returns a test of the samples that a buffer of a kind may hold, and its description.
pub(crate) fn rule(kind: Kind) -> (fn(&f32) -> bool, &'static str) {
    match kind {
        Kind::Color => (|v| v.is_finite() && *v >= 0.0, "finite numbers ≥ 0"),
        Kind::Weights(_) => (|v| (0.0..=1.0).contains(v), "numbers in [0, 1]"),
        _ => (|v| !v.is_nan(), "no NaN"),
    }
}

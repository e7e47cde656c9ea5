//! Reasons that a graphics card does not compute something.

/// Reason that there is no picture from a card.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum CardError {
    /// The machine has no card.
    #[error("no graphics card was found")]
    None,
    /// There are only drivers that compute on the processor, more slowly than the editor does.
    #[error("{0} is no graphics card, but computes on the processor")]
    Software(String),
    /// The driver refuses the card.
    #[error("{0} cannot be used: {1}")]
    Refused(String, String),
    /// The card failed.
    #[error("{0} failed: {1}")]
    Failed(String, String),
    /// Something is larger than the card takes.
    #[error("found {bytes} bytes; expected at most the {most} that the card takes at once")]
    Large {
        /// Bytes of it.
        bytes: u64,
        /// Most bytes.
        most: u64,
    },
    /// Only the processor does this.
    #[error("only the processor shows {0}")]
    Unfit(&'static str),
}

impl CardError {
    /// Whether the card can still do something else.
    pub(super) fn is_passing(&self) -> bool {
        matches!(self, Self::Large { .. } | Self::Unfit(_))
    }
}

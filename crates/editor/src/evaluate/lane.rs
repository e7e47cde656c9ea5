//! The viewers, by their precedence.

/// A viewer. What the first one asks for comes before what the second one does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// The viewer that is always there.
    First,
    /// The second viewer.
    Second,
}

impl Lane {
    /// Number at which the generations of the second viewer's pictures begin; all others are smaller.
    pub const SECOND: u64 = 1 << 56;

    /// Returns the viewer that a generation of a picture, or the number of a held picture, is of.
    pub fn of(generation: u64) -> Self {
        if generation < Self::SECOND { Self::First } else { Self::Second }
    }
}

//! The ways to align and distribute nodes.

/// Way to align or distribute nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Align left edges.
    Left,
    /// Align top edges.
    Top,
    /// Align centers in a column.
    Centers,
    /// Make gaps equal along the longer side of the bounding box.
    Distances,
}

impl Line {
    /// Every way, in menu order.
    pub const ALL: [Self; 4] = [Self::Left, Self::Top, Self::Centers, Self::Distances];

    /// Returns the name of the command.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "Align left",
            Self::Top => "Align top",
            Self::Centers => "Align centers",
            Self::Distances => "Distribute",
        }
    }
}

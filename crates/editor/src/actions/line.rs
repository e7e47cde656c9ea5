//! How nodes are lined up.

/// How nodes are lined up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Left edges.
    Left,
    /// Upper edges.
    Top,
    /// Centers, one above the other.
    Centers,
    /// Equal distances, along the longer side.
    Distances,
}

impl Line {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Left, Self::Top, Self::Centers, Self::Distances];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "Align left",
            Self::Top => "Align top",
            Self::Centers => "Align centers",
            Self::Distances => "Distribute",
        }
    }
}

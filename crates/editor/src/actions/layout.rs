//! Layouts of the panels.

/// Layouts that the editor comes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// The initial one.
    First,
    /// A large picture, and the palette beside it.
    Painting,
    /// Picture and graph side by side, above wide panels.
    Animation,
}

impl Layout {
    /// Every layout, in menu order.
    pub const ALL: [Self; 3] = [Self::First, Self::Painting, Self::Animation];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "Default",
            Self::Painting => "Painting",
            Self::Animation => "Animation",
        }
    }
}

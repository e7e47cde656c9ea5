//! Why nodes are left out.

/// Why a node is not evaluated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// The document disables it.
    Disabled,
    /// No requested output is connected to it.
    Unreachable,
    /// A buffer of the caller stands in for it or for everything that it feeds.
    Bound,
    /// Everything that it feeds is cut off by a constant weight: the mixing node, and the weight found.
    Weight {
        /// Name of the node that mixes.
        at: String,
        /// The constant weight, as text.
        weight: String,
    },
    /// Another node computes the same.
    SameAs(String),
    /// What it feeds needs nothing of it: constants, channels that nobody reads.
    Unneeded,
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Disabled => f.write_str("disabled"),
            Self::Unreachable => f.write_str("no requested output needs it"),
            Self::Bound => f.write_str("a bound buffer stands in for it"),
            Self::Weight { at, weight } => write!(f, "its weight at \"{at}\" is proved {weight} everywhere"),
            Self::SameAs(name) => write!(f, "the same as \"{name}\""),
            Self::Unneeded => f.write_str("nothing that is evaluated reads it"),
        }
    }
}

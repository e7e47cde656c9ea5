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
    /// Its weight is proved 0 everywhere, at the mixing node of this name.
    Weight(String),
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
            Self::Weight(at) => write!(f, "its weight at \"{at}\" is proved 0 everywhere"),
            Self::SameAs(name) => write!(f, "the same as \"{name}\""),
            Self::Unneeded => f.write_str("nothing that is evaluated reads it"),
        }
    }
}

//! Names that other programs use for the jobs of nodes, so that an unknown node type can be answered with the right
//! node. Nodes declare theirs.

use crate::Registry;

/// Name in another program for the job of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alias {
    /// The name; only letters and digits count, and case does not.
    pub word: &'static str,
    /// Hint on how to use the node, such as `its "fit"`; empty if the node's name is enough.
    pub hint: &'static str,
}

/// Counterpart of another program's node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// A node.
    Node {
        /// Its type.
        name: &'static str,
        /// Hint, see [`Alias::hint`].
        hint: &'static str,
    },
    /// The document's outputs.
    Output,
}

/// Names of nodes that write. Here the document's outputs do.
pub const OUTPUT_WORDS: [&str; 6] = ["Write", "Output", "FileOutput", "Save", "Viewer", "Export"];

impl Term {
    /// Looks a word up among the aliases of the registered nodes.
    pub fn of(word: &str, registry: &Registry) -> Option<Self> {
        let plain = |word: &str| word.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
        let wanted = plain(word);
        if OUTPUT_WORDS.iter().any(|known| plain(known) == wanted) {
            return Some(Self::Output);
        }
        registry.iter().map(|ty| ty.declaration()).find_map(|declaration| {
            let alias = declaration.aliases.iter().find(|alias| plain(alias.word) == wanted)?;
            Some(Self::Node { name: declaration.name, hint: alias.hint })
        })
    }

    /// Returns the remedy as a sentence.
    pub fn remedy(&self) -> String {
        match self {
            Self::Output => "no node writes: name it under \"outputs\", with a \"file\"".into(),
            Self::Node { name, hint: "" } => format!("use the node \"{name}\""),
            Self::Node { name, hint } => format!("use the node \"{name}\" ({hint})"),
        }
    }

    /// The type of the node, if it is one.
    pub fn node(&self) -> Option<&'static str> {
        if let Self::Node { name, .. } = self { Some(name) } else { None }
    }
}

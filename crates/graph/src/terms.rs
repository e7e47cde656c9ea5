//! The words of other programs, for documents that use them: nodes declare theirs, and outputs are no nodes.

use crate::Registry;

/// A word of other programs for the job of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alias {
    /// The word; case, spaces and underscores do not count.
    pub word: &'static str,
    /// The knob or way to do it, such as `its "fit"`; empty where the node's name says it.
    pub how: &'static str,
}

/// What does the job that another program's word names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// A node.
    Node {
        /// Its type.
        name: &'static str,
        /// How, see [`Alias::how`].
        how: &'static str,
    },
    /// The document's outputs.
    Output,
}

/// Words for a node that writes, which the document's outputs do.
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
            Some(Self::Node { name: declaration.name, how: alias.how })
        })
    }

    /// What to do, as a sentence.
    pub fn remedy(&self) -> String {
        match self {
            Self::Output => "no node writes: name it under \"outputs\", with a \"file\"".into(),
            Self::Node { name, how: "" } => format!("the node for that is \"{name}\""),
            Self::Node { name, how } => format!("the node for that is \"{name}\" ({how})"),
        }
    }

    /// The type of the node, if it is one.
    pub fn node(&self) -> Option<&'static str> {
        if let Self::Node { name, .. } = self { Some(name) } else { None }
    }
}

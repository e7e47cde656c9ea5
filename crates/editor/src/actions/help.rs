//! Pages of the help.

/// A page of the help.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum HelpPage {
    /// The list of all pages.
    Contents,
    /// The keys and commands.
    Keys,
    /// A node type, or a group of the document.
    Node(String),
    /// A chapter of the manual, by the name of its file without the extension.
    Chapter(String),
}

//! The step that follows once the open document may be left.

use std::path::PathBuf;

/// Step to take after the open document is saved or discarded.
#[derive(Clone, Debug, PartialEq)]
pub enum After {
    /// Start a new document.
    New,
    /// Start a new document from the template of this name.
    Template(&'static str),
    /// Ask which document to open.
    Ask,
    /// Open this document.
    Open(PathBuf),
    /// Render, which needs a saved document: outputs are written relative to its folder.
    Render,
    /// Close the window.
    Close,
}

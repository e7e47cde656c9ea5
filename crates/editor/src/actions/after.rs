//! What one goes on to.

use std::path::PathBuf;

/// What comes after this document.
#[derive(Clone, Debug, PartialEq)]
pub enum After {
    /// A new document.
    New,
    /// A question for a document to open.
    Ask,
    /// This document.
    Open(PathBuf),
    /// A run, which needs a folder.
    Render,
    /// Nothing: the window closes.
    Close,
}

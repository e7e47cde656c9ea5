//! What is looked at.

use crate::document::Sheet;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid::Access;

/// An output of a node, in a document as it is at one time.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The document.
    pub sheet: Arc<Sheet>,
    /// Grows with every change of the document.
    pub revision: u64,
    /// The node.
    pub node: usize,
    /// Its output.
    pub output: usize,
    /// The document's name, for messages.
    pub name: String,
    /// What its paths are relative to.
    pub folder: PathBuf,
    /// Which files it may reach: what else it may is another revision.
    pub access: Access,
}

impl Subject {
    pub(super) fn is(&self, other: &Self) -> bool {
        (self.revision, self.node, self.output) == (other.revision, other.node, other.output)
            && self.folder == other.folder
    }
}

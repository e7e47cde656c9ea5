//! The subject of an evaluation.

use crate::document::Sheet;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid::Access;

/// An output of a node, in a snapshot of the document.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The document.
    pub root: Arc<Sheet>,
    /// The sheet that has the node: the document, or the inside of a use of a group.
    pub sheet: Arc<Sheet>,
    /// Revision of the document.
    pub revision: u64,
    /// Index of the node.
    pub node: usize,
    /// Index of the node's output.
    pub output: usize,
    /// The document's name, for messages.
    pub name: String,
    /// Folder that paths in the document are relative to.
    pub folder: PathBuf,
    /// Files that the document may access; a change of permissions changes the revision.
    pub access: Access,
}

impl Subject {
    pub(super) fn is(&self, other: &Self) -> bool {
        (self.revision, self.node, self.output) == (other.revision, other.node, other.output)
            && self.folder == other.folder
            && self.sheet.prefix() == other.sheet.prefix()
    }

    /// Returns the name of the node in the expanded document.
    pub fn whole_name(&self) -> String {
        format!("{}{}", self.sheet.prefix(), self.sheet.nodes[self.node].name)
    }
}

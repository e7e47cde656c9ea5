//! Permissions given to a document: folders it may read or write outside its own.

use std::path::{Path, PathBuf};
use trochoid::{RefusedFile, Right};

/// Permission to read or write in a folder and everything below it. Serialized in the remembered form: a bare path
/// means reading.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
pub enum Grant {
    /// Permission to read in this folder.
    Read(PathBuf),
    /// Permission to write in a folder.
    Write {
        /// The folder.
        write: PathBuf,
    },
}

impl Grant {
    /// Returns the permission that lifts a refusal.
    pub(crate) fn of(refused: &RefusedFile) -> Self {
        let folder = refused.outside.folder().to_path_buf();
        match refused.right() {
            Right::Read => Self::Read(folder),
            Right::Write => Self::Write { write: folder },
        }
    }

    /// Returns the folder, the right, and the word for the right ("reading" or "writing").
    pub(crate) fn parts(&self) -> (&Path, Right, &'static str) {
        match self {
            Self::Read(folder) => (folder, Right::Read, "reading"),
            Self::Write { write } => (write, Right::Write, "writing"),
        }
    }
}

impl std::fmt::Display for Grant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (folder, _, doing) = self.parts();
        write!(f, "{doing} {}", folder.display())
    }
}

//! What a document is allowed.

use std::path::{Path, PathBuf};
use trochoid::{RefusedFile, Right};

/// A folder that a document was allowed, with all beneath it, and for what. As it is remembered: a path alone is of reading.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
pub enum Grant {
    /// It may read there.
    Read(PathBuf),
    /// It may write there.
    Write {
        /// Where.
        write: PathBuf,
    },
}

impl Grant {
    /// What was refused, allowed.
    pub(crate) fn of(refused: &RefusedFile) -> Self {
        let folder = refused.outside.folder().to_path_buf();
        match refused.right() {
            Right::Read => Self::Read(folder),
            Right::Write => Self::Write { write: folder },
        }
    }

    /// The folder, what may be done there, and the word for that.
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

//! Output files, and the reasons that they cannot be written.

use std::fmt;
use std::path::PathBuf;
use trochoid_graph::{OutputSpec, RefusedFile};

/// File to write for one frame, with its outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Indices of the outputs in the graph, each a layer of the file.
    pub outputs: Vec<usize>,
}

/// Reason that files cannot be named or written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The names of files have faults, such as one name for several pictures; lists all of them.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Pattern(Vec<NameFault>),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] trochoid_io::Error),
    /// The document may not write to the path that it names.
    #[error("{}", .0.diagnostic())]
    Refused(Box<RefusedFile>),
    /// The existing file was not written by Trochoid, is of another kind, or is truncated so that it cannot be
    /// identified.
    #[error(
        "{}: exists already and does not bear Trochoid's mark: it is a file of another program, of another kind, or cut \
         off\n  remedy: give another name, or replace it with --overwrite",
        path.display()
    )]
    Foreign {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file cannot be written to this path.
    #[error("{}: {reason}", path.display())]
    Destination {
        /// Path of the file.
        path: PathBuf,
        /// Reason for the failure.
        #[source]
        reason: NoDestination,
    },
    /// The folder cannot be made.
    #[error("{}: the folder cannot be made: {source}", path.display())]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// Reason for the failure.
        source: std::io::Error,
    },
}

/// Why no file can be written at a place.
#[derive(Debug, thiserror::Error)]
pub enum NoDestination {
    /// A folder stands there.
    #[error("is a folder; name a file")]
    Folder,
    /// A link stands there, which leads to itself.
    #[error("is a link that leads to itself; remove it, or give another name")]
    Loop,
    /// The system takes no such name.
    #[error("cannot be the name of a file there: {0}; give a shorter one")]
    Name(#[source] std::io::Error),
    /// Something else stands where its folder should.
    #[error("{} is no folder", .0.display())]
    NoFolder(PathBuf),
    /// The system lets no file into its folder.
    #[error("the folder {} takes no files: {source}", folder.display())]
    Closed {
        /// The folder.
        folder: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It could not be written.
    #[error("cannot be written: {0}")]
    Write(#[source] std::io::Error),
}

/// Fault in the name of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameFault {
    /// Place of the fault: an output of the document, or an option.
    pub place: String,
    /// Description of the fault.
    pub found: String,
    /// Suggested remedy.
    pub remedy: String,
}

impl fmt::Display for NameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}\n  remedy: {}", self.place, self.found, self.remedy)
    }
}

/// Returns the layer of an output: the one that the document names, else the name of the output if several outputs
/// share the file, else none.
pub(crate) fn layer<'s>(spec: &'s OutputSpec, file: &OutputFile) -> &'s str {
    match &spec.layer {
        Some(layer) => layer,
        None if file.outputs.len() > 1 => &spec.name,
        None => "",
    }
}

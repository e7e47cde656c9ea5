//! A file of pictures that is to be written, and why it cannot be.

use std::fmt;
use std::path::PathBuf;
use trochoid_graph::{Means, OutputSpec, Refused, quoted};

/// A file to be written for one frame, and the outputs that go into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// Indices of outputs of the graph, each a layer of the file.
    pub outputs: Vec<usize>,
}

/// Why files cannot be named or written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Files cannot be named so: everything that is wrong, such as one name for several pictures.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Pattern(Vec<NameFault>),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] trochoid_io::Error),
    /// The document wants it where it may not write.
    #[error("{}", .0.diagnostic())]
    Refused(Box<Refused>),
    /// Trochoid did not write the file that is there, or as another kind of file, or so little is left that nobody can tell.
    #[error("{0}\n  remedy: give another name, or move the file away that is there")]
    Foreign(ForeignFile),
    /// No file can be written there.
    #[error("{}: {reason}", path.display())]
    Destination {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        reason: NoDestination,
    },
    /// The folder cannot be made.
    #[error("{}: the folder cannot be made: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// File in the way that Trochoid did not write.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}: is there already, and does not bear Trochoid's mark of such a file: not written by it, of another kind, or cut off",
    path.display()
)]
pub struct ForeignFile {
    /// Path of the file.
    pub path: PathBuf,
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

/// Why files cannot be named so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameFault {
    /// Where.
    pub place: NamePlace,
    /// What is wrong.
    pub found: String,
    /// What to do.
    pub remedy: String,
    /// What a front end can offer for that, if anything.
    pub means: Option<Means>,
}

/// Place of a name that does not do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NamePlace {
    /// Item of an output of a document.
    Output {
        /// Document, line and column.
        place: String,
        /// The output's name.
        output: String,
        /// The item's key.
        item: &'static str,
    },
    /// Pattern that the caller gave.
    Pattern(String),
}

impl fmt::Display for NamePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Output { place, output, item } => write!(f, "{place}: output \"{output}\", {item}"),
            Self::Pattern(pattern) => f.write_str(&quoted(pattern)),
        }
    }
}

impl fmt::Display for NameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}\n  remedy: {}", self.place, self.found, self.remedy)
    }
}

/// The layer of an output: its own name for one, else the output's name where several share the file.
pub(crate) fn layer<'s>(spec: &'s OutputSpec, file: &OutputFile) -> &'s str {
    match &spec.layer {
        Some(layer) => layer,
        None if file.outputs.len() > 1 => &spec.name,
        None => "",
    }
}

//! Output files, and the reasons that they cannot be written.

use crate::recipe::LAYER;
use std::fmt;
use std::path::PathBuf;
use trochoid_graph::{Means, OutputSpec, RefusedFile, quoted};

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
    /// The output is a recipe, but the graph was evaluated without [recipes](trochoid_graph::CheckedGraph::with_recipes).
    #[error("output \"{0}\": found a color; expected its weights, from a graph with recipes")]
    NoRecipe(String),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] trochoid_io::Error),
    /// The document may not write to the path that it names.
    #[error("{}", .0.diagnostic())]
    Refused(Box<RefusedFile>),
    /// The existing file was not written by Trochoid, is of another kind, or is truncated so that it cannot be
    /// identified.
    #[error("{0}\n  remedy: give another name, or move the existing file away")]
    Foreign(ForeignFile),
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

/// Existing file that does not bear Trochoid's mark.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}: exists already and does not bear Trochoid's mark: it is a file of another program, of another kind, or cut off",
    path.display()
)]
pub struct ForeignFile {
    /// Path of the file.
    pub path: PathBuf,
}

/// Reason that a file cannot be written to a path.
#[derive(Debug, thiserror::Error)]
pub enum NoDestination {
    /// The path is a folder.
    #[error("is a folder; name a file")]
    Folder,
    /// The path is a symbolic link to itself.
    #[error("is a link that leads to itself; remove it, or give another name")]
    Loop,
    /// The operating system does not allow the name.
    #[error("cannot be the name of a file there: {0}; give a shorter one")]
    Name(#[source] std::io::Error),
    /// The parent is not a folder.
    #[error("{} is not a folder", .0.display())]
    NoFolder(PathBuf),
    /// The parent folder is not writable.
    #[error("the folder {} takes no files: {source}", folder.display())]
    Closed {
        /// The folder.
        folder: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Writing failed.
    #[error("cannot be written: {0}")]
    Write(#[source] std::io::Error),
}

/// Fault in the name of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameFault {
    /// Place of the fault.
    pub place: NamePlace,
    /// Description of the fault.
    pub found: String,
    /// Suggested remedy.
    pub remedy: String,
    /// Means of the remedy that a front end can offer, if any.
    pub means: Option<Means>,
}

/// Place of a fault in a name.
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

/// Returns the layer of an output: the one that the document names, else the name of the output if several outputs
/// share the file, else none. A recipe is never the main layer: it is `recipe` then.
pub(crate) fn layer<'s>(spec: &'s OutputSpec, file: &OutputFile) -> &'s str {
    match &spec.layer {
        Some(layer) if !layer.is_empty() || !spec.is_recipe => layer,
        _ if spec.is_recipe => LAYER,
        _ if file.outputs.len() > 1 => &spec.name,
        _ => "",
    }
}

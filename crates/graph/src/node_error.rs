//! Errors of nodes: data until they are shown, and the only place that puts them into words.

use crate::ItemName;
use std::error::Error;
use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reason that a node could not be evaluated.
///
/// The operator `?` turns any other error into [`NodeError::Failed`], which keeps it.
///
/// ```
/// use trochoid_graph::{BadData, NodeError};
/// fn pixel() -> Result<f32, NodeError> {
///     let bad = BadData::new("the weight −1", "at least 0", "correct the file").in_file("mask.exr").at_pixel((3, 7));
///     Err(bad.into())
/// }
/// let error = pixel().unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "mask.exr: pixel (3, 7): found the weight −1, expected at least 0; correct the file"
/// );
///
/// fn number() -> Result<f64, NodeError> {
///     Ok("x".parse::<f64>()?)
/// }
/// assert!(matches!(number(), Err(NodeError::Failed(error)) if error.get().is::<std::num::ParseFloatError>()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NodeError {
    /// The input data are invalid for the node.
    Data(Box<BadData>),
    /// A file cannot be read, or a model cannot run.
    Failed(Failure),
    /// A file does not contain what a knob names.
    Missing {
        /// Error of the file's reader.
        error: Failure,
        /// Knob that names it.
        knob: ItemName,
    },
    /// A reference at one sample takes more effort than is reasonable; others may be found.
    GivenUp(Box<BadData>),
    /// The user asked to stop. This error is never shown.
    Cancelled,
}

/// Invalid input data.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BadData {
    /// Place of the data; empty if it is the node itself.
    pub place: Box<DataPlace>,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do; empty if that is clear from what was expected.
    pub remedy: String,
}

/// Place in the inputs of a node, from the port or file down to the pixel. Every field is optional.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DataPlace {
    /// Port or knob.
    pub item: Option<ItemName>,
    /// File.
    pub file: Option<PathBuf>,
    /// Part of the file, from 0.
    pub part: Option<usize>,
    /// Channel of the part.
    pub channel: Option<String>,
    /// Pixel x, y of the picture.
    pub pixel: Option<(i64, i64)>,
}

/// Error of another library, shared.
#[derive(Clone)]
pub struct Failure(Arc<dyn Error + Send + Sync>);

impl BadData {
    /// Creates the error for data of the node itself.
    pub fn new(found: impl Display, expected: impl Into<String>, remedy: impl Into<String>) -> Self {
        let place = Box::default();
        Self { place, found: found.to_string(), expected: expected.into(), remedy: remedy.into() }
    }

    /// Adds the port or knob.
    pub fn of_item(mut self, item: ItemName) -> Self {
        self.place.item = Some(item);
        self
    }

    /// Adds the file.
    pub fn in_file(mut self, path: impl AsRef<Path>) -> Self {
        self.place.file = Some(path.as_ref().into());
        self
    }

    /// Adds the part of the file.
    pub fn in_part(mut self, part: usize) -> Self {
        self.place.part = Some(part);
        self
    }

    /// Adds the channel.
    pub fn in_channel(mut self, channel: impl Into<String>) -> Self {
        self.place.channel = Some(channel.into());
        self
    }

    /// Adds the pixel.
    pub fn at_pixel(mut self, pixel: (i64, i64)) -> Self {
        self.place.pixel = Some(pixel);
        self
    }
}

impl Failure {
    /// Returns the error.
    pub fn get(&self) -> &(dyn Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl NodeError {
    /// Creates the error of a file's reader that did not find what a knob names.
    pub fn missing(error: impl Error + Send + Sync + 'static, knob: ItemName) -> Self {
        Self::Missing { error: Failure(Arc::new(error)), knob }
    }

    /// Returns the error of another library that caused this one, if any.
    pub fn source(&self) -> Option<&(dyn Error + Send + Sync + 'static)> {
        match self {
            Self::Failed(error) | Self::Missing { error, .. } => Some(error.get()),
            Self::Data(_) | Self::GivenUp(_) | Self::Cancelled => None,
        }
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for NodeError {
    fn from(error: E) -> Self {
        Self::Failed(Failure(Arc::new(error)))
    }
}

impl From<BadData> for NodeError {
    fn from(data: BadData) -> Self {
        Self::Data(Box::new(data))
    }
}

impl Display for NodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Data(data) | Self::GivenUp(data) => data.fmt(f),
            Self::Failed(error) => Display::fmt(error.get(), f),
            Self::Missing { error, knob } => write!(f, "{}, in the node's \"{knob}\"", error.get()),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl Display for BadData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, found, expected, remedy } = self;
        write!(f, "{place}found {found}, expected {expected}")?;
        if remedy.is_empty() { Ok(()) } else { write!(f, "; {remedy}") }
    }
}

impl Display for DataPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { item, file, part, channel, pixel } = self;
        if let Some(item) = item {
            write!(f, "\"{item}\": ")?;
        }
        if let Some(file) = file {
            write!(f, "{}: ", file.display())?;
        }
        let within = [
            part.map(|part| format!("part {part}")),
            channel.as_ref().map(|channel| format!("channel \"{channel}\"")),
            pixel.map(|(x, y)| format!("pixel ({x}, {y})")),
        ];
        let within: Vec<String> = within.into_iter().flatten().collect();
        if within.is_empty() { Ok(()) } else { write!(f, "{}: ", within.join(", ")) }
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

/// Only the same error is equal to itself, because errors of unknown types cannot be compared.
impl PartialEq for Failure {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Failure {}

//! Why a node could not evaluate: data up to the line that shows them, and the one place that makes words of them.

use crate::ItemName;
use std::error::Error;
use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why a node could not evaluate.
///
/// Any other error becomes one by `?`, and is kept as it is.
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
    /// Input data are not what the node works on.
    Data(Box<BadData>),
    /// A file cannot be read, or a model cannot run.
    Failed(Failure),
    /// A file does not have what a knob names.
    Missing {
        /// What the file's reader says.
        error: Failure,
        /// The knob that names it.
        knob: ItemName,
    },
    /// The user asked to stop. Nobody sees this.
    Cancelled,
}

/// Input data that a node cannot work on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BadData {
    /// Where they are; empty where the node itself is the place.
    pub place: Box<DataPlace>,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do; empty where that follows from what was expected.
    pub remedy: String,
}

/// Where in a node's inputs data are, from the port or file down to the pixel. Each step may be open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DataPlace {
    /// The port or knob.
    pub item: Option<ItemName>,
    /// The file.
    pub file: Option<PathBuf>,
    /// Part of the file, from 0.
    pub part: Option<usize>,
    /// Channel of the part.
    pub channel: Option<String>,
    /// Pixel x, y of the picture.
    pub pixel: Option<(i64, i64)>,
}

/// Another library's error, shared.
#[derive(Clone)]
pub struct Failure(Arc<dyn Error + Send + Sync>);

impl BadData {
    /// Data of the node itself.
    pub fn new(found: impl Display, expected: impl Into<String>, remedy: impl Into<String>) -> Self {
        let place = Box::default();
        Self { place, found: found.to_string(), expected: expected.into(), remedy: remedy.into() }
    }

    /// The same, of a port or knob.
    pub fn of_item(mut self, item: ItemName) -> Self {
        self.place.item = Some(item);
        self
    }

    /// The same, in a file.
    pub fn in_file(mut self, path: impl AsRef<Path>) -> Self {
        self.place.file = Some(path.as_ref().into());
        self
    }

    /// The same, in a part of the file.
    pub fn in_part(mut self, part: usize) -> Self {
        self.place.part = Some(part);
        self
    }

    /// The same, in a channel.
    pub fn in_channel(mut self, channel: impl Into<String>) -> Self {
        self.place.channel = Some(channel.into());
        self
    }

    /// The same, at a pixel.
    pub fn at_pixel(mut self, pixel: (i64, i64)) -> Self {
        self.place.pixel = Some(pixel);
        self
    }
}

impl Failure {
    /// The error itself.
    pub fn get(&self) -> &(dyn Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl NodeError {
    /// The error of a file's reader that did not find what a knob names.
    pub fn missing(error: impl Error + Send + Sync + 'static, knob: ItemName) -> Self {
        Self::Missing { error: Failure(Arc::new(error)), knob }
    }

    /// The other library's error that it comes from, if any.
    pub fn source(&self) -> Option<&(dyn Error + Send + Sync + 'static)> {
        match self {
            Self::Failed(error) | Self::Missing { error, .. } => Some(error.get()),
            Self::Data(_) | Self::Cancelled => None,
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
            Self::Data(data) => data.fmt(f),
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

/// Two are equal if they are the same error: others cannot be told apart by their types.
impl PartialEq for Failure {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Failure {}

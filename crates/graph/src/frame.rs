//! What all nodes of one frame share, and how paths name frames.

use crate::{Access, NodeError};
use std::path::{Path, PathBuf};
use trochoid_image::{Format, WorkingSpace};

/// What all nodes of one frame share.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameContext {
    /// The frame's number.
    pub frame: i64,
    /// Seconds since the first frame.
    pub time: f64,
    /// The document's picture format.
    pub format: Format,
    /// The document's working space.
    pub space: WorkingSpace,
    /// Folder that paths in the document are relative to.
    pub folder: PathBuf,
    /// Most memory that decoding one file may take, bytes.
    pub memory_limit: u64,
    /// Which files the document may reach.
    pub access: Access,
}

impl FrameContext {
    /// A path of the document, with `####` and `%04d` replaced by the frame.
    pub fn path(&self, text: &str) -> PathBuf {
        let text = expand_frame(text, self.frame);
        let path = Path::new(&text);
        if path.is_absolute() { path.into() } else { self.folder.join(path) }
    }

    /// Whether the document may reach a file that another file names. Those that it names itself, and those of
    /// [`Stage::files`](crate::Stage::files), the engine has asked for.
    ///
    /// # Errors
    /// It may not.
    pub fn check_file(&self, path: &Path) -> Result<(), NodeError> {
        self.access.check(path).map_err(|outside| NodeError::new(format!("{}: {outside}", path.display())))
    }
}

/// Replaces the first run of `#`, or the first `%0Nd`, by the frame's number, padded with zeros.
///
/// ```
/// use trochoid_graph::expand_frame;
/// assert_eq!(expand_frame("a.####.exr", 12), "a.0012.exr");
/// assert_eq!(expand_frame("a.%03d.exr", 12), "a.012.exr");
/// assert_eq!(expand_frame("a.exr", 12), "a.exr");
/// ```
pub fn expand_frame(pattern: &str, frame: i64) -> String {
    let pad = |width: usize| {
        let sign = if frame < 0 { "-" } else { "" };
        format!("{sign}{:0width$}", frame.unsigned_abs())
    };
    if let Some(start) = pattern.find('#') {
        let width = pattern[start..].chars().take_while(|&c| c == '#').count();
        return format!("{}{}{}", &pattern[..start], pad(width), &pattern[start + width..]);
    }
    if let Some(start) = pattern.find('%')
        && let Some(end) = pattern[start..].find('d').map(|at| start + at)
        && let Ok(width) = pattern[start + 1..end].parse::<usize>()
        && width <= 16
    {
        return format!("{}{}{}", &pattern[..start], pad(width), &pattern[end + 1..]);
    }
    pattern.into()
}

//! Texts as a shell takes them, for remedies that are to be typed.

use std::path::Path;

/// A text as one word of a POSIX shell: as it stands, or in quotes where it needs them.
///
/// ```
/// use trochoid_graph::quoted;
/// assert_eq!(quoted("shots/a"), "shots/a");
/// assert_eq!(quoted("take #3"), "'take #3'");
/// ```
pub fn quoted(text: &str) -> String {
    shlex::Quoter::new().allow_nul(true).quote(text).map_or_else(|_| text.into(), Into::into)
}

/// The same of a path.
pub fn quoted_path(path: &Path) -> String {
    quoted(&path.display().to_string())
}

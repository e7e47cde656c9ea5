//! Quoting for a shell, for remedies that users can copy.

use std::path::Path;

/// Formats a text as one word of a POSIX shell, with quotes if it needs them.
///
/// ```
/// use trochoid_graph::quoted;
/// assert_eq!(quoted("shots/a"), "shots/a");
/// assert_eq!(quoted("take #3"), "'take #3'");
/// ```
pub fn quoted(text: &str) -> String {
    shlex::Quoter::new().allow_nul(true).quote(text).map_or_else(|_| text.into(), Into::into)
}

/// Formats a path as one word of a POSIX shell.
pub fn quoted_path(path: &Path) -> String {
    quoted(&path.display().to_string())
}

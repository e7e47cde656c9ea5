use std::path::{Path, PathBuf};

/// Action of opening a file for reading, for messages.
pub(crate) const OPEN: &str = "open the file";

/// Kind of entry that can be selected by name in a picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// A part of an EXR file.
    Part,
    /// Channels whose names share a prefix.
    Layer,
    /// A single channel.
    Channel,
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Part => "part",
            Self::Layer => "layer",
            Self::Channel => "channel",
        })
    }
}

/// Reason that a file was not read or written. Every message names the place, what was found, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to open, read or write.
    #[error("{}: cannot {action}: {source}{}", path.display(), remedy(action, source))]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Attempted action, such as "open the file".
        action: &'static str,
        /// Reason from the system.
        source: std::io::Error,
    },
    /// The path does not name a regular file.
    #[error("{}: found {found}, expected a file: {}", path.display(), instead(found))]
    NotAFile {
        /// Path that was to be read.
        path: PathBuf,
        /// Actual type, such as "a pipe".
        found: &'static str,
    },
    /// The file is longer than the limit for its kind.
    #[error("{}: found {found} bytes, expected at most {limit}: make the file smaller, or name another", path.display())]
    TooLong {
        /// Path of the file.
        path: PathBuf,
        /// Length of the file in bytes; a lower bound if the file grows while it is read.
        found: u64,
        /// Maximum length in bytes.
        limit: u64,
    },
    /// The file is not text in UTF-8.
    #[error(
        "{}: line {line}, column {column}: found the byte {byte:#04x}, expected text in UTF-8: save the file as UTF-8",
        path.display()
    )]
    NotText {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// First byte that is not valid UTF-8.
        byte: u8,
    },
    /// The bytes contradict the file's format: damaged, truncated, or not a picture.
    #[error("{}: {place}: found {found}, expected {expected}; the file is damaged or incomplete: export it again", path.display())]
    Invalid {
        /// Path of the file.
        path: PathBuf,
        /// Place in the file: part, attribute, chunk.
        place: String,
        /// What was found there.
        found: String,
        /// What was expected there.
        expected: String,
    },
    /// The file is of an unsupported kind.
    #[error(
        "{}: found {found}, expected EXR, PNG, JPEG or TIFF: convert it, or name another file",
        path.display()
    )]
    NoPicture {
        /// Path of the file.
        path: PathBuf,
        /// Description of the file by its first bytes.
        found: String,
    },
    /// The file may be valid, but its content is not supported.
    #[error("{}: {place}: {found} is not supported: {remedy}", path.display())]
    Unsupported {
        /// Path of the file.
        path: PathBuf,
        /// Part or channel.
        place: String,
        /// Unsupported content.
        found: String,
        /// How to make a supported file.
        remedy: &'static str,
    },
    /// The header claims more than the limits allow; nothing was decoded.
    #[error("{}: {place}: {found} {what}, at most {limit} are read: crop or scale the picture", path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Part and window.
        place: String,
        /// Quantity that exceeds its limit.
        what: &'static str,
        /// Claimed amount.
        found: u64,
        /// Allowed amount.
        limit: u64,
    },
    /// The computer does not have enough memory, although the limits allow the picture.
    #[error("{}: {place}: {bytes} bytes of memory are not available: select fewer channels or lower the limit", path.display())]
    OutOfMemory {
        /// Path of the file.
        path: PathBuf,
        /// Part and window.
        place: String,
        /// Requested bytes.
        bytes: u64,
    },
    /// The file has no part, layer or channel with the requested name.
    #[error("{}: no {kind} \"{name}\"{}; the file has {}{}", path.display(), within(place), listed(existing), choose(kind, existing))]
    NotFound {
        /// Path of the file.
        path: PathBuf,
        /// Kind of entry.
        kind: Entry,
        /// The wanted name.
        name: String,
        /// Place that was searched; empty for the whole file.
        place: String,
        /// Existing names, most similar first.
        existing: Vec<String>,
    },
    /// The selection matches several layers or channels.
    #[error("{}: {what} fits {}: {remedy}", path.display(), listed(existing))]
    Ambiguous {
        /// Path of the file.
        path: PathBuf,
        /// Description of the selection.
        what: String,
        /// Names that it matches.
        existing: Vec<String>,
        /// How to select one of them.
        remedy: &'static str,
    },
    /// A value does not fit in the file's sample type; nothing was written.
    #[error("{}: channel \"{channel}\", pixel ({x}, {y}): {value} is refused, expected {expected}", path.display())]
    Unrepresentable {
        /// Path of the file to write.
        path: PathBuf,
        /// Name of the channel.
        channel: String,
        /// Column of the pixel.
        x: i64,
        /// Row of the pixel.
        y: i64,
        /// Value that does not fit.
        value: f32,
        /// Legal range, and what to do.
        expected: &'static str,
    },
    /// The picture to write is inconsistent or does not fit the format; nothing was written.
    #[error("{}: {found} cannot be written: {expected}", path.display())]
    Unwritable {
        /// Path of the file to write.
        path: PathBuf,
        /// What was to be written.
        found: String,
        /// What is required instead, or what to do.
        expected: &'static str,
    },
    /// The existing file may not be replaced; nothing was written.
    #[error(
        "{}: the file cannot be written: the existing file is not Trochoid's: give another name, or move the existing file away",
        path.display()
    )]
    Foreign {
        /// Path of the file.
        path: PathBuf,
    },
}

impl Error {
    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Io { path, .. }
            | Self::NotAFile { path, .. }
            | Self::TooLong { path, .. }
            | Self::NotText { path, .. }
            | Self::Invalid { path, .. }
            | Self::NoPicture { path, .. }
            | Self::Unsupported { path, .. }
            | Self::TooLarge { path, .. }
            | Self::OutOfMemory { path, .. }
            | Self::NotFound { path, .. }
            | Self::Ambiguous { path, .. }
            | Self::Unrepresentable { path, .. }
            | Self::Unwritable { path, .. }
            | Self::Foreign { path } => path,
        }
    }

    /// Returns the message without the name of the file.
    #[cfg(feature = "pictures")]
    pub(crate) fn invalid(
        path: &Path,
        place: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Invalid { path: path.into(), place: place.into(), found: found.into(), expected: expected.into() }
    }

    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, action, source }
    }

    #[cfg(feature = "pictures")]
    pub(crate) fn unwritable(path: &Path, found: impl Into<String>, expected: &'static str) -> Self {
        Self::Unwritable { path: path.into(), found: found.into(), expected }
    }
}

/// Returns what to do if the system does not open a file.
fn remedy(action: &str, source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::NotFound if action == OPEN => "; correct the path, or make the file first",
        std::io::ErrorKind::PermissionDenied if action == OPEN => "; allow reading it",
        _ => "",
    }
}

/// Returns what to do about a path that is not a regular file.
fn instead(found: &str) -> &'static str {
    if found == "a folder" { "name a file in it" } else { "copy its contents to a file, or name another" }
}

fn within(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(" in {place}") }
}

/// Returns what to do about a name that the file does not have.
fn choose(kind: &Entry, existing: &[String]) -> String {
    match existing {
        [] => format!(": name another file, or no {kind}"),
        [nearest, ..] => format!(": name one of these, such as \"{nearest}\""),
    }
}

/// Maximum number of names in a message: a Blender file can have a hundred layers.
const NAMES: usize = 12;

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".into();
    }
    let mut list: Vec<String> = names.iter().take(NAMES).map(|name| format!("\"{name}\"")).collect();
    if names.len() > NAMES {
        list.push(format!("{} more", names.len() - NAMES));
    }
    list.join(", ")
}

/// Returns text of a file for a message, without control characters and of limited length.
#[cfg(any(test, feature = "pictures"))]
pub(crate) fn printable(text: &str) -> String {
    const LENGTH: usize = 80;
    let mut shown: String = text.chars().take(LENGTH).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(LENGTH).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_place_and_remedy() {
        let error = Error::NotFound {
            path: "a.exr".into(),
            kind: Entry::Layer,
            name: "dept".into(),
            place: String::new(),
            existing: vec!["depth".into(), "".into()],
        };
        assert_eq!(
            error.to_string(),
            "a.exr: no layer \"dept\"; the file has \"depth\", \"\": name one of these, such as \"depth\""
        );
        let error = Error::invalid(Path::new("a.exr"), "part 0, chunk 3", "12 bytes", "40 bytes");
        assert_eq!(
            error.to_string(),
            "a.exr: part 0, chunk 3: found 12 bytes, expected 40 bytes; the file is damaged or incomplete: export it again"
        );
    }

    #[test]
    fn hostile_names_are_made_printable() {
        assert_eq!(printable("a\u{1b}[31m\n"), "a\u{fffd}[31m\u{fffd}");
        assert_eq!(printable(&"x".repeat(500)).chars().count(), 81);
    }
}

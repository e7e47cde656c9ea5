use std::path::{Path, PathBuf};

/// What is attempted first with a file that is to be read.
pub(crate) const OPEN: &str = "open the file";

/// What can be selected by name in a picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// A part of an EXR file.
    Part,
    /// Channels whose names begin alike.
    Layer,
    /// One channel.
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

/// Why a file was not read or not written. Every message names the place, what was found, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to open, read or write.
    #[error("{}: cannot {action}: {source}{}", path.display(), remedy(action, source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What was attempted, such as "open the file".
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// What has this name is no file.
    #[error("{}: found {found}, expected a file: {}", path.display(), instead(found))]
    NotAFile {
        /// What was to be read.
        path: PathBuf,
        /// What it is, such as "a pipe".
        found: &'static str,
    },
    /// The file is longer than what is read of its kind.
    #[error("{}: found {found} bytes, expected at most {limit}: make the file smaller, or name another", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its bytes; at least, where it grows while it is read.
        found: u64,
        /// Bytes that are read.
        limit: u64,
    },
    /// The file is no text.
    #[error(
        "{}: line {line}, column {column}: found the byte {byte:#04x}, expected text in UTF-8: save the file as UTF-8",
        path.display()
    )]
    NotText {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The first byte that is no UTF-8.
        byte: u8,
    },
    /// The bytes contradict the file's format: damaged, truncated, or not a picture.
    #[error("{}: {place}: found {found}, expected {expected}; the file is damaged or incomplete: export it again", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Part, attribute, chunk.
        place: String,
        /// What stands there.
        found: String,
        /// What belongs there.
        expected: String,
    },
    /// The file is of a kind that is not read.
    #[error(
        "{}: found {found}, expected EXR, PNG, JPEG or TIFF: convert it, or name another file",
        path.display()
    )]
    NoPicture {
        /// The file.
        path: PathBuf,
        /// What it is, by its first bytes.
        found: String,
    },
    /// The file may be valid, but this kind of content is not read.
    #[error("{}: {place}: {found} is not supported: {remedy}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Part or channel.
        place: String,
        /// The unsupported content.
        found: String,
        /// How to make a file that is read.
        remedy: &'static str,
    },
    /// The header claims more than the limits allow; nothing was decoded.
    #[error("{}: {place}: {found} {what}, at most {limit} are read: crop or scale the picture", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Part and window.
        place: String,
        /// What is counted.
        what: &'static str,
        /// Count claimed.
        found: u64,
        /// Count allowed.
        limit: u64,
    },
    /// The computer has not enough memory, though the limits allow the picture.
    #[error("{}: {place}: {bytes} bytes of memory are not available: select fewer channels or lower the limit", path.display())]
    OutOfMemory {
        /// The file.
        path: PathBuf,
        /// Part and window.
        place: String,
        /// Bytes asked for.
        bytes: u64,
    },
    /// The file has no part, layer or channel of the wanted name.
    #[error("{}: no {kind} \"{name}\"{}; the file has {}{}", path.display(), within(place), listed(existing), choose(kind, existing))]
    NotFound {
        /// The file.
        path: PathBuf,
        /// What the name is of.
        kind: Entry,
        /// The wanted name.
        name: String,
        /// Where it was sought; empty for the whole file.
        place: String,
        /// What exists, nearest name first.
        existing: Vec<String>,
    },
    /// The selection fits several layers or channels.
    #[error("{}: {what} fits {}: {remedy}", path.display(), listed(existing))]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// The selection.
        what: String,
        /// What it fits.
        existing: Vec<String>,
        /// How to choose.
        remedy: &'static str,
    },
    /// A value that the file's sample type cannot hold; nothing was written.
    #[error("{}: channel \"{channel}\", pixel ({x}, {y}): {value} is refused, expected {expected}", path.display())]
    Unrepresentable {
        /// The file that was to be written.
        path: PathBuf,
        /// Channel.
        channel: String,
        /// Column.
        x: i64,
        /// Row.
        y: i64,
        /// The value.
        value: f32,
        /// The legal range, and what to do.
        expected: &'static str,
    },
    /// The picture handed over for writing contradicts itself or the format; nothing was written.
    #[error("{}: {found} cannot be written: {expected}", path.display())]
    Unwritable {
        /// The file that was to be written.
        path: PathBuf,
        /// What was handed over.
        found: String,
        /// What is needed instead.
        expected: &'static str,
    },
    /// The file that stands there may not be replaced; nothing was written.
    #[error(
        "{}: the file cannot be written: what stands there is not Trochoid's: give another name, or move the file away \
         that is there",
        path.display()
    )]
    Foreign {
        /// The file that was to be written.
        path: PathBuf,
    },
}

impl Error {
    /// The file in question.
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

/// What to do about a file that the system does not open.
fn remedy(action: &str, source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::NotFound if action == OPEN => "; correct the path, or make the file first",
        std::io::ErrorKind::PermissionDenied if action == OPEN => "; allow reading it",
        _ => "",
    }
}

/// What to do about something that is no file.
fn instead(found: &str) -> &'static str {
    if found == "a folder" { "name a file in it" } else { "copy its contents to a file, or name another" }
}

fn within(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(" in {place}") }
}

/// What to do about a name that the file does not have.
fn choose(kind: &Entry, existing: &[String]) -> String {
    match existing {
        [] => format!(": name another file, or no {kind}"),
        [nearest, ..] => format!(": name one of these, such as \"{nearest}\""),
    }
}

/// At most this many names in a message: a Blender file can have a hundred layers.
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

/// Text of a file, fit for a message: no control characters, not endless.
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

//! Data that all nodes share at a frame, and frame numbers in paths.

use crate::{Access, quoted};
use std::path::PathBuf;
use trochoid_image::{Format, WorkingSpace};

/// Data that all nodes share at a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameContext {
    /// Frame number.
    pub frame: i64,
    /// Seconds since the first frame.
    pub time: f64,
    /// Format of the pictures that are made.
    pub format: Format,
    /// The document's own format, from which [`format`](Self::format) may differ. Sizes of files are compared with it. It is the same if the
    /// document states none.
    pub document_format: Format,
    /// Working space of the document.
    pub space: WorkingSpace,
    /// Folder to which paths in the document are relative.
    pub folder: PathBuf,
    /// Largest memory that decoding one file may take, in bytes.
    pub memory_limit: u64,
    /// Files that the document may reach.
    pub access: Access,
}

impl FrameContext {
    /// Returns a path of the document, with `####` or `%04d` replaced by the frame, see [`expand_frame`].
    pub fn path(&self, text: &str) -> PathBuf {
        let expanded = PathBuf::from(expand_frame(text, self.frame));
        if expanded.is_absolute() { expanded } else { self.folder.join(expanded) }
    }
}

/// Replaces the first run of `#`, or, if there is none, the first `%0Nd`, with the frame number, padded with zeros.
/// `\#` and `\%` stand for the signs `#` and `%` in the name itself.
///
/// ```
/// use trochoid_graph::expand_frame;
/// assert_eq!(expand_frame("a.####.exr", 12), "a.0012.exr");
/// assert_eq!(expand_frame("a.%03d.exr", 12), "a.012.exr");
/// assert_eq!(expand_frame("a.exr", 12), "a.exr");
/// assert_eq!(expand_frame(r"take \#3.##.exr", 12), "take #3.12.exr");
/// assert_eq!(expand_frame(r"50\%d.exr", 12), "50%d.exr");
/// ```
pub fn expand_frame(pattern: &str, frame: i64) -> String {
    let Some((before, width, after)) = split_frame(pattern) else { return plain(pattern) };
    let sign = if frame < 0 { "-" } else { "" };
    format!("{before}{sign}{:0width$}{after}", frame.unsigned_abs())
}

/// Splits a pattern at the frame, for programs that expand it themselves: the text before the frame, its least number of
/// digits, and the text after it. `None` if all frames have the same name.
///
/// ```
/// use trochoid_graph::split_frame;
/// assert_eq!(split_frame(r"take \#3.##.exr"), Some(("take #3.".into(), 2, ".exr".into())));
/// assert_eq!(split_frame("a.exr"), None);
/// ```
pub fn split_frame(pattern: &str) -> Option<(String, usize, String)> {
    let (start, end, width) = placeholder(pattern)?;
    Some((plain(&pattern[..start]), width, plain(&pattern[end..])))
}

/// Returns a text in which `\#` and `\%` are the signs themselves.
fn plain(text: &str) -> String {
    text.replace(r"\#", "#").replace(r"\%", "%")
}

/// Escapes a name, so that [`expand_frame`] returns the name unchanged at every frame.
///
/// ```
/// use trochoid_graph::{escape_frame, expand_frame};
/// assert_eq!(escape_frame("take #3.exr"), r"take \#3.exr");
/// assert_eq!(expand_frame(&escape_frame("take #3, 50%.exr"), 12), "take #3, 50%.exr");
/// ```
pub fn escape_frame(name: &str) -> String {
    name.replace('#', r"\#").replace('%', r"\%")
}

/// Finds the frame in a pattern: start, end and minimum number of digits.
fn placeholder(pattern: &str) -> Option<(usize, usize, usize)> {
    let first = |sign: char| placeholders(pattern).find(|(start, ..)| pattern[*start..].starts_with(sign));
    first('#').or_else(|| first('%'))
}

/// Finds every run of `#` and every `%0Nd` that is not escaped: start, end and minimum number of digits.
fn placeholders(pattern: &str) -> impl Iterator<Item = (usize, usize, usize)> {
    let mut behind = 0;
    pattern.match_indices(['#', '%']).filter_map(move |(start, sign)| {
        if start < behind || pattern[..start].ends_with('\\') {
            return None;
        }
        let (end, width) = if sign == "#" {
            let width = pattern[start..].bytes().take_while(|byte| *byte == b'#').count();
            (start + width, width)
        } else {
            let end = start + pattern[start..].find('d')?;
            (end + 1, pattern[start + 1..end].parse().ok().filter(|width| *width <= 16)?)
        };
        behind = end;
        Some((start, end, width))
    })
}

/// Escapes all runs of `#` and `%0Nd` but the last, so that only that one stands for the frame; `None` if there is at
/// most one run.
///
/// ```
/// use trochoid_graph::one_frame_pattern;
/// assert_eq!(one_frame_pattern("dir#/x.%04d.png").as_deref(), Some(r"dir\#/x.%04d.png"));
/// assert_eq!(one_frame_pattern(r"dir\#/x.%04d.png"), None);
/// ```
pub fn one_frame_pattern(pattern: &str) -> Option<String> {
    let mut found: Vec<(usize, usize, usize)> = placeholders(pattern).collect();
    found.pop().filter(|_| !found.is_empty())?;
    let mut one = pattern.to_owned();
    for &(start, end, _) in found.iter().rev() {
        one.replace_range(start..end, &escape_frame(&pattern[start..end]));
    }
    Some(one)
}

/// Returns the remedy for a missing file if a file exists whose folders or name contain `#` or `%` themselves; `None`
/// otherwise.
///
/// `text` is the path as written in the document.
pub fn escape_remedy(frame: &FrameContext, text: &str) -> Option<String> {
    let mut written = text.to_owned();
    // The first signs are read as the frame, so they are escaped first.
    while let Some((start, end, _)) = placeholder(&written) {
        let signs = escape_frame(&written[start..end]);
        written.replace_range(start..end, &signs);
        let path = frame.path(&written);
        if path.exists() {
            let (json, word) = (serde_json::Value::from(written.as_str()), quoted(&written));
            return Some(format!(
                "{} exists: write a backslash before a # or % that is part of a name: {json} in a document, {word} in a shell",
                path.display()
            ));
        }
    }
    None
}

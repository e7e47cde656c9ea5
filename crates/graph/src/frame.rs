//! What all nodes of one frame share, and how paths name frames.

use crate::{Access, quoted};
use std::path::PathBuf;
use trochoid_image::{Format, WorkingSpace};

/// What all nodes of one frame share.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameContext {
    /// The frame's number.
    pub frame: i64,
    /// Seconds since the first frame.
    pub time: f64,
    /// The format that pictures are drawn at.
    pub format: Format,
    /// The document's own, where that is another: what it is compared with that comes from files.
    pub whole: Format,
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
    /// A path of the document, with `####` and `%04d` replaced by the frame, see [`expand_frame`].
    pub fn path(&self, text: &str) -> PathBuf {
        let expanded = PathBuf::from(expand_frame(text, self.frame));
        if expanded.is_absolute() { expanded } else { self.folder.join(expanded) }
    }
}

/// Replaces the first run of `#`, or where there is none the first `%0Nd`, by the frame's number, padded with zeros. A `\#` is a
/// `#` of the name itself, and `\%` a `%`.
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
    let plain = |text: &str| text.replace(r"\#", "#").replace(r"\%", "%");
    let Some((start, end, width)) = placeholder(pattern) else { return plain(pattern) };
    let sign = if frame < 0 { "-" } else { "" };
    format!("{}{sign}{:0width$}{}", plain(&pattern[..start]), frame.unsigned_abs(), plain(&pattern[end..]))
}

/// A name as [`expand_frame`] takes it, so that the same name comes out at every frame.
///
/// ```
/// use trochoid_graph::{escape_frame, expand_frame};
/// assert_eq!(escape_frame("take #3.exr"), r"take \#3.exr");
/// assert_eq!(expand_frame(&escape_frame("take #3, 50%.exr"), 12), "take #3, 50%.exr");
/// ```
pub fn escape_frame(name: &str) -> String {
    name.replace('#', r"\#").replace('%', r"\%")
}

/// Where a pattern has the frame, and how many digits at least.
fn placeholder(pattern: &str) -> Option<(usize, usize, usize)> {
    let first = |sign: char| placeholders(pattern).find(|(start, ..)| pattern[*start..].starts_with(sign));
    first('#').or_else(|| first('%'))
}

/// Every run of `#` and every `%0Nd` that is not escaped: where, and how many digits at least.
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

/// A pattern of which only the last of several runs of `#` and `%0Nd` stands for the frame, and the others for themselves;
/// nothing where there is one at most.
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

/// What to write where there is no file of an expanded path, but one whose folders or name have a `#` or `%` of their own;
/// nothing otherwise.
///
/// `text` is the path as a document of the frame writes it.
pub fn escape_remedy(frame: &FrameContext, text: &str) -> Option<String> {
    let mut written = text.to_owned();
    // The first signs count as the frame, so they are the first to be of the name.
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

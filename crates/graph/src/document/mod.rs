//! Documents before validation: parsed JSON, in which every value has its place.

mod assign;
mod canonical;
mod include;
mod palette;
mod view;

use crate::spanned::{Entry, Json, LineIndex, Spanned, line_and_column, parse, shorten};
use crate::{Diagnostic, Severity};
use include::Include;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Largest size of a document, in bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// Largest number of nodes in a document.
pub const MAX_NODES: usize = 100_000;
/// Largest size of another file of a document, a palette or an included document, in bytes.
pub const MAX_FILE_BYTES: usize = 1 << 20;

/// A parsed document.
#[derive(Clone, Debug)]
pub struct Document {
    name: Arc<str>,
    text: String,
    /// Made when the place of the first fault is needed.
    lines: OnceLock<LineIndex>,
    pub(crate) root: Spanned,
    /// Assignments, in order; their values have offsets from [`ASSIGNED`] on.
    assignments: Vec<String>,
    /// Other files of which it consists, in the order in which they were read; their values have offsets from [`FILED`] on.
    files: Vec<ReadFile>,
    includes: Vec<Include>,
    /// Offsets of outputs that were added to look at nodes.
    views: Vec<usize>,
    /// Whether the size of pictures was assumed.
    pub(crate) has_no_size: bool,
}

/// First offset of assignments: offset − `ASSIGNED` is the index of one.
const ASSIGNED: usize = usize::MAX / 2;
/// First offset of other files: the one with index i has the offsets from `FILED` + i · [`STRIDE`].
const FILED: usize = usize::MAX / 4;
/// Distance between the first offsets of two files.
const STRIDE: usize = 2 * MAX_FILE_BYTES;

/// A palette or an included document.
#[derive(Clone, Debug)]
struct ReadFile {
    path: PathBuf,
    /// The path, as diagnostics call it.
    name: Arc<str>,
    text: String,
    /// Folder of an included document, relative to the one that is loaded.
    folder: Option<String>,
}

/// Where a value comes from.
pub(crate) struct Origin {
    /// Name of the document or file, or the assignment.
    pub(crate) file: Arc<str>,
    /// Whether it is an assignment.
    pub(crate) is_assigned: bool,
    /// Line, from 1; 0 in an assignment.
    pub(crate) line: usize,
    /// Column in characters, from 1; 0 in an assignment.
    pub(crate) column: usize,
}

impl Document {
    /// Parses a JSON text; diagnostics call it `name`.
    ///
    /// # Errors
    /// The text is not JSON, or exceeds the limits of size or depth.
    pub fn parse(name: &str, text: &str) -> Result<Self, Box<Diagnostic>> {
        if text.len() > MAX_BYTES {
            let found = format!("a document of {} bytes", text.len());
            let remedy = "split the scene into several documents";
            return Err(fault(name, (0, 0), found, format!("at most {MAX_BYTES} bytes"), remedy));
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let root = json(name, text, "a document")?;
        let mut document = Self {
            name: name.into(),
            text: text.into(),
            lines: OnceLock::new(),
            root: Spanned { offset: 0, json: Json::Null },
            assignments: Vec::new(),
            files: Vec::new(),
            includes: Vec::new(),
            views: Vec::new(),
            has_no_size: false,
        };
        document.find_includes(&root, "");
        document.root = root;
        Ok(document)
    }

    /// Gives the document a size of pictures if it states no format. Then pictures of any size are as it means them, and
    /// none is a scaled draft.
    pub fn assume_size(&mut self, [width, height]: [u32; 2]) {
        let Json::Object(entries) = &mut self.root.json else { return };
        if entries.iter().any(|entry| entry.key == "format") {
            return;
        }
        self.has_no_size = true;
        let side = |key: &str, side: u32| Entry {
            key: key.into(),
            offset: 0,
            value: Spanned { offset: 0, json: Json::Number(side.into()) },
        };
        let json = Json::Object(vec![side("width", width), side("height", height)]);
        entries.push(Entry { key: "format".into(), offset: 0, value: Spanned { offset: 0, json } });
    }

    /// Returns the name of the document.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the paths of the other files of which it consists.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.path.as_path())
    }

    /// Returns where a value comes from that has this offset.
    pub(crate) fn origin(&self, offset: usize) -> Origin {
        if let Some(index) = offset.checked_sub(ASSIGNED) {
            let assignment = self.assignments.get(index).map_or("", String::as_str);
            return Origin { file: shorten(assignment).into(), is_assigned: true, line: 0, column: 0 };
        }
        if let Some(file) = self.file_at(offset) {
            let (line, column) = line_and_column(&file.text, (offset - FILED) % STRIDE);
            return Origin { file: file.name.clone(), is_assigned: false, line, column };
        }
        let (line, column) = self.lines.get_or_init(|| LineIndex::new(&self.text)).find(&self.text, offset);
        Origin { file: self.name.clone(), is_assigned: false, line, column }
    }

    /// Returns the other file in which a value is that has this offset.
    fn file_at(&self, offset: usize) -> Option<&ReadFile> {
        self.files.get(offset.checked_sub(FILED)? / STRIDE)
    }

    /// Returns the document as canonical text: keys sorted, `ui` and notes left out, other files and
    /// assignments applied. Documents with
    /// the same canonical text have the same results.
    pub fn canonical(&self) -> String {
        self.canonical_with(&HashMap::new())
    }

    /// Does the same; texts at some offsets are written differently.
    pub(crate) fn canonical_with(&self, moved: &HashMap<usize, String>) -> String {
        let mut text = String::with_capacity(self.text.len());
        canonical::write(&self.root, true, moved, &mut text);
        text
    }
}

/// Returns an error at a line and column of a file.
fn fault(
    file: &str,
    (line, column): (usize, usize),
    found: String,
    expected: impl Into<String>,
    remedy: impl Into<String>,
) -> Box<Diagnostic> {
    Box::new(Diagnostic {
        severity: Severity::Error,
        file: file.into(),
        is_assigned: false,
        line,
        column,
        node: None,
        port: None,
        found,
        expected: expected.into(),
        remedy: remedy.into(),
        means: None,
        used: None,
    })
}

/// Parses the JSON of a file that should be `what`.
fn json(name: &str, text: &str, what: &str) -> Result<Spanned, Box<Diagnostic>> {
    parse(text).map_err(|error| {
        let place = line_and_column(text, error.offset);
        if text.trim().is_empty() {
            let found = if text.is_empty() { "an empty file" } else { "only white space" };
            return fault(name, place, found.into(), "JSON", format!("write {what}, or name another file"));
        }
        let near: String = text[floor(text, error.offset)..].chars().take(20).collect();
        let remedy = if near.starts_with("NaN") || near.starts_with("Inf") || near.starts_with("-Inf") {
            "JSON has no NaN and no infinity: write a finite number"
        } else if near.is_empty() || error.fault.is_end() {
            "the text ends too early: close every bracket and quote"
        } else if error.fault.is_excess() {
            "no document needs that (lists and objects are a few levels deep): check what wrote it"
        } else {
            "correct the syntax there; JSON has no comments and no trailing commas"
        };
        fault(name, place, error.fault.to_string(), "JSON", remedy)
    })
}

/// Gives a value and everything in it other offsets.
fn relocate(value: &mut Spanned, to: &impl Fn(usize) -> usize) {
    value.offset = to(value.offset);
    match &mut value.json {
        Json::Array(items) => items.iter_mut().for_each(|item| relocate(item, to)),
        Json::Object(entries) => {
            for entry in entries {
                entry.offset = to(entry.offset);
                relocate(&mut entry.value, to);
            }
        }
        _ => {}
    }
}

/// Returns the nearest character boundary at or before a byte offset.
fn floor(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn canonical_text_ignores_order_and_ui() {
        let a = Document::parse("a", r##"{"b": 1, "a": {"y": [1, 2], "x": "#fff"}, "ui": {"q": 1}}"##).expect("valid");
        let b = Document::parse("b", r##"{"a": {"x": "#fff", "y": [1.0, 2]}, "b": 1, "notes": "n"}"##).expect("valid");
        assert_eq!(a.canonical(), b.canonical());
    }
}

//! Paths into a JSON text, and minimal edits of the text: everything an operation does not name stays byte for byte.

use jsonc_parser::ast::{Array, Object, ObjectProp, Value};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use std::fmt;

/// Step from a value to one inside it.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Step {
    /// Entry of an object.
    Key(String),
    /// Element of a list.
    Index(usize),
}

impl From<&str> for Step {
    fn from(key: &str) -> Self {
        Self::Key(key.into())
    }
}

impl From<&String> for Step {
    fn from(key: &String) -> Self {
        Self::Key(key.clone())
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// Path of a value, from the top of the document.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Path(pub Vec<Step>);

impl Path {
    /// Returns the path of a node.
    pub fn node(name: &str) -> Self {
        Self::default().to("nodes").to(name)
    }

    /// Returns the path one step below.
    #[must_use]
    pub fn to(&self, step: impl Into<Step>) -> Self {
        let mut steps = self.0.clone();
        steps.push(step.into());
        Self(steps)
    }

    /// Returns the path several steps below.
    #[must_use]
    pub fn join(&self, steps: &[Step]) -> Self {
        Self(self.0.iter().chain(steps).cloned().collect())
    }

    /// Returns the value at this path in a parsed document.
    pub fn find<'v>(&self, value: &'v serde_json::Value) -> Option<&'v serde_json::Value> {
        self.0.iter().try_fold(value, |value, step| match step {
            Step::Key(key) => value.get(key),
            Step::Index(index) => value.get(index),
        })
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if index == 0 => write!(f, "{key}")?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(at) => write!(f, "[{at}]")?,
            }
        }
        Ok(())
    }
}

/// Operation on a document. Values are JSON texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Op {
    /// Replaces a value, or adds it as the last entry of an object or the last element of a list. Missing objects on
    /// the path are created.
    Set(Path, String),
    /// Inserts a value into a list, before the element at this index.
    Insert(Path, String),
    /// Removes an entry or element.
    Remove(Path),
    /// Renames an object's entry.
    Rename(Path, String),
}

impl Op {
    /// Returns the path that the operation applies to.
    pub fn path(&self) -> &Path {
        match self {
            Self::Set(path, _) | Self::Insert(path, _) | Self::Remove(path) | Self::Rename(path, _) => path,
        }
    }
}

/// A piece of text replaced by another; the unit of undo and redo.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Splice {
    /// Byte offset.
    pub at: usize,
    /// Text before.
    pub removed: String,
    /// Text after.
    pub inserted: String,
}

impl Splice {
    /// Applies the replacement.
    pub fn redo(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.removed.len(), &self.inserted);
    }

    /// Reverts the replacement.
    pub fn undo(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.inserted.len(), &self.removed);
    }

    /// Returns the memory used, in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.removed.len() + self.inserted.len()
    }

    /// Returns the splice between two texts: the span in which they differ.
    pub fn between(old: &str, new: &str) -> Self {
        let (a, b) = (old.as_bytes(), new.as_bytes());
        let mut start = a.iter().zip(b).take_while(|(a, b)| a == b).count();
        while !(old.is_char_boundary(start) && new.is_char_boundary(start)) {
            start -= 1;
        }
        let rest = a.len().min(b.len()) - start;
        let mut end = a.iter().rev().zip(b.iter().rev()).take(rest).take_while(|(a, b)| a == b).count();
        while !(old.is_char_boundary(old.len() - end) && new.is_char_boundary(new.len() - end)) {
            end -= 1;
        }
        let (removed, inserted) = (&old[start..old.len() - end], &new[start..new.len() - end]);
        Self { at: start, removed: removed.into(), inserted: inserted.into() }
    }
}

/// Reason that an edit cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Misplaced {
    /// The text is not JSON.
    #[error("the document is not JSON: {0}")]
    NoJson(#[from] jsonc_parser::errors::ParseError),
    /// The text is empty.
    #[error("the document is empty")]
    Empty,
    /// The text has no such place.
    #[error("there is no {0}")]
    Missing(Path),
}

/// Parser options for strict JSON.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// Returns a string as JSON text.
pub fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Returns the splice of a text that performs an operation.
///
/// # Errors
/// Fails if the text is not JSON or has no such place.
pub fn splice(text: &str, op: &Op) -> Result<Splice, Misplaced> {
    let mut splice = in_lines(text, op)?;
    // Keep the line ends of the document.
    if text.contains("\r\n") && splice.inserted.contains('\n') {
        splice.inserted = splice.inserted.replace("\r\n", "\n").replace('\n', "\r\n");
    }
    Ok(splice)
}

/// Returns line and column of a value, counted from 1; if it does not exist, of its nearest existing ancestor.
pub fn place(text: &str, path: &Path) -> Option<[usize; 2]> {
    let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT).ok()?;
    let root = parsed.value?;
    let at = (0..=path.0.len()).rev().find_map(|depth| descend(&root, &path.0[..depth]))?.start();
    let before = &text[..at];
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    Some([before.matches('\n').count() + 1, before[line..].chars().count() + 1])
}

/// Returns the text of a value, as it is written.
pub fn written<'t>(text: &'t str, path: &Path) -> Option<&'t str> {
    let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT).ok()?;
    let root = parsed.value?;
    descend(&root, &path.0).and_then(|value| text.get(value.start()..value.end()))
}

fn in_lines(text: &str, op: &Op) -> Result<Splice, Misplaced> {
    let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT)?;
    let root = parsed.value.ok_or(Misplaced::Empty)?;
    let (Op::Set(path, _) | Op::Insert(path, _) | Op::Remove(path) | Op::Rename(path, _)) = op;
    let missing = || Misplaced::Missing(path.clone());
    match op {
        Op::Set(_, value) => set(text, &root, &path.0, value).ok_or_else(missing),
        Op::Insert(_, value) => {
            let (Some(Step::Index(index)), steps) = (path.0.last(), &path.0[..path.0.len().saturating_sub(1)]) else {
                return Err(missing());
            };
            match descend(&root, steps) {
                Some(Value::Array(list)) if *index < list.elements.len() => {
                    let next = &list.elements[*index];
                    let gap = gap_before(text, next.start(), list.range.start);
                    Ok(replaced(text, next.start(), next.start(), &format!("{value},{gap}")))
                }
                Some(Value::Array(list)) if *index == list.elements.len() => Ok(appended(text, list, value)),
                _ => Err(missing()),
            }
        }
        Op::Remove(_) => {
            let (last, steps) = path.0.split_last().ok_or_else(missing)?;
            let parent = descend(&root, steps).ok_or_else(missing)?;
            let (ranges, index, inner): (Vec<(usize, usize)>, _, _) = match (parent, last) {
                (Value::Object(object), Step::Key(key)) => (
                    object.properties.iter().map(|entry| (entry.range.start, entry.range.end)).collect(),
                    object.properties.iter().position(|entry| entry.name.as_str() == key),
                    (object.range.start + 1, object.range.end - 1),
                ),
                (Value::Array(list), Step::Index(index)) => (
                    list.elements.iter().map(|value| (value.start(), value.end())).collect(),
                    Some(*index),
                    (list.range.start + 1, list.range.end - 1),
                ),
                _ => return Err(missing()),
            };
            let index = index.filter(|index| *index < ranges.len()).ok_or_else(missing)?;
            let (start, end) = if ranges.len() == 1 {
                inner
            } else if index + 1 == ranges.len() {
                (ranges[index - 1].1, ranges[index].1)
            } else {
                (ranges[index].0, ranges[index + 1].0)
            };
            Ok(replaced(text, start, end, ""))
        }
        Op::Rename(_, key) => {
            let (Some(Step::Key(old)), steps) = (path.0.last(), &path.0[..path.0.len().saturating_sub(1)]) else {
                return Err(missing());
            };
            let Some(Value::Object(object)) = descend(&root, steps) else { return Err(missing()) };
            let entry = entry(object, old).ok_or_else(missing)?;
            let range = entry.name.range();
            Ok(replaced(text, range.start, range.end, &quoted(key)))
        }
    }
}

fn replaced(text: &str, start: usize, end: usize, new: &str) -> Splice {
    Splice { at: start, removed: text[start..end].into(), inserted: new.into() }
}

fn entry<'o, 'a>(object: &'o Object<'a>, key: &str) -> Option<&'o ObjectProp<'a>> {
    object.properties.iter().find(|entry| entry.name.as_str() == key)
}

fn descend<'v, 'a>(root: &'v Value<'a>, steps: &[Step]) -> Option<&'v Value<'a>> {
    steps.iter().try_fold(root, |value, step| match (value, step) {
        (Value::Object(object), Step::Key(key)) => entry(object, key).map(|entry| &entry.value),
        (Value::Array(list), Step::Index(index)) => list.elements.get(*index),
        _ => None,
    })
}

fn set(text: &str, root: &Value<'_>, steps: &[Step], value: &str) -> Option<Splice> {
    // Find the deepest existing ancestor.
    let depth = (0..=steps.len()).rev().find(|&depth| descend(root, &steps[..depth]).is_some())?;
    let found = descend(root, &steps[..depth])?;
    if depth == steps.len() {
        return Some(replaced(text, found.start(), found.end(), value));
    }
    let mut value = value.to_string();
    for step in steps[depth + 1..].iter().rev() {
        value = match step {
            Step::Key(key) => format!("{{ {}: {value} }}", quoted(key)),
            Step::Index(0) => format!("[{value}]"),
            Step::Index(_) => return None,
        };
    }
    match (found, &steps[depth]) {
        (Value::Object(object), Step::Key(key)) => {
            Some(added(text, object, &format!("{}: {value}", quoted(key)), depth))
        }
        (Value::Array(list), Step::Index(index)) if *index == list.elements.len() => Some(appended(text, list, &value)),
        _ => None,
    }
}

/// Appends an entry to an object, separated like its other entries.
fn added(text: &str, object: &Object<'_>, entry: &str, depth: usize) -> Splice {
    match object.properties.last() {
        Some(last) => {
            let gap = gap_before(text, last.range.start, object.range.start);
            replaced(text, last.range.end, last.range.end, &format!(",{gap}{entry}"))
        }
        // Objects near the top of the document, such as `nodes`, have one line per entry.
        None if depth <= 1 => {
            let (outer, inner) = ("  ".repeat(depth), "  ".repeat(depth + 1));
            let inside = format!("\n{inner}{entry}\n{outer}");
            replaced(text, object.range.start + 1, object.range.end - 1, &inside)
        }
        None => replaced(text, object.range.start + 1, object.range.end - 1, &format!(" {entry} ")),
    }
}

fn appended(text: &str, list: &Array<'_>, value: &str) -> Splice {
    match list.elements.last() {
        Some(last) => {
            let gap = gap_before(text, last.start(), list.range.start);
            replaced(text, last.end(), last.end(), &format!(",{gap}{value}"))
        }
        None => replaced(text, list.range.start + 1, list.range.end - 1, value),
    }
}

/// Returns the separator between a value and the one before: a line break with indentation, or a space.
fn gap_before(text: &str, start: usize, from: usize) -> String {
    let between = &text[from + 1..start];
    let line = between.rfind('\n').filter(|at| between[*at..].trim().is_empty());
    match line {
        Some(at) => between[at..].into(),
        // Several values on a line: the new one goes on the same line.
        None => " ".into(),
    }
}

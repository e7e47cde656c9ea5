//! Diagnostics of validation: faults and warnings, each with its place, what was found, what was expected, and a
//! remedy.

use crate::AccessViolation;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// Place in a document.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DocumentPlace {
    /// Name of the document, or of one that it includes.
    pub document: Arc<str>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl fmt::Display for DocumentPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.document, self.line, self.column)
    }
}

/// Whether a diagnostic stops the document from being evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The document is valid, but something is probably not intended.
    Warning,
    /// The document is invalid.
    Error,
}

/// One fault or warning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Name of the document, or the assignment from outside of it that contains the fault.
    pub file: String,
    /// Whether `file` is an assignment.
    pub is_assigned: bool,
    /// Line, from 1; 0 if the place is unknown.
    pub line: usize,
    /// Column in characters, from 1; 0 if the place is unknown.
    pub column: usize,
    /// Node that contains the fault, if any.
    pub node: Option<String>,
    /// Port or knob that contains the fault, if any.
    pub port: Option<String>,
    /// Description of the value or situation that was found.
    pub found: String,
    /// Description of what is legal.
    pub expected: String,
    /// Remedy: an instruction to the user.
    pub remedy: String,
    /// Means of the remedy that a front end can offer, if any.
    pub means: Option<Means>,
    /// The use of a group that has the node, and where it is, if the node is within one.
    pub used: Option<String>,
}

/// Means of a remedy, which a front end can offer by an option or a button.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Means {
    /// Allowing the document these files.
    Allow(Vec<AccessViolation>),
    /// Changing a key of the document that no assignment can change.
    EditDocument {
        /// The key.
        key: String,
    },
    /// Choosing one output of several.
    ChooseOutput,
    /// Making a document of a picture.
    Decompose {
        /// Path of the picture.
        picture: PathBuf,
    },
    /// Leading a node to an output. Who is still building a document will do so anyway.
    LeadToOutput,
}

impl Diagnostic {
    /// Returns the diagnostic as a JSON object with one key per field.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({
            "severity": self.severity.to_string(),
            "file": self.file,
            "line": self.line,
            "column": self.column,
            "node": self.node,
            "port": self.port,
            "found": self.found,
            "expected": self.expected,
            "remedy": self.remedy,
            "used": self.used,
        })
    }

    /// Its words without the first, which says how severe it is.
    pub fn statement(&self) -> Statement<'_> {
        Statement(self)
    }
}

/// A [`Diagnostic`] without the word for its severity.
#[derive(Clone, Copy, Debug)]
pub struct Statement<'d>(&'d Diagnostic);

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Error => "error",
            Self::Warning => "warning",
        })
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.severity, self.statement())
    }
}

impl fmt::Display for Statement<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Diagnostic { file, line, column, node, port, found, expected, remedy, used, .. } = self.0;
        f.write_str(file)?;
        if *line > 0 {
            write!(f, ":{line}:{column}")?;
        }
        match (node, port) {
            (Some(node), Some(port)) => write!(f, ": node \"{node}\", {port}")?,
            (Some(node), None) => write!(f, ": node \"{node}\"")?,
            (None, Some(port)) => write!(f, ": {port}")?,
            (None, None) => {}
        }
        write!(f, ": found {found}")?;
        if let Some(used) = used {
            write!(f, ", in {used}")?;
        }
        write!(f, "; expected {expected}")?;
        if !remedy.is_empty() {
            write!(f, "\n  remedy: {remedy}")?;
        }
        Ok(())
    }
}

/// Returns the candidate most similar to `name`, if it is similar enough that `name` may be a typing error.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    candidates
        .into_iter()
        .map(|candidate| (candidate, candidate.to_lowercase()))
        .filter_map(|(candidate, known)| {
            let likeness = strsim::jaro_winkler(&lower, &known);
            Some((slips(&lower, &known)?, likeness, candidate)).filter(|_| likeness > 0.75)
        })
        // Fewest slips first: letters in the right order alone make "sead" more like "spread" than like "seed".
        .min_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)))
        .map(|(.., candidate)| candidate)
}

/// Returns the number of edits between two names; `None` if they are too many for a slip: more than one in three letters
/// (and more than one). That one, of three letters or more, is the beginning of the other counts as one.
fn slips(name: &str, known: &str) -> Option<usize> {
    let (short, long) = if name.len() < known.len() { (name, known) } else { (known, name) };
    if short.chars().count() >= 3 && long.starts_with(short) {
        return Some(usize::from(short != long));
    }
    let slips = strsim::osa_distance(name, known);
    (slips <= (long.chars().count() / 3).max(1)).then_some(slips)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognized_and_strangers_are_not() {
        assert_eq!(nearest("wieght", ["a", "b", "weight"]), Some("weight"));
        assert_eq!(nearest("gerstnersea", ["GerstnerSea", "Render"]), Some("GerstnerSea"));
        assert_eq!(nearest("zzz", ["weight", "color"]), None);
        assert_eq!(nearest("of", ["view", "other", "soft"]), None);
        assert_eq!(nearest("sinn", ["min", "sin", "sign"]), Some("sin"));
        assert_eq!(nearest("rot", ["x", "rotate"]), Some("rotate"));
        assert_eq!(nearest("sead", ["spread", "seed"]), Some("seed"));
    }
}

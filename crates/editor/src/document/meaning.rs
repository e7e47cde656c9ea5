//! The interpretation of a document's text: graph, diagnostics, and sheet.

use super::group::Library;
use super::sheet::Sheet;
use std::path::Path;
use std::sync::Arc;
use trochoid::{Access, CheckedGraph, Diagnostic, LoadError, Severity, missing_files, parse_within};

/// Interpretation of a document's text.
#[derive(Clone, Debug, Default)]
pub struct Meaning {
    /// The graph, if the document is valid.
    pub graph: Option<Arc<CheckedGraph>>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Content for the canvas, also of invalid documents; if the text is not JSON, the previous one.
    pub sheet: Arc<Sheet>,
    /// Whether the text is JSON; if not, only the text panel can edit it.
    pub readable: bool,
}

impl Meaning {
    /// Interprets a text. `name`, `folder` and `access` are as in [`trochoid::parse_within`].
    pub fn of(name: &str, text: &str, folder: &Path, access: &Access) -> Self {
        let (graph, mut diagnostics) = match parse_within(name, text, folder, &[], access.clone()) {
            Ok(loaded) => (Some(loaded.graph), loaded.warnings),
            Err(LoadError::Invalid(diagnostics)) => (None, diagnostics),
            Err(error @ LoadError::Io(_)) => (None, vec![trouble(name, &error.to_string())]),
        };
        if let Some(graph) = &graph {
            diagnostics.extend(missing_files(graph));
        }
        // A text too large for the graph is not parsed for the sheet either.
        let value = if text.len() <= 64 << 20 { serde_json::from_str(text).ok() } else { None };
        let readable = value.is_some();
        let value = value.unwrap_or_default();
        let library = Arc::new(Library::read(&value, Some((folder, access))));
        let mut sheet = Sheet::with_groups(value, graph.as_ref(), library, None);
        sheet.text = text.into();
        let sheet = Arc::new(sheet);
        Self { graph: graph.map(Arc::new), diagnostics, sheet, readable }
    }

    /// Returns the errors.
    pub fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

fn trouble(name: &str, found: &str) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        file: name.into(),
        is_assigned: false,
        line: 0,
        column: 0,
        node: None,
        port: None,
        found: found.into(),
        expected: "a document".into(),
        remedy: String::new(),
        means: None,
        used: None,
    }
}

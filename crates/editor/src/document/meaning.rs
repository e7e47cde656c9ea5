//! What a document's text means.

use super::sheet::Sheet;
use std::path::Path;
use std::sync::Arc;
use trochoid::{Access, CheckedGraph, Diagnostic, LoadError, Severity, missing_files, parse};

/// What a text means.
#[derive(Clone, Debug, Default)]
pub struct Meaning {
    /// The graph, where the document is valid.
    pub graph: Option<Arc<CheckedGraph>>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// What can be drawn, whether it is valid or not; of a text that is no JSON, what could be drawn before.
    pub sheet: Arc<Sheet>,
    /// Whether the text is JSON at all: if not, nothing but the text can be edited.
    pub readable: bool,
}

impl Meaning {
    /// Reads a text; `name` and `folder` as for [`trochoid::parse`], `access` is what it may reach.
    pub fn of(name: &str, text: &str, folder: &Path, access: &Access) -> Self {
        let (graph, mut diagnostics) = match parse(name, text, folder, &[]) {
            Ok(loaded) => (Some(loaded.graph.with_access(access.clone())), loaded.warnings),
            Err(LoadError::Invalid(diagnostics)) => (None, diagnostics),
            Err(error @ LoadError::Io(_)) => (None, vec![trouble(name, &error.to_string())]),
        };
        if let Some(graph) = &graph {
            diagnostics.extend(missing_files(graph));
        }
        // What is too deep or too large for the graph is too deep for anything else.
        let value = if text.len() <= 64 << 20 { serde_json::from_str(text).ok() } else { None };
        let readable = value.is_some();
        let mut sheet = Sheet::new(value.unwrap_or_default(), graph.as_ref());
        sheet.text = text.into();
        let sheet = Arc::new(sheet);
        Self { graph: graph.map(Arc::new), diagnostics, sheet, readable }
    }

    /// The errors.
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
    }
}

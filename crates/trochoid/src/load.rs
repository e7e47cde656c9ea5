use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use trochoid_graph::{CheckedGraph, Diagnostic, Document, MAX_BYTES, Registry, Severity, check};

/// All node types of this build.
pub fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| Registry::new(trochoid_nodes::all().iter().copied()))
}

/// A checked graph, and what validation warned of.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The graph.
    pub graph: CheckedGraph,
    /// Warnings, in the order of the text.
    pub warnings: Vec<Diagnostic>,
}

/// Why a document cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// The document is invalid: every fault, and the warnings beside them.
    #[error("{}", list(.0))]
    Invalid(Vec<Diagnostic>),
}

fn list(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n")
}

/// Loads and checks a document. Each of `set` is an assignment `NODE.KNOB=VALUE`, applied in order.
///
/// # Errors
/// The file cannot be read, or the document is invalid.
pub fn load(path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
    let io = |reason: String| LoadError::Io { path: path.into(), reason };
    let size = std::fs::metadata(path).map_err(|error| io(format!("cannot be read: {error}")))?;
    if size.is_dir() {
        return Err(io("is a folder; name a document".into()));
    }
    let name = path.display().to_string();
    if size.len() > MAX_BYTES as u64 {
        let found = format!("a document of {} bytes", size.len());
        return Err(LoadError::Invalid(vec![Diagnostic {
            severity: Severity::Error,
            file: name,
            line: 0,
            column: 0,
            node: None,
            port: None,
            found,
            expected: format!("at most {MAX_BYTES} bytes"),
            remedy: "split the scene into several documents".into(),
        }]));
    }
    let bytes = std::fs::read(path).map_err(|error| io(format!("cannot be read: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        io(format!("byte {} is no UTF-8; save the document as UTF-8", error.utf8_error().valid_up_to()))
    })?;
    let folder = path.parent().unwrap_or(Path::new("."));
    parse(&name, &text, folder, set)
}

/// Checks a document's text; `name` stands for it in diagnostics, paths in it are relative to `folder`.
///
/// # Errors
/// The document is invalid.
pub fn parse(name: &str, text: &str, folder: &Path, set: &[String]) -> Result<Loaded, LoadError> {
    let invalid = |diagnostic: Box<Diagnostic>| LoadError::Invalid(vec![*diagnostic]);
    let mut document = Document::parse(name, text).map_err(invalid)?;
    let faults: Vec<Diagnostic> =
        set.iter().filter_map(|assignment| document.set(assignment).err()).map(|fault| *fault).collect();
    let (graph, diagnostics) = check(&document, registry(), folder);
    match graph {
        Some(graph) if faults.is_empty() => Ok(Loaded { graph, warnings: diagnostics }),
        _ => Err(LoadError::Invalid(faults.into_iter().chain(diagnostics).collect())),
    }
}

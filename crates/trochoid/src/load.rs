//! Loading and checking of documents.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use trochoid_graph::{
    Access, CheckedGraph, Diagnostic, Document, MAX_BYTES, MAX_FILE_BYTES, Means, NodeId, PaletteColor, Registry,
    Severity, check, escape_remedy,
};
use trochoid_image::WorkingSpace;

/// Returns the registry of all node types in this build.
pub fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| Registry::new(trochoid_nodes::all()).with_formulas(&trochoid_nodes::LinkFormulas))
}

/// Checked graph with the warnings of its validation.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Checked graph.
    pub graph: CheckedGraph,
    /// Warnings, in document order.
    pub warnings: Vec<Diagnostic>,
}

/// Reason that a document cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The document or a palette file cannot be read.
    #[error(transparent)]
    Io(trochoid_io::Error),
    /// The document is invalid: every fault, and the warnings beside them.
    #[error("{}", list(.0))]
    Invalid(Vec<Diagnostic>),
}

pub(crate) fn list(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n")
}

/// Loads and checks a document. Each of `set` is an assignment, applied in order: `NODE.KNOB=VALUE`, or another path as
/// [`Document::set`] takes them; or `palette=FILE`, whose colors replace those of the same names
/// ([`Document::replace_palette`]), `FILE` being relative to the current folder; or `view=NODE.PORT`, which adds an output
/// that shows a node or what feeds a port ([`Document::view`]).
///
/// The document may read and write files under its own folder and, if that lies under the current folder, under the
/// current folder ([`Access::usual`](crate::Access::usual)), and files that `set` names; evaluation refuses other
/// files. [`CheckedGraph::with_access`] changes these rights.
///
/// # Errors
/// The file cannot be read, or the document is invalid.
pub fn load(path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
    load_within(path, set, Access::usual(folder_of(path)))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}

/// Does the same with other rights to read and write files.
///
/// # Errors
/// As [`load`].
pub fn load_within(path: &Path, set: &[String], access: Access) -> Result<Loaded, LoadError> {
    let name = path.display().to_string();
    let text = document_of(path)?;
    parse_within(&name, &text, folder_of(path), set, access)
}

/// Reads a file that should be `what`, with the remedy if it is too long.
pub(crate) fn text_of(path: &Path, most: usize, what: &str, shorter: &str) -> Result<String, LoadError> {
    let name = || path.display().to_string();
    trochoid_io::read_text(path, most as u64).map_err(|error| match error {
        trochoid_io::Error::TooLong { found, limit, .. } => {
            let (found, expected) = (format!("{what} of {found} bytes"), format!("at most {limit} bytes"));
            invalid(name(), (0, 0), found, expected, shorter)
        }
        trochoid_io::Error::NotText { line, column, byte, .. } => {
            let found = format!("the byte {byte:#04x}, which is not UTF-8");
            invalid(name(), (line, column), found, format!("{what} in UTF-8"), "save it as UTF-8")
        }
        error => LoadError::Io(error),
    })
}

/// Returns whether a file is a picture, as far as this build knows pictures.
fn is_picture(path: &Path) -> bool {
    #[cfg(feature = "io")]
    let is_picture = trochoid_io::kind(path).is_ok();
    #[cfg(not(feature = "io"))]
    let is_picture = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    is_picture
}

/// Reads a document.
pub(crate) fn document_of(path: &Path) -> Result<String, LoadError> {
    if is_picture(path) {
        let remedy = "`trochoid decompose` makes a document of a picture";
        let mut fault = fault(path.display().to_string(), (0, 0), "a picture".into(), "a document".into(), remedy);
        fault.means = Some(Means::Decompose { picture: path.into() });
        return Err(LoadError::Invalid(vec![fault]));
    }
    text_of(path, MAX_BYTES, "a document", "split the scene into several documents")
}

/// Reads a palette file.
fn palette_of(path: &Path) -> Result<String, LoadError> {
    if is_picture(path) {
        let remedy = "`trochoid palette` reads a palette off it";
        return Err(invalid(path.display().to_string(), (0, 0), "a picture".into(), "a palette".into(), remedy));
    }
    text_of(path, MAX_FILE_BYTES, "a palette", "name a file that has the colors and little else")
}

fn invalid(file: String, place: (usize, usize), found: String, expected: String, remedy: &str) -> LoadError {
    LoadError::Invalid(vec![fault(file, place, found, expected, remedy)])
}

fn fault(file: String, place: (usize, usize), found: String, expected: String, remedy: &str) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        file,
        is_assigned: false,
        line: place.0,
        column: place.1,
        node: None,
        port: None,
        found,
        expected,
        remedy: remedy.into(),
        means: None,
        used: None,
    }
}

/// Checks the text of a document. `name` is its name in diagnostics; its paths are relative to `folder`. The files that
/// it may access are those of [`load`].
///
/// # Errors
/// The document is invalid.
pub fn parse(name: &str, text: &str, folder: &Path, set: &[String]) -> Result<Loaded, LoadError> {
    parse_within(name, text, folder, set, Access::usual(folder))
}

/// Does the same with other rights to read and write files.
///
/// # Errors
/// As [`parse`].
pub fn parse_within(
    name: &str,
    text: &str,
    folder: &Path,
    set: &[String],
    access: Access,
) -> Result<Loaded, LoadError> {
    parse_as(name, text, folder, set, access, registry(), None)?.sound()
}

/// A document with what was found in it.
pub(crate) struct Parsed {
    /// The graph, without the assignments that have faults; `None` if the document is invalid.
    pub(crate) graph: Option<CheckedGraph>,
    /// Faults of assignments, and of the document if there is no graph.
    pub(crate) faults: Vec<Diagnostic>,
    /// Warnings.
    pub(crate) warnings: Vec<Diagnostic>,
}

impl Parsed {
    /// Returns the graph if nothing is wrong.
    pub(crate) fn sound(self) -> Result<Loaded, LoadError> {
        match self.graph {
            Some(graph) if self.faults.is_empty() => Ok(Loaded { graph, warnings: self.warnings }),
            _ => Err(LoadError::Invalid(self.faults.into_iter().chain(self.warnings).collect())),
        }
    }
}

/// Does the same with other node types, and with a size of pictures for documents that state none.
pub(crate) fn parse_as(
    name: &str,
    text: &str,
    folder: &Path,
    set: &[String],
    access: Access,
    registry: &Registry,
    size: Option<[u32; 2]>,
) -> Result<Parsed, LoadError> {
    let invalid = |diagnostic: Box<Diagnostic>| LoadError::Invalid(vec![*diagnostic]);
    let mut document = Document::parse(name, text).map_err(invalid)?;
    if let Some(size) = size {
        document.assume_size(size);
    }
    if let Some(file) = document.palette_file() {
        let path = folder.join(file);
        access.check(&path).map_err(|outside| LoadError::Invalid(vec![document.refused_palette(outside)]))?;
        let text = palette_of(&path).map_err(|error| match error {
            LoadError::Io(_) if !path.exists() => {
                LoadError::Invalid(vec![document.unread_palette(format!("no file {}", path.display()))])
            }
            LoadError::Io(error) => LoadError::Invalid(vec![document.unread_palette(error.to_string())]),
            invalid => invalid,
        })?;
        document.read_palette(&path, &text).map_err(invalid)?;
    }
    while let Some(file) = document.next_include() {
        let path = folder.join(file);
        access.check(&path).map_err(|outside| LoadError::Invalid(vec![document.refused_include(outside)]))?;
        let text = text_of(&path, MAX_FILE_BYTES, "a document with groups", "split it into several documents");
        let text = text.map_err(|error| match error {
            LoadError::Io(_) if !path.exists() => {
                LoadError::Invalid(vec![document.unread_include(format!("no file {}", path.display()))])
            }
            LoadError::Io(error) => LoadError::Invalid(vec![document.unread_include(error.to_string())]),
            invalid => invalid,
        })?;
        document.include(&path, &text).map_err(invalid)?;
    }
    let mut faults: Vec<Diagnostic> = Vec::new();
    for assignment in set {
        let set = match assignment.split_once('=') {
            Some(("palette", file)) => document.replace_palette(Path::new(file), &palette_of(Path::new(file))?),
            Some(("view", reference)) => {
                document.view(reference);
                Ok(())
            }
            _ => document.set(assignment),
        };
        faults.extend(set.err().map(|fault| *fault));
    }
    let (graph, diagnostics) = check(&document, registry, folder);
    Ok(match graph {
        Some(graph) => Parsed { graph: Some(graph.with_access(access)), faults, warnings: diagnostics },
        // All in the order of the document, as they were found.
        None => Parsed { graph: None, faults: faults.into_iter().chain(diagnostics).collect(), warnings: Vec::new() },
    })
}

/// Reads the colors of a palette file, in its order, as a document of a working space would: JSON, another document with
/// a palette, or a palette of GIMP.
///
/// # Errors
/// `access` excludes the file, it cannot be read, or it is no palette.
pub fn load_palette(path: &Path, space: WorkingSpace, access: &Access) -> Result<Vec<PaletteColor>, LoadError> {
    let invalid = |diagnostic: Diagnostic| LoadError::Invalid(vec![diagnostic]);
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 1, "height": 1 }}, "working_space": "{}", "palette": "",
            "nodes": {{ "nothing": {{ "type": "Constant", "color": "#000" }} }},
            "outputs": {{ "nothing": {{ "color": "nothing" }} }} }}"##,
        space.name()
    );
    let mut document = Document::parse(&path.display().to_string(), &text).map_err(|fault| invalid(*fault))?;
    access.check(path).map_err(|outside| invalid(document.refused_palette(outside)))?;
    document.read_palette(path, &palette_of(path)?).map_err(|fault| invalid(*fault))?;
    let (graph, diagnostics) = check(&document, registry(), Path::new("."));
    Ok(graph.ok_or(LoadError::Invalid(diagnostics))?.palette().to_vec())
}

/// Returns warnings about input files that do not exist at one of the document's first 10,000 frames. Opens no files.
pub fn missing_files(graph: &CheckedGraph) -> Vec<Diagnostic> {
    let (first, last) = graph.frames();
    let roots = || graph.outputs().iter().map(|output| output.node);
    let connected = graph.upstream(roots());
    let mut exists: HashMap<PathBuf, bool> = HashMap::new();
    // By node: the first frame without a file, that file, and the number of such frames.
    let mut missing: BTreeMap<usize, (i64, PathBuf, usize)> = BTreeMap::new();
    for frame in (first..=last).take(FRAMES_CHECKED) {
        let context = graph.frame_context(frame, u64::MAX);
        let mut reached = None;
        for (index, _) in graph.nodes().iter().enumerate().filter(|(_, node)| !node.disabled) {
            let mut files = graph.files_of(NodeId(index), &context).into_iter();
            let Some(path) = files.find(|path| !*exists.entry(path.clone()).or_insert_with(|| path.exists())) else {
                continue;
            };
            // A file may be missing if its node is connected but not chosen at that frame.
            let reached = reached.get_or_insert_with(|| graph.dependencies(roots(), frame));
            if !connected[index] || reached[index] {
                missing.entry(index).or_insert((frame, path, 0)).2 += 1;
            }
        }
    }
    let fault = |(index, (frame, path, count)): (usize, (i64, PathBuf, usize))| {
        let seen = if last - first >= FRAMES_CHECKED as i64 { " of the first 10000, which are checked" } else { "" };
        let more = match count - 1 {
            0 => String::new(),
            1 => format!(", nor at 1 more frame{seen}"),
            more => format!(", nor at {more} more frames{seen}"),
        };
        let node = &graph.nodes()[index];
        let item = node.file_item();
        let place = graph.place_of(NodeId(index), item);
        let settled = graph.settle(NodeId(index), frame);
        let context = graph.frame_context(frame, u64::MAX);
        let remedy = item.and_then(|item| escape_remedy(&context, settled.text(item)));
        Diagnostic {
            severity: Severity::Warning,
            file: place.document.to_string(),
            is_assigned: false,
            line: place.line,
            column: place.column,
            node: Some(node.name.clone()),
            port: item.map(String::from),
            found: format!("no file {} at frame {frame}{more}", path.display()),
            expected: "a file to read".into(),
            remedy: remedy.unwrap_or_else(|| {
                "correct the path, which is relative to the document, or make the file before rendering".into()
            }),
            means: None,
            used: None,
        }
    };
    missing.into_iter().map(fault).collect()
}

/// Maximum number of frames whose files [`missing_files`] looks for.
const FRAMES_CHECKED: usize = 10_000;

//! Shared code of fuzz targets: temporary files, evaluation of documents at a small size, mutation of JSON.

mod json;

pub use json::mutate_json;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use trochoid::{Buffers, Cache, CheckedGraph, EvalError, Format, Monitor, Plan, Settings};

/// Time limit of one evaluation. Slow work that stops when cancelled is not a finding.
const PATIENCE: Duration = Duration::from_millis(500);
/// Memory limit of one evaluation, in bytes.
const MEMORY: u64 = 512 << 20;

/// Returns a folder of this process, in memory if the system offers that.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let memory = Path::new("/dev/shm");
    let make = || if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    FOLDER.get_or_init(|| make().expect("a folder for files")).path()
}

/// Writes bytes to a file with this name.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("the folder takes files");
    path
}

/// Monitor that cancels after a while.
struct Patience(Instant);

impl Monitor for Patience {
    fn cancelled(&self) -> bool {
        self.0.elapsed() > PATIENCE
    }
}

/// Evaluates all outputs of a graph at 8 × 8 pixels; no color may leave the palette or be NaN.
pub fn evaluate(graph: &CheckedGraph) {
    let format = Format::new(8, 8, graph.format().samples()).expect("a small format");
    let graph = graph.clone().with_format(format);
    let mut settings = Settings::default();
    (settings.threads, settings.memory_limit) = (1, MEMORY);
    let Ok(plan) = Plan::new(&graph, &[], graph.frames().0, &[], &settings) else { return };
    match plan.evaluate(&Buffers::new(), &mut Cache::with_limit(0), &Patience(Instant::now())) {
        Ok(frame) => {
            for picture in frame.pictures.iter().filter(|picture| picture.guarantee.is_some()) {
                assert_eq!(picture.audit.hull_exits, 0, "the picture leaves its palette");
                assert_eq!(picture.audit.nan_count, 0, "a color is NaN");
            }
        }
        Err(EvalError::Cancelled) => {}
        Err(error) => assert!(error.to_string().len() > 10, "an error without a text"),
    }
}

/// Reads a picture file in every way: header, metadata, and pixels, by the library and by `Read` and `Texture`.
pub fn read(path: &Path) {
    let limits = trochoid::io::Limits { pixels: 1 << 22, bytes: 64 << 20 };
    let _ = trochoid::io::info(path, &limits).map_err(told);
    let _ = trochoid::io::read_metadata(path).map_err(told);
    let _ = trochoid::io::read(path, &trochoid::io::Selection::default(), &limits).map_err(told);
    let name = path.file_name().and_then(|name| name.to_str()).expect("a name of ours");
    let document = serde_json::json!({
        "trochoid": 1, "format": { "width": 8, "height": 8 },
        "nodes": {
            "x": { "type": "ScreenX" },
            "read": { "type": "Read", "file": name, "as": "color", "fit": "bilinear", "repair": true },
            "texture": { "type": "Texture", "file": name, "as": "color", "u": "x", "v": "x", "repair": true },
            "out": { "type": "Mix", "a": "read", "b": "texture", "weight": "x" },
        },
        "outputs": { "out": { "color": "out" } },
    });
    let loaded = trochoid::parse("a.json", &document.to_string(), folder(), &[]).expect("a valid document");
    evaluate(&loaded.graph);
}

/// Asserts that an error has a message.
fn told(error: trochoid::io::Error) {
    assert!(error.to_string().len() > 10, "an error without a text");
}

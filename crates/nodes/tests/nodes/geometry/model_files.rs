//! Tests of the sizes of files of surfaces.

use crate::testing::{graph, prepare};
use std::path::Path;
use trochoid_graph::{NodeError, Pool};

/// Prepares a surface of a file, within a limit of memory.
fn prepared(ty: &str, knobs: &str, folder: &Path, memory: u64) -> Result<(), NodeError> {
    let nodes = format!(
        r#""c": {{ "type": "Camera" }}, "s": {{ "type": "{ty}", {knobs} }},
        "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }}, "out": {{ "type": "Depth", "view": "v" }}"#
    );
    let graph = graph("field", &nodes, folder).unwrap();
    prepare(&graph, "s", &graph.frame_context(1, memory), None, &Pool::new()).map(drop)
}

#[test]
fn meshes_beyond_the_limit_are_not_taken() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples");
    let length = std::fs::metadata(samples.join("buoy.obj")).unwrap().len();
    let of = |memory: u64| prepared("Mesh", r#""file": "buoy.obj""#, &samples, memory);
    assert!(of(32 * length).is_ok());
    let error = of(32 * length - 1).unwrap_err().to_string();
    assert!(error.contains("buoy.obj") && error.contains("at most"), "{error}");
}

#[test]
fn models_beyond_the_limit_are_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str| {
        let knobs = format!(r#""model": "{name}""#);
        prepared("BezierModel", &knobs, folder.path(), 1 << 30).unwrap_err().to_string()
    };
    std::fs::File::create(folder.path().join("large.json")).unwrap().set_len((8 << 20) + 1).unwrap();
    let message = of("large.json");
    assert!(message.contains("large.json") && message.contains("at most 8388608"), "{message}");
    assert!(of("missing.json").contains("missing.json"));
    std::fs::create_dir(folder.path().join("folder.json")).unwrap();
    assert!(of("folder.json").contains("found a folder"), "{}", of("folder.json"));
}

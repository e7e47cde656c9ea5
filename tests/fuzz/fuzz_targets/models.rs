//! Any bytes as a model: OBJ, glTF, GLB or patches, by the first byte; accepted models are rendered.
#![no_main]

use libfuzzer_sys::fuzz_target;
use serde_json::json;

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let (name, node) = match kind % 4 {
        0 => ("a.obj", "Mesh"),
        1 => ("a.gltf", "Mesh"),
        2 => ("a.glb", "Mesh"),
        _ => ("a.json", "BezierModel"),
    };
    trochoid_fuzz::file(name, bytes);
    let file = if node == "Mesh" { "file" } else { "model" };
    let document = json!({
        "trochoid": 1, "format": { "width": 8, "height": 8 },
        "nodes": {
            "camera": { "type": "Camera", "position": [0, 2, 5], "target": [0, 0, 0] },
            "model": { "type": node, file: name },
            "view": { "type": "Render", "camera": "camera", "surfaces": ["model"] },
            "depth": { "type": "Depth", "view": "view" },
            "normal": { "type": "Normal", "view": "view" },
        },
        "outputs": { "depth": { "field": "depth" }, "normal": { "field": "normal" } },
    });
    let loaded = trochoid::parse("scene.json", &document.to_string(), trochoid_fuzz::folder(), &[]);
    trochoid_fuzz::evaluate(&loaded.expect("a valid document").graph);
});

//! Connections of the wrong kind, in every combination that has a remedy of its own.

use super::{Bad, nodes};

pub(super) fn table() -> Vec<Bad> {
    vec![
        nodes(
            "a sea for a camera, before what asks how far that is",
            r#""water": { "type": "GerstnerSea" }, "seen": { "type": "Render", "camera": "water", "surfaces": ["water"] },
               "claws": { "type": "Hooks", "view": "seen", "rows": [{ "from": [0, 0], "to": [1, 1] }] }"#,
            &[&["node \"seen\"", "camera"]],
        ),
        nodes(
            "a Field as a mask",
            r#""a": { "type": "Invert", "weight": "depth" }"#,
            &[&["bad.json:6:36: node \"a\", weight", "\"depth\", a Field", "expected a mask", "put a Clamp between"]],
        ),
        nodes(
            "a Field of 3 as a mask",
            r#""a": { "type": "Invert", "weight": "normal" }"#,
            &[&["a Field of 3 components", "take one component with a FieldMath", "\"a.x\"", "then Clamp it"]],
        ),
        nodes(
            "a Field as Weights",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": "depth" }"##,
            &[&["\"depth\", a Field", "expected a Weights", "put a Clamp between"]],
        ),
        nodes(
            "Weights as a mask",
            r#""a": { "type": "Invert", "weight": "three" }"#,
            &[&["\"three\", a Weights(3)", "Blend with 3 colors"]],
        ),
        nodes(
            "a Color as a mask",
            r#""a": { "type": "Invert", "weight": "x" }"#,
            &[&["\"x\", a Color", "colors never become weights", "\"as\": \"field\""]],
        ),
        nodes(
            "a Color as a Field",
            r#""a": { "type": "Clamp", "field": "x" }"#,
            &[&["\"x\", a Color", "expected a Field", "colors never become weights"]],
        ),
        nodes(
            "a Color as Weights",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": "x" }"##,
            &[&["colors never become weights"]],
        ),
        nodes(
            "a mask as a Color",
            r##""a": { "type": "Mix", "a": "t", "b": "#fff", "weight": 0.5 }"##,
            &[&["\"t\", a mask", "expected a Color", "as its weight"]],
        ),
        nodes(
            "a Field as a Color",
            r##""a": { "type": "Mix", "a": "depth", "b": "#fff", "weight": 0.5 }"##,
            &[&["\"depth\", a Field", "control colors make the color"]],
        ),
        nodes(
            "Weights as a Color",
            r##""a": { "type": "Mix", "a": "three", "b": "#fff", "weight": 0.5 }"##,
            &[&["a Weights(3)", "Mix, Blend, Ramp or Patch"]],
        ),
        nodes(
            "a Surface as a View",
            r#""a": { "type": "Depth", "view": "sea" }"#,
            &[&["\"sea\", a Surface", "put a Render between"]],
        ),
        nodes(
            "a Camera as a View",
            r#""a": { "type": "Depth", "view": "camera" }"#,
            &[&["\"camera\", a Camera", "put a Render between"]],
        ),
        nodes(
            "a View as a mask",
            r#""a": { "type": "Invert", "weight": "view" }"#,
            &[&["\"view\", a View", "put a pass between"]],
        ),
        nodes(
            "a View as a Color",
            r##""a": { "type": "Mix", "a": "view", "b": "#fff", "weight": 0.5 }"##,
            &[&["\"view\", a View", "put a pass between"]],
        ),
        nodes(
            "a Light as a Surface",
            r#""a": { "type": "Render", "camera": "camera", "surfaces": ["sun"] }"#,
            &[&["surfaces: found \"sun\", a Light", "connect a Surface"]],
        ),
        nodes(
            "a Surface as a Camera",
            r#""a": { "type": "Render", "camera": "sea", "surfaces": ["sea"] }"#,
            &[&["camera: found \"sea\", a Surface", "connect a Camera"]],
        ),
        nodes(
            "a Light as a mask",
            r#""a": { "type": "Invert", "weight": "sun" }"#,
            &[&["\"sun\", a Light", "expected a mask"]],
        ),
        nodes(
            "three weights for two colors",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": "three" }"##,
            &[&["node \"a\"", "3", "2"]],
        ),
        nodes(
            "a Color in a list of masks",
            r#""a": { "type": "Multiply", "weights": ["t", "x"] }"#,
            &[&["weights: found \"x\", a Color"]],
        ),
        nodes(
            "a mask in a stop",
            r#""a": { "type": "Ramp", "weight": "t", "stops": [{ "at": 0, "color": "t" }] }"#,
            &[&["color: found \"t\", a mask", "control colors make the color"]],
        ),
        nodes(
            "two components as one",
            r#""uv": { "type": "UV", "view": "view" }, "a": { "type": "Clamp", "field": "uv" }"#,
            &[&["bad.json:6:", "FieldMath", "\"a.x\""]],
        ),
        nodes(
            "what floats on no water",
            r#""model": { "type": "Mesh", "file": "a.obj" }, "a": { "type": "Float", "model": "model", "sea": "model", "bodies": [{}] }"#,
            &[&["bad.json:6:", "sea: found \"model\", a Mesh, which has no plane at rest", "RippleSea or ToonSea"]],
        ),
        nodes(
            "a model to bake",
            r#""model": { "type": "Mesh", "file": "a.obj" }, "a": { "type": "Bake", "sea": "model" }"#,
            &[&["bad.json:6:", "sea: found \"model\", a Mesh, which has no plane at rest", "RippleSea or ToonSea"]],
        ),
        nodes(
            "no list",
            r#""a": { "type": "Float", "model": "sea", "sea": "sea" }"#,
            &[&["no \"bodies\"", "a list of 1 to 64", "give \"bodies\": [{ … }, …], records with \"x\", \"z\""]],
        ),
    ]
}

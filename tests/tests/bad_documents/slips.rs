//! What people write who know what they want, and not quite how: the remedy must lead there.

use super::{Bad, nodes};

pub(super) fn table() -> Vec<Bad> {
    vec![
        nodes(
            "a pass that only a Render has",
            r#""p": { "type": "ViewFromPasses", "file": "a.exr", "depth": "d" }, "a": { "type": "Rift", "view": "p" }"#,
            &[&["which has no rift", "the view of a Render", "connect a Render", "no pass of a ViewFromPasses"]],
        ),
        nodes(
            "hooks on passes",
            r#""p": { "type": "ViewFromPasses", "file": "a.exr", "depth": "d" },
                "a": { "type": "Hooks", "view": "p", "rows": [{}] }"#,
            &[&["node \"a\", view", "\"p\", a view of passes, which knows no surfaces", "connect a Render"]],
        ),
        nodes(
            "masks in a and b",
            r#""a": { "type": "Multiply", "a": "t", "b": 0.5 }, "b": { "type": "Screen", "b": "a.mask" }"#,
            &[
                &["weights: found \"a\" and \"b\"", "masks in one list", "write \"weights\": [\"t\", 0.5]"],
                &["weights: found \"b\"", "write \"weights\": [\"a.mask\"]"],
            ],
        ),
        nodes(
            "a color among masks",
            r##""a": { "type": "Multiply", "weights": ["t", "#ffffff"] }"##,
            &[&["the color \"#ffffff\"", "expected a mask", "write a number from 0 to 1"]],
        ),
        nodes(
            "a color for a field",
            r##""a": { "type": "Clamp", "field": "#808080" }"##,
            &[&["the color \"#808080\"", "expected a Field", "write a number"]],
        ),
        nodes(
            "a picture as a mask",
            r#""a": { "type": "Read", "file": "a.png", "as": "mask" }"#,
            &[&["found \"mask\"", "color, weights, field", "a mask is weights of one channel"]],
        ),
        nodes(
            "a pass that is not named",
            r#""p": { "type": "ViewFromPasses", "file": "a.exr", "depth": "d" },
                "a": { "type": "Normal", "view": "p" }"#,
            &[&["which has no normal", "give \"p\" the pass"]],
        ),
        nodes(
            "a View as a Surface",
            r#""v": { "type": "Render", "camera": "camera", "surfaces": ["view"] }"#,
            &[&["\"view\", a View", "expected a Surface", "name the surfaces themselves"]],
        ),
        nodes(
            "a short key that is like none",
            r#""a": { "type": "InFront", "view": "view", "other": "view", "of": "view" }"#,
            &[&["unknown key \"of\"", "rename it to one of these, or remove it: view, other, soft"]],
        ),
        nodes(
            "a fraction between two inputs",
            r##""a": { "type": "Switch", "inputs": ["#000", "#fff"], "which": 1.5 }"##,
            &[&["which: found 1.5", "a whole number", "write 1"]],
        ),
        nodes(
            "a mesh for patches",
            r#""a": { "type": "BezierModel", "model": "a.obj" }"#,
            &[&["\"a.obj\", a mesh of triangles", "read it by the node Mesh"]],
        ),
        nodes(
            "patches for a mesh",
            r#""a": { "type": "Mesh", "file": "boat.JSON" }"#,
            &[&["a model of Bézier patches", ".obj, .glb, .gltf", "read it by the node BezierModel"]],
        ),
        nodes(
            "a picture for a mesh",
            r#""a": { "type": "Mesh", "file": "boat.png" }"#,
            &[&["\"boat.png\", a picture", "read it by the node Texture"]],
        ),
        nodes(
            "a color by name where a node could stand",
            r##""a": { "type": "Mix", "a": "red", "b": "#fff", "weight": 0.5 }"##,
            &[&["a reference to \"red\"", "a color is written \"#rrggbb\""]],
        ),
        nodes(
            "a packet that is too short",
            r#""s": { "type": "GerstnerSea", "groups": [{ "wavelength": 20, "height": 1, "along": 1 }] }"#,
            &[&[
                "groups: found groups[0] with \"along\" 1 m; expected at least 6.2",
                "0.31 of its wavelength",
                "raise \"along\"",
            ]],
        ),
        nodes(
            "a toon sea that grows",
            r#""s": { "type": "ToonSea", "c1": 0.9, "c2": 1.9 }"#,
            &[&[
                "c1: found c1 0.9, c2 1.9, with which the sea grows",
                "; expected |c1| ≤ 1",
                "remedy: set \"c1\" ",
                "the nearest that are stable with \"mode\" \"literal\"; or set \"mode\" \"physical\"",
                "the same waves are about \"speed\" ",
            ]],
        ),
        nodes(
            "rows of colors",
            r##""a": { "type": "Sheet", "u": "t", "v": "t", "columns": 3, "colors": [["#000", "#111", "#222"]] }"##,
            &[&["colors: found a list of 3", "expected a color", "one after another, without brackets"]],
        ),
        nodes(
            "stops without places",
            r##""a": { "type": "Ramp", "weight": "t", "stops": ["#000"] }"##,
            &[&["stops: found \"#000\"", "a record: { \"at\", \"color\" }", "give \"stops\": [{ … }, …]"]],
        ),
        nodes(
            "a function that is not known",
            r#""a": { "type": "FieldMath", "a": "depth", "expression": "sinn(a)" }"#,
            &[&["\"sinn\" at column 1", "did you mean \"sin\"?"]],
        ),
        nodes(
            "an input that is open",
            r#""a": { "type": "FieldMath", "a": "depth", "expression": "a + b" }"#,
            &[&["input b, to which nothing is connected at column 5", "connect \"b\", or leave it out"]],
        ),
        nodes(
            "keys without their name",
            r#""a": { "type": "Invert", "weight": 0.5 }, "s": { "type": "GerstnerSea", "height": [[1, 2], [4, 3]] }"#,
            &[&["height: found a list of pairs", "write { \"keys\": [[1, 2], …] }"]],
        ),
        nodes(
            "a kind that a wrong word decides",
            r#""r": { "type": "Read", "file": "a.exr", "as": "mask" }, "a": { "type": "Invert", "weight": "r" }"#,
            &[&["as: found \"mask\"", "one of color, weights, field"]],
        ),
        nodes(
            "a product of colors",
            r##""a": { "type": "Multiply", "a": "x", "b": "#fff" }"##,
            &[&[
                "bad.json:6:16: node \"a\", type",
                "the operation Multiply",
                "do not sum to 1",
                "Mix toward a darker color",
            ]],
        ),
        nodes(
            "a Color among masks that are multiplied",
            r#""a": { "type": "Screen", "weights": ["x", "t"] }"#,
            &[&["\"x\", a Color", "do not sum to 1", "combine the masks"]],
        ),
        nodes(
            "a number as a direction",
            r##""a": { "type": "Strokes", "image": "x", "flow": 45, "layers": [{}] }"##,
            &[&["flow: found 45", "a reference to a Field of 2 components"]],
        ),
        nodes(
            "a mask as a direction",
            r##""a": { "type": "Strokes", "image": "x", "flow": "t", "layers": [{}] }"##,
            &[&["\"t\", a mask", "a Field of 2 components", "connect a FlowField"]],
        ),
        nodes(
            "a camera beyond everything",
            r#""c": { "type": "Camera", "position": [1e30, 0, 0] }"#,
            &[&["position: found [1e30, 0.0, 0.0]", "within ±1e10 m"]],
        ),
        nodes(
            "a direction that leads nowhere",
            r#""a": { "type": "FlowField", "view": "view", "calm": [0, 0, 0], "steep": 0.1 }"#,
            &[&["calm: found [0, 0, 0]", "a direction in the world", "\"steep\": 0"]],
        ),
        nodes(
            "a sea that floats",
            r#""f": { "type": "Float", "model": "sea", "sea": "sea", "bodies": [{}] }"#,
            &[&["model: found \"sea\", a GerstnerSea, which is water itself", "connect a Mesh or a BezierModel"]],
        ),
    ]
}

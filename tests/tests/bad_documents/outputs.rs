//! Outputs.

use super::{Bad, outputs};

pub(super) fn table() -> Vec<Bad> {
    vec![
        outputs("no outputs", "", &[&["bad.json:6:", "a document without outputs", "nothing to render", "\"beauty\""]]),
        outputs(
            "a missing node",
            r#""beauty": { "color": "xx" }"#,
            &[&["bad.json:7:22: beauty", "\"xx\", which is no node", "did you mean \"x\"?"]],
        ),
        outputs(
            "a missing output of a node",
            r#""beauty": { "color": "x.colour" }"#,
            &[&["output \"colour\" of a Constant", "\"x.color\""]],
        ),
        outputs(
            "a mask as a color",
            r#""beauty": { "color": "t" }"#,
            &[&["bad.json:7:22: beauty", "\"t\", a mask", "a color", "write it as \"weights\""]],
        ),
        outputs("a Color as a field", r#""beauty": { "field": "x" }"#, &[&["\"x\", a Color", "write it as \"color\""]]),
        outputs(
            "a Field as weights",
            r#""beauty": { "weights": "depth" }"#,
            &[&["\"depth\", a Field", "write it as \"field\""]],
        ),
        outputs("a Surface", r#""beauty": { "field": "sea" }"#, &[&["\"sea\", a Surface", "connect a pass"]]),
        outputs(
            "a literal",
            r##""beauty": { "color": [1, 0, 0] }"##,
            &[&["found a list of 3", "a reference to a node"]],
        ),
        outputs("nothing", r#""beauty": {}"#, &[&["an output that renders nothing"]]),
        outputs("two things", r#""beauty": { "color": "x", "field": "depth" }"#, &[&["a second thing to render"]]),
        outputs(
            "unknown key",
            r#""beauty": { "color": "x", "fil": "a.exr" }"#,
            &[&["unknown key \"fil\"", "did you mean \"file\"?"]],
        ),
        outputs("a bad name", r#""be auty": { "color": "x" }"#, &[&["the output name \"be auty\"", "rename"]]),
        outputs(
            "a bad ending",
            r#""beauty": { "color": "x", "file": "a.jpg" }"#,
            &[&["the file \"a.jpg\"", ".exr or .png"]],
        ),
        outputs(
            "a file as a number",
            r#""beauty": { "color": "x", "file": 3 }"#,
            &[&["found 3", "a path with the ending"]],
        ),
        outputs(
            "a precision of the other format",
            r#""beauty": { "color": "x", "file": "a.png", "precision": "half" }"#,
            &[&["precision half for \"a.png\"", "uint8 or uint16 for PNG"]],
        ),
        outputs(
            "an unknown precision",
            r#""beauty": { "color": "x", "precision": "double" }"#,
            &[&["found \"double\"", "half, float"]],
        ),
        outputs(
            "an unknown guarantee",
            r#""beauty": { "color": "x", "require": { "guarantee": "ball" } }"#,
            &[&["found \"ball\"", "hull or box"]],
        ),
        outputs(
            "a requirement on a mask",
            r#""beauty": { "color": "x" }, "m": { "weights": "t", "require": { "guarantee": "hull" } }"#,
            &[&["a requirement on \"weights\"", "only colors have a palette"]],
        ),
        outputs(
            "an unknown requirement",
            r#""beauty": { "color": "x", "require": { "guarante": "hull" } }"#,
            &[&["unknown key \"guarante\"", "did you mean \"guarantee\"?"]],
        ),
        outputs("a bad layer", r#""beauty": { "color": "x", "layer": "a.b" }"#, &[&["found \"a.b\"", "a layer name"]]),
        outputs(
            "an output twice",
            r#""beauty": { "color": "x" }, "beauty": { "color": "y" }"#,
            &[&["\"beauty\" a second time"]],
        ),
        outputs(
            "a Field in a PNG",
            r#""beauty": { "field": "depth", "file": "a.png" }"#,
            &[&["bad.json:7:39: beauty", "found \"a.png\", a PNG, for a Field", "give the path the ending .exr"]],
        ),
    ]
}

//! Nodes with wrong names, types, keys and connections.

use super::{Bad, nodes};

pub(super) fn table() -> Vec<Bad> {
    vec![
        nodes(
            "a name twice",
            r##""a": { "type": "ScreenX" }, "a": { "type": "ScreenY" }"##,
            &[&["bad.json:6:29: nodes", "\"a\" a second time", "the first stands at 6:1", "rename"]],
        ),
        nodes(
            "a key twice",
            r##""a": { "type": "Constant", "color": "#fff", "color": "#000" }"##,
            &[&["bad.json:6:45: node \"a\"", "\"color\" a second time", "6:28"]],
        ),
        nodes(
            "a name with a space",
            r#""my sea": { "type": "ScreenX" }"#,
            &[&["bad.json:6:1", "the name \"my sea\"", "rename"]],
        ),
        nodes("a name that starts with a digit", r#""1st": { "type": "ScreenX" }"#, &[&["the name \"1st\""]]),
        nodes("an empty name", r#""": { "type": "ScreenX" }"#, &[&["bad.json:6:1", "the name \"\""]]),
        nodes(
            "a node as a number",
            r#""a": 7"#,
            &[&["bad.json:6:1: node \"a\"", "found 7", "an object with a \"type\""]],
        ),
        nodes(
            "no type",
            r##""a": { "color": "#fff" }"##,
            &[&["bad.json:6:1: node \"a\"", "no \"type\"", "`trochoid nodes`"]],
        ),
        nodes("type as a number", r#""a": { "type": 3 }"#, &[&["bad.json:6:16: node \"a\", type", "found 3"]]),
        nodes(
            "unknown type",
            r#""a": { "type": "Mixx" }"#,
            &[&["bad.json:6:16: node \"a\", type", "unknown node type \"Mixx\"", "did you mean \"Mix\"?"]],
        ),
        nodes("a type in another case", r#""a": { "type": "screenx" }"#, &[&["did you mean \"ScreenX\"?"]]),
        nodes(
            "a strange type",
            r#""a": { "type": "Zzyzx" }"#,
            &[&["unknown node type \"Zzyzx\"", "`trochoid nodes` lists"]],
        ),
        nodes(
            "a type of other programs",
            r#""a": { "type": "image_read" }, "b": { "type": "Checkerboard" }, "c": { "type": "Write" }, "d": { "type": "Transform" }"#,
            &[
                &["unknown node type \"image_read\"", "the node for that is \"Read\""],
                &["\"Checkerboard\"", "\"FieldMath\" (a formula)"],
                &["\"Write\"", "under \"outputs\", with a \"file\""],
                &["\"Transform\"", "\"Warp\" (by \"dx\" and \"dy\")"],
            ],
        ),
        nodes(
            "a type that is near to one and the term of another",
            r#""a": { "type": "Lights" }, "b": { "type": "Step" }"#,
            &[&["did you mean \"Light\"?"], &["the node for that is \"Bands\""]],
        ),
        nodes(
            "unknown knob",
            r#""a": { "type": "Clamp", "field": "t", "powr": 2 }"#,
            &[&["bad.json:6:39: node \"a\"", "unknown key \"powr\"", "did you mean \"power\"?"]],
        ),
        nodes(
            "disabled as a text",
            r#""a": { "type": "ScreenX", "disabled": "yes" }"#,
            &[&["disabled: found \"yes\"", "true or false"]],
        ),
        nodes(
            "missing port",
            r#""a": { "type": "Invert" }"#,
            &[&["bad.json:6:1: node \"a\", weight", "no \"weight\"", "a mask", "connect it"]],
        ),
        nodes(
            "two missing ports",
            r##""a": { "type": "Mix", "a": "#fff" }"##,
            &[&["b: found no \"b\"", "a Color"], &["weight: found no \"weight\"", "a mask"]],
        ),
        nodes(
            "missing knob",
            r#""a": { "type": "Constant" }"#,
            &[&["color: found no \"color\"", "write \"color\": \"#rrggbb\""]],
        ),
        nodes(
            "missing word",
            r#""a": { "type": "Read", "file": "x.png" }"#,
            &[&[
                "as: found no \"as\"",
                "one of color, weights, field",
                "write \"as\": \"color\", \"weights\", or \"field\"",
            ]],
        ),
        nodes(
            "missing file",
            r#""a": { "type": "Read", "as": "color" }"#,
            &[&["file: found no \"file\"", "write \"file\": the path of a file in quotes"]],
        ),
        nodes(
            "unknown node",
            r#""a": { "type": "Invert", "weight": "tt" }"#,
            &[&["bad.json:6:36: node \"a\", weight", "\"tt\", which is no node", "did you mean \"t\"?"]],
        ),
        nodes(
            "unknown output of a node",
            r#""a": { "type": "Invert", "weight": "view.covrage" }"#,
            &[&["output \"covrage\" of a Render", "did you mean \"view.coverage\"?"]],
        ),
        nodes(
            "a number as a reference",
            r#""a": { "type": "Depth", "view": 3 }"#,
            &[&["view: found 3", "a reference to a View"]],
        ),
        nodes(
            "null",
            r#""a": { "type": "Invert", "weight": null }"#,
            &[&["weight: found null", "a reference to a mask or a number"]],
        ),
        nodes(
            "one where a list is due",
            r#""a": { "type": "Multiply", "weights": "t" }"#,
            &[&["weights: found \"t\"", "a list of", "in brackets"]],
        ),
        nodes(
            "a list where one is due",
            r#""a": { "type": "Invert", "weight": ["t"] }"#,
            &[&["weight: found a list of 1"]],
        ),
        nodes(
            "too few in a list",
            r##""a": { "type": "Patch", "u": "t", "v": "t", "colors": ["#fff"] }"##,
            &[&["colors: found a list of 1"]],
        ),
        nodes(
            "unknown key of a stop",
            r##""a": { "type": "Ramp", "weight": "t", "stops": [{ "at": 0, "color": "#fff", "colour": 1 }] }"##,
            &[&["bad.json:6:77", "unknown key \"colour\"", "did you mean \"color\"?"]],
        ),
        nodes(
            "a stop as a number",
            r#""a": { "type": "Ramp", "weight": "t", "stops": [3] }"#,
            &[&["bad.json:6:49", "stops: found 3", "a record"]],
        ),
        nodes("no stops", r#""a": { "type": "Ramp", "weight": "t", "stops": [] }"#, &[&["stops: found a list of 0"]]),
        nodes(
            "stops out of order",
            r##""a": { "type": "Ramp", "weight": "t", "stops": [{ "at": 1, "color": "#fff" }, { "at": 0, "color": "#000" }] }"##,
            &[&["a stop at 0 after one at 1", "sort the stops"]],
        ),
        nodes(
            "an escape sequence in a name",
            r#""a": { "type": "Invert", "weight": "\u001b[31m" }"#,
            &[&[r"\u{1b}[31m", "which is no node"]],
        ),
    ]
}

//! Faults outside nodes and outputs.

use super::{Bad, top, whole};

pub(super) fn table() -> Vec<Bad> {
    vec![
        whole(
            "an empty object",
            "{}",
            &[
                &["no \"trochoid\"", "add \"trochoid\": 1"],
                &["bad.json:1:1: format", "no \"format\"", "add \"format\""],
                &["nodes", "no \"nodes\""],
                &["no \"outputs\"", "beauty"],
            ],
        ),
        top(
            "unknown key",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "ouputs": 1"#,
            &[&["bad.json:1:57: ouputs", "unknown key \"ouputs\"", "did you mean \"outputs\"?"]],
        ),
        top(
            "key twice",
            r#""trochoid": 1, "trochoid": 1, "format": { "width": 4, "height": 4 }"#,
            &[&["bad.json:1:18", "\"trochoid\" a second time", "the first stands at 1:3"]],
        ),
        top(
            "unknown version",
            r#""trochoid": 2, "format": { "width": 4, "height": 4 }"#,
            &[&["bad.json:1:15: trochoid", "found 2, a newer version", "expected 1, the newest", "a newer Trochoid"]],
        ),
        top(
            "version before the first",
            r#""trochoid": 0, "format": { "width": 4, "height": 4 }"#,
            &[&["bad.json:1:15: trochoid", "found 0", "expected 1, the version", "write \"trochoid\": 1"]],
        ),
        top(
            "version as text",
            r#""trochoid": "1", "format": { "width": 4, "height": 4 }"#,
            &[&["found \"1\"", "expected 1"]],
        ),
        top("no version", r#""format": { "width": 4, "height": 4 }"#, &[&["no \"trochoid\"", "add \"trochoid\": 1"]]),
        top("no format", r#""trochoid": 1"#, &[&["no \"format\"", "\"width\": 1920"]]),
        top("format as a list", r#""trochoid": 1, "format": [4, 4]"#, &[&["bad.json:1:28: format", "a list of 2"]]),
        top("no height", r#""trochoid": 1, "format": { "width": 4 }"#, &[&["without \"width\" or \"height\""]]),
        top(
            "width 0",
            r#""trochoid": 1, "format": { "width": 0, "height": 4 }"#,
            &[&["bad.json:1:28: format", "found 0 × 4 pixels", "from 1 to 1048576"]],
        ),
        top(
            "width too large",
            r#""trochoid": 1, "format": { "width": 1048577, "height": 4 }"#,
            &[&["found 1048577 × 4 pixels", "from 1 to 1048576"]],
        ),
        top(
            "too many pixels",
            r#""trochoid": 1, "format": { "width": 65536, "height": 32769 }"#,
            &[&["2147549184 pixels", "at most 2147483648"]],
        ),
        top(
            "half a pixel",
            r#""trochoid": 1, "format": { "width": 4.5, "height": 4 }"#,
            &[&["bad.json:1:39: width", "found 4.5", "a whole number of pixels"]],
        ),
        top(
            "negative height",
            r#""trochoid": 1, "format": { "width": 4, "height": -4 }"#,
            &[&["bad.json:1:52: height", "found -4"]],
        ),
        top(
            "3 samples",
            r#""trochoid": 1, "format": { "width": 4, "height": 4, "samples": 3 }"#,
            &[&["found 3 samples a pixel", "expected 1, 4 or 16"]],
        ),
        top(
            "unknown key of format",
            r#""trochoid": 1, "format": { "width": 4, "hight": 4, "height": 4 }"#,
            &[&["bad.json:1:42: format", "unknown key \"hight\"", "did you mean \"height\"?"]],
        ),
        top(
            "unknown working space",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "working_space": "rec709""#,
            &[&["bad.json:1:74: working_space", "found \"rec709\"", "linear-srgb", "acescg"]],
        ),
        top(
            "working space as a number",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "working_space": 3"#,
            &[&["found 3", "one of linear-srgb"]],
        ),
        top(
            "frames backward",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "first": 9, "last": 1 }"#,
            &[&["bad.json:1:67: frames", "first 9 after last 1", "exchange them"]],
        ),
        top(
            "half a frame",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "first": 1.5 }"#,
            &[&["bad.json:1:78: first", "found 1.5", "a whole number"]],
        ),
        top(
            "frame beyond the limit",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "last": 1e8 }"#,
            &[&["last", "found 100000000", "10000000"]],
        ),
        top(
            "no frames a second",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "fps": 0 }"#,
            &[&["fps: found 0", "above 0"]],
        ),
        top(
            "unknown key of frames",
            r#""trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "start": 1 }"#,
            &[&["frames", "unknown key \"start\"", "first, last, fps"]],
        ),
        whole(
            "nodes as a list",
            r#"{ "trochoid": 1, "format": { "width": 4, "height": 4 }, "nodes": [], "outputs": { "b": { "color": "x" } } }"#,
            &[&["bad.json:1:66: nodes", "a list of 0", "an object of nodes by name"], &["\"x\", which is no node"]],
        ),
    ]
}

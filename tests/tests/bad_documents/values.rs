//! Numbers, colors, weights, words and keys that are out of range.

use super::{Bad, nodes};

pub(super) fn table() -> Vec<Bad> {
    vec![
        nodes(
            "a mask above 1",
            r#""a": { "type": "Invert", "weight": 1.5 }"#,
            &[&["bad.json:6:36", "weight: found 1.5", "a number in [0, 1]", "both be ≥ 0"]],
        ),
        nodes(
            "a mask below 0",
            r#""a": { "type": "Invert", "weight": -0.1 }"#,
            &[&["found -0.1", "a number in [0, 1]"]],
        ),
        nodes(
            "a power below 1",
            r#""a": { "type": "Clamp", "field": "t", "power": 0.5 }"#,
            &[&["bad.json:6:48", "power: found 0.5", "from 1 to 1000", "nearest legal value is 1"]],
        ),
        nodes(
            "not finite",
            r#""a": { "type": "Clamp", "field": "t", "max": 1e999 }"#,
            &[&["max: found a number beyond the range of f64", "finite"]],
        ),
        nodes("not finite as a Field", r#""a": { "type": "Clamp", "field": 1e999 }"#, &[&["field: found", "finite"]]),
        nodes(
            "a number as a text",
            r#""a": { "type": "Clamp", "field": "t", "max": "10" }"#,
            &[&["max: found \"10\"", "a finite number"]],
        ),
        nodes(
            "a truth value as a number",
            r#""a": { "type": "Clamp", "field": "t", "smooth": 1 }"#,
            &[&["smooth: found 1", "true or false"]],
        ),
        nodes(
            "an empty range",
            r#""a": { "type": "Clamp", "field": "t", "min": 2, "max": 1 }"#,
            &[&["node \"a\"", "2", "1"]],
        ),
        nodes(
            "a negative color",
            r#""a": { "type": "Constant", "color": [0.1, -0.2, 0.3] }"#,
            &[&["bad.json:6:43", "color: found -0.2", "nearest legal value is 0"]],
        ),
        nodes(
            "a color that is not finite",
            r#""a": { "type": "Constant", "color": [0.1, 1e400, 0.3] }"#,
            &[&["color: found a number beyond"]],
        ),
        nodes(
            "a color beyond f32",
            r#""a": { "type": "Constant", "color": [0.1, 1e300, 0.3] }"#,
            &[&["color: found 1e300", "a number that f32 can hold", "write at most 3.4e38"]],
        ),
        nodes(
            "two channels",
            r#""a": { "type": "Constant", "color": [0.1, 0.2] }"#,
            &[&["color: found a list of 2", "[r, g, b]"]],
        ),
        nodes(
            "bad digits",
            r##""a": { "type": "Constant", "color": "#12345g" }"##,
            &[&["bad.json:6:37", "found \"#12345g\"", "#rrggbb or #rgb"]],
        ),
        nodes("four digits", r##""a": { "type": "Constant", "color": "#1234" }"##, &[&["found \"#1234\"", "#rrggbb"]]),
        nodes("a color by name", r#""a": { "type": "Constant", "color": "red" }"#, &[&["found \"red\"", "#rrggbb"]]),
        nodes(
            "a bad color at a port",
            r##""a": { "type": "Mix", "a": "#ggg", "b": "#fff", "weight": 0.5 }"##,
            &[&["a: found \"#ggg\"", "#rrggbb"]],
        ),
        nodes(
            "weights that sum to 2",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": [1, 1] }"##,
            &[&["weights that sum to 2", "would give 1.2", "[0.5000, 0.5000]"]],
        ),
        nodes(
            "weights that sum to 0",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": [0, 0] }"##,
            &[&["weights that sum to 0", "one weight must be above 0"]],
        ),
        nodes(
            "a negative weight",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": [1.5, -0.5] }"##,
            &[&["the weight -0.5", "out of the palette on the far side"]],
        ),
        nodes(
            "a text among weights",
            r##""a": { "type": "Blend", "colors": ["#fff", "#000"], "weights": [1, "t"] }"##,
            &[&["weights: found \"t\"", "a finite number"]],
        ),
        nodes(
            "thresholds out of order",
            r#""a": { "type": "Bands", "field": "depth", "thresholds": [3, 1] }"#,
            &[&["node \"a\", thresholds", "ascend"]],
        ),
        nodes(
            "an unknown word",
            r##""a": { "type": "Ramp", "weight": "t", "interpolation": "smoth", "stops": [{ "at": 0, "color": "#fff" }] }"##,
            &[&["interpolation: found \"smoth\"", "linear, smooth, step", "did you mean \"smooth\"?"]],
        ),
        nodes(
            "an empty path",
            r#""a": { "type": "Read", "file": "", "as": "color" }"#,
            &[&["file: found \"\"", "a path relative to the document"]],
        ),
        nodes(
            "keys out of order",
            r#""a": { "type": "Invert", "weight": { "keys": [[5, 0], [1, 1]] } }"#,
            &[&["bad.json:6:36", "keys out of order", "sort the keys"]],
        ),
        nodes(
            "a frame twice",
            r#""a": { "type": "Invert", "weight": { "keys": [[5, 0], [5, 1]] } }"#,
            &[&["keys out of order", "each once"]],
        ),
        nodes(
            "a keyed mask above 1",
            r#""a": { "type": "Invert", "weight": { "keys": [[1, 0], [5, 2]] } }"#,
            &[&["bad.json:6:59", "weight: found 2", "from 0 to 1"]],
        ),
        nodes(
            "no keys",
            r#""a": { "type": "Invert", "weight": {} }"#,
            &[&["a keyed value without \"keys\"", "add the keys"]],
        ),
        nodes(
            "empty keys",
            r#""a": { "type": "Invert", "weight": { "keys": [] } }"#,
            &[&["keys", "[[frame, value], …]"]],
        ),
        nodes(
            "a key of three",
            r#""a": { "type": "Invert", "weight": { "keys": [[1, 2, 3]] } }"#,
            &[&["found a list of 3", "[frame, value]"]],
        ),
        nodes(
            "an unknown interpolation",
            r#""a": { "type": "Invert", "weight": { "keys": [[1, 0]], "interpolation": "cubic" } }"#,
            &[&["found \"cubic\"", "linear, hold, monotone"]],
        ),
        nodes(
            "an unknown key of a keyed value",
            r#""a": { "type": "Invert", "weight": { "keys": [[1, 0]], "interp": "hold" } }"#,
            &[&["unknown key \"interp\"", "did you mean \"interpolation\"?"]],
        ),
        nodes(
            "a keyed truth value",
            r#""a": { "type": "Clamp", "field": "t", "smooth": { "keys": [[1, true]] } }"#,
            &[&["smooth: found a keyed value", "cannot be keyed"]],
        ),
    ]
}

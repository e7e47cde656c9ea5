//! Loops, and what disabled nodes leave open.

use super::{Bad, chain, nodes, outputs};

pub(super) fn table() -> Vec<Bad> {
    vec![
        nodes(
            "a node of itself",
            r#""a": { "type": "Invert", "weight": "a" }"#,
            &[&["bad.json:6:1: node \"a\"", "the loop a ← a", "without loops", "remove one"]],
        ),
        nodes(
            "a loop of three",
            r#""a": { "type": "Invert", "weight": "b" }, "b": { "type": "Invert", "weight": "c" }, "c": { "type": "Invert", "weight": "a" }"#,
            &[&["the loop a ← b ← c ← a"]],
        ),
        nodes(
            "two loops",
            r#""a": { "type": "Invert", "weight": "a" }, "b": { "type": "Invert", "weight": "b" }"#,
            &[&["the loop a ← a"], &["the loop b ← b"]],
        ),
        nodes("a loop of 500", &chain(500, "n499"), &[&["node \"n0\"", "the loop", "(500 nodes)"]]),
        nodes(
            "a loop through a disabled node",
            r#""a": { "type": "Invert", "weight": "b" }, "b": { "type": "Invert", "weight": "a", "disabled": true }"#,
            &[&["the loop a ← a"]],
        ),
        nodes(
            "a disabled node that leaves a port open",
            r#""a": { "type": "ScreenX", "disabled": true }, "b": { "type": "Invert", "weight": "a" }"#,
            &[&["bad.json:6:82: node \"b\", weight", "a disabled node that hands on nothing", "enable the node"]],
        ),
        nodes(
            "a disabled node that hands on another kind",
            r#""a": { "type": "Clamp", "field": "depth", "disabled": true }, "b": { "type": "Invert", "weight": "a" }"#,
            &[&["node \"b\", weight", "a disabled node"]],
        ),
        outputs(
            "a disabled output",
            r#""beauty": { "color": "x" }, "off": { "color": "off" }"#,
            &[&["\"off\", which is no node"]],
        ),
    ]
}

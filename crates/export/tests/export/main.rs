//! Texts of shaders, and outputs that are refused. `.ci/export` runs the shaders in other programs.
//!
//! The texts are stored beside this file; `TROCHOID_UPDATE=1` stores them again.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../../tests/tests/support/stored.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod stored;

use std::collections::BTreeSet;
use std::path::Path;
use trochoid::{CheckedGraph, parse};
use trochoid_engine::PointwiseProgram;
use trochoid_export::{ExportError, Language, Request, Shader, export};

/// Loads a document of these nodes, with the output `look` and more.
fn graph(nodes: &str, outputs: &str) -> CheckedGraph {
    named("look.json", nodes, outputs)
}

fn named(name: &str, nodes: &str, outputs: &str) -> CheckedGraph {
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }}, "working_space": "srgb",
        "nodes": {{ {nodes} }},
        "outputs": {{ {outputs} }} }}"##
    );
    match parse(name, &text, Path::new("."), &[]) {
        Ok(loaded) => loaded.graph,
        Err(error) => panic!("{error}"),
    }
}

fn exported(graph: &CheckedGraph, output: &str, bound: &[&str], language: Language) -> Result<Shader, ExportError> {
    let output = graph.outputs().iter().position(|spec| spec.name == output).unwrap();
    export(graph, &Request { output, frame: 1, bound, linear: false, language, by: "Trochoid" })
}

/// Every operation: the nodes beside the look give those that it has not.
const NODES: &str = r##"
    "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" }, "tint": { "type": "Constant", "color": "#204060" },
    "parts": { "type": "Bands", "field": "across", "thresholds": [0.2, 0.6] },
    "lit": { "type": "Clamp", "field": "across", "min": 0.1, "max": 0.9, "smooth": true },
    "deep": { "type": "Clamp", "field": "down", "min": -0.5, "max": 2, "power": 2.5 },
    "sides": { "type": "Bands", "field": "down", "thresholds": [0.5] },
    "hard": { "type": "PickWeight", "weights": "sides", "index": 1 },
    "both": { "type": "Multiply", "weights": ["lit", "deep"] },
    "other": { "type": "Invert", "weight": "hard" },
    "shares": { "type": "Normalize", "fields": ["across", "down"], "floor": 0.5 },
    "one": { "type": "PickWeight", "weights": "shares", "index": 1 },
    "water": { "type": "Mix", "a": "tint", "b": "#ece6c2", "weight": "both" },
    "some": { "type": "Blend", "colors": ["water", "#839191", "#274e53"], "weights": "shares" },
    "more": { "type": "Blend", "colors": ["some", "#ffffff", "water"], "weights": "parts" },
    "fixed": { "type": "Blend", "colors": ["more", "tint"], "weights": [0.25, 0.75] },
    "mixed": { "type": "Mix", "a": "fixed", "b": "more", "weight": "other" },
    "look": { "type": "Mix", "a": "mixed", "b": "#000000", "weight": "one" }"##;

const OUTPUTS: &str = r#""look": { "color": "look" }, "one": { "weights": "one" }, "shares": { "weights": "shares" },
    "across": { "field": "across" }"#;

const BOUND: [&str; 4] = ["across", "down", "tint", "parts"];

#[test]
fn every_operation_is_written_in_every_language() {
    let graph = graph(NODES, OUTPUTS);
    let bound: Vec<_> = BOUND.iter().map(|name| graph.find(name).unwrap()).collect();
    let made = PointwiseProgram::new(&graph, 0, 1, &bound);
    // Without names of fields: only which operations there are.
    let found: BTreeSet<String> = made
        .program
        .ops()
        .iter()
        .map(|(op, _)| format!("{op:?}").split([' ', '(']).next().unwrap().to_owned())
        .collect();
    let all = [
        "Blend",
        "Clamp",
        "Complement",
        "Constant",
        "ConstantColor",
        "Load",
        "LoadColor",
        "Mix",
        "Normalize",
        "Partition",
        "Power",
        "Product",
        "Smooth",
        "Step",
        "Weight",
    ];
    assert!(found.iter().eq(all), "{found:?}");
    for language in Language::ALL {
        let shader = exported(&graph, "look", &BOUND, language).unwrap();
        let names = ["look", "across", "down", "tint", "parts_0", "parts_1", "parts_2"];
        assert_eq!((&shader.names[..], &shader.unread[..]), (&names.map(String::from)[..], &[][..]));
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export").join(language.extension());
        stored::holds(&path.with_file_name(format!("look.{}", language.extension())), &shader.text).unwrap();
    }
}

#[test]
fn every_kind_of_output_is_written() {
    let graph = graph(NODES, OUTPUTS);
    let text = |output: &str, language: Language| exported(&graph, output, &BOUND[..2], language).unwrap().text;
    for (output, function) in [
        ("one", "float one(float across, float down)\n"),
        (
            "shares",
            "void shares(float across, float down, out float shares_0, out float shares_1, out float shares_2)\n",
        ),
        (
            "across",
            "float across(float across_2, float down)\n{\n    float t0 = across_mask(across_2);\n    return t0;\n}\n",
        ),
    ] {
        let text = text(output, Language::Glsl);
        assert!(text.contains(function), "{text}");
    }
    let osl = text("shares", Language::Osl);
    assert!(osl.contains("    output float shares_0 = 0.0,\n") && osl.contains("\n    shares_2 = w"), "{osl}");
    let graph_of_nodes = text("shares", Language::MaterialX);
    assert_eq!(graph_of_nodes.matches("<output ").count(), 3, "{graph_of_nodes}");
    // An output of MaterialX leads to a node, even if there is nothing to compute.
    let plain = self::graph(r#""spots": { "type": "Noise", "scale": 3 }"#, r#""spots": { "field": "spots" }"#);
    let plain = exported(&plain, "spots", &["spots"], Language::MaterialX).unwrap().text;
    assert!(plain.contains("<dot "), "{plain}");
}

#[test]
fn what_a_shader_cannot_compute_is_refused_by_name() {
    let nodes = r##""eye": { "type": "Camera", "position": [0, 3, 12], "target": [0, 1, 0] },
        "sail": { "type": "BezierModel", "patches": [{ "points": [{ "at": [-1, 0, 5] }, { "at": [2, -1, 4] },
          { "at": [0, 4, 5] }, { "at": [1, 3.5, 3] }] }] },
        "view": { "type": "Render", "camera": "eye", "surfaces": ["sail"] },
        "spots": { "type": "Noise", "scale": 3 },
        "foam": { "type": "Clamp", "field": "spots", "min": 0.1 },
        "never": { "type": "Noise", "scale": 5 },
        "unseen": { "type": "Clamp", "field": "never", "min": 50, "max": 60 },
        "a": { "type": "Mix", "a": "#000000", "b": "#ffffff", "weight": "foam" },
        "b": { "type": "Mix", "a": "a", "b": "#808080", "weight": "unseen" },
        "soft": { "type": "Blur", "image": "b", "size": 3 },
        "look": { "type": "Mix", "a": "b", "b": "#102030", "weight": "view.coverage" },
        "last": { "type": "Mix", "a": "soft", "b": "#102030", "weight": "foam" }"##;
    let outputs =
        r#""look": { "color": "look" }, "last": { "color": "last" }, "all": { "recipe": "look", "file": "r.exr" }"#;
    let graph = graph(nodes, outputs);
    let refused = |output: &str, bound: &[&str]| {
        exported(&graph, output, bound, Language::Glsl).map(|shader| shader.text).unwrap_err().to_string()
    };
    // What is proved not to matter, here `never`, need not be bound.
    let found = refused("look", &[]);
    let lines: Vec<&str> = found.lines().collect();
    assert_eq!(lines.len(), 2, "{found}");
    assert!(lines[0].contains("node \"view\" (Render): found a node that computes a mask from more"), "{found}");
    assert!(lines[1].contains("node \"spots\" (Noise): found a node that computes a Field from more"), "{found}");
    assert!(lines.iter().all(|line| line.starts_with("look.json:") && line.contains("expected a pointwise node")));
    // A filter takes colors and gives colors, but from more than one point.
    let last = refused("last", &["spots"]);
    assert!(last.contains("node \"soft\" (Blur): found a node that computes a Color"), "{last}");
    exported(&graph, "last", &["soft", "foam"], Language::Glsl).unwrap();
    for (bound, words) in [
        (&["spot"][..], &["input \"spot\": found no node", "did you mean spots?"][..]),
        (&["view"], &["found a View of \"view\" (a Render)", "name view.coverage"]),
        (&["view.depth"], &["found no such output of \"view\" (a Render)", "expected one of view.coverage"]),
        (&["eye"], &["found a Camera of \"eye\"", "name what is made of it"]),
        (&["spots", "spots"], &["found it twice"]),
    ] {
        let found = refused("look", bound);
        assert!(words.iter().all(|word| found.contains(word)), "{found}");
    }
    assert!(refused("all", &[]).contains("output \"all\": found a recipe"));
    // A node that an input hides is not read.
    let shader = exported(&graph, "look", &["foam", "view.coverage", "spots"], Language::Osl).unwrap();
    assert_eq!(shader.unread, ["spots"]);
    assert!(shader.text.contains("float spots = 0.0"), "{}", shader.text);
}

#[test]
fn no_name_ends_a_comment_or_is_a_word_of_a_language() {
    let nodes = r##""float": { "type": "ScreenX" }, "gl_x__y": { "type": "ScreenY" },
        "look": { "type": "Mix", "a": "#000000", "b": "#ffffff", "weight": "float" },
        "mixed": { "type": "Mix", "a": "look", "b": "#808080", "weight": "gl_x__y" }"##;
    let graph = named("a\n#error \"*/ --> é.json", nodes, r#""mix-2": { "color": "mixed" }"#);
    for language in Language::ALL {
        let shader = exported(&graph, "mix-2", &["float", "gl_x__y"], language).unwrap();
        assert_eq!(shader.names.len(), 3, "{:?}", shader.names);
        for name in &shader.names {
            assert!(
                !["float", "mix"].contains(&name.as_str()) && !name.starts_with("gl_") && !name.contains("__"),
                "{name}"
            );
        }
        assert!(shader.text.is_ascii(), "{}", shader.text);
        assert!(shader.text.lines().all(|line| !line.starts_with("#error")), "{}", shader.text);
        let closed = shader.text.matches("-->").count();
        assert_eq!(closed, if language == Language::MaterialX { 1 } else { closed }, "{}", shader.text);
    }
}

//! `check` reports faults of input files with the messages with which `render` fails.

use crate::scene::{READS, Run, Scene};
use std::fs;

/// Returns the lines with errors.
fn errors(run: &Run) -> Vec<String> {
    run.err.lines().filter(|line| line.starts_with("error: ")).map(str::to_owned).collect()
}

#[test]
fn headers_that_do_not_fit_are_told_as_rendering_tells_them() {
    let scene = Scene::new("");
    scene.write_picture("in.exr", 0.5);
    let of = |node: &str| READS.replace(r#""type": "Read", "file": "in.exr", "as": "color""#, node);
    let field = |node: &str| of(node).replace("\"color\": \"in\"", "\"field\": \"in\"");
    let wide = READS.replace("\"width\": 4", "\"width\": 5");
    let passes = r#""type": "ViewFromPasses", "file": "in.exr", "depth": "#;
    let seen = |depth: &str| {
        field(&format!("{passes}{depth}"))
            .replace("\"in\": {", "\"d\": { \"type\": \"Depth\", \"view\": \"in\" }, \"in\": {")
            .replace("\"field\": \"in\"", "\"field\": \"d\"")
    };
    let cases = [
        (wide.clone(), "set \"fit\" to"),
        (of(r#""type": "Read", "file": "in.exr", "as": "color", "channels": ["X"]"#), "in the node's \"channels\""),
        (of(r#""type": "Read", "file": "in.exr", "as": "color", "layer": "far""#), "no layer \"far\""),
        (
            of(r#""type": "Read", "file": "in.exr", "as": "color", "premultiplied": true"#),
            "a channel \"A\" to divide by",
        ),
        (field(r#""type": "Read", "file": "in.exr", "as": "field""#), "3 channels"),
        (field(r#""type": "Texture", "file": "in.exr", "as": "field", "u": 0, "v": 0"#), "3 channels"),
        (of(r#""type": "Texture", "file": "in.exr", "as": "color", "part": "9", "u": 0, "v": 0"#), "no part"),
        (seen("\"Z\""), "no layer \"Z\""),
        (seen("\"RGB\""), "expected one; name the channel"),
        (seen("\"R\"").replace("\"width\": 4", "\"width\": 5"), "set \"fit\" to"),
        (of(r#""type": "Read", "file": "a.json", "as": "color""#), "found JSON"),
    ];
    for (document, words) in cases {
        fs::write(scene.path("a.json"), &document).unwrap();
        let rendered = scene.run(&["render", "a.json"]).code(1);
        let checked = scene.run(&["check", "a.json"]).code(2);
        assert_eq!(errors(&checked), errors(&rendered), "{document}");
        assert!(errors(&checked).len() == 1 && checked.err.contains(words), "{words}: {}", checked.err);
        checked.says(&["cannot be rendered"]);
        let json = scene.run(&["check", "a.json", "--json"]).code(2).json();
        assert_eq!(json["valid"], false);
        assert!(json["not_planned"].as_str().unwrap().starts_with("frame 1: a.json:"), "{json:#}");
    }
    fs::write(scene.path("a.json"), wide.replace("\"as\"", "\"fit\": \"nearest\", \"as\"")).unwrap();
    scene.run(&["check", "a.json"]).code(0).says(&["valid"]);
    // A missing file may be made before rendering.
    fs::write(scene.path("a.json"), wide.replace("in.exr", "later.exr")).unwrap();
    scene.run(&["check", "a.json"]).code(0).says(&["valid, 1 warning"]);
}

const MESH: &str = r#""type": "Mesh", "file""#;
const PATCHES: &str = r#""type": "BezierModel", "model""#;

/// Checks that `check` tells of a model what `render` tells, in these words.
fn model_is_told(scene: &Scene, model: &str, name: &str, words: &str) {
    let document = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "nodes": {
        "camera": { "type": "Camera", "position": [0, 1, 5], "target": [0, 0, 0] }, "model": { MODEL: "NAME" },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["model"] },
        "depth": { "type": "Depth", "view": "view" } }, "outputs": { "depth": { "field": "depth" } } }"##;
    fs::write(scene.path("a.json"), document.replace("MODEL", model).replace("NAME", name)).unwrap();
    let rendered = scene.run(&["render", "a.json"]).code(1);
    let checked = scene.run(&["check", "a.json"]).code(2);
    assert_eq!(errors(&checked), errors(&rendered));
    assert!(checked.err.contains(words), "{words}: {}", checked.err);
}

#[cfg(unix)]
#[test]
fn models_that_are_no_files_are_told_too() {
    let scene = Scene::new("");
    for (model, name) in [(MESH, "pipe.obj"), (PATCHES, "pipe.json")] {
        assert!(std::process::Command::new("mkfifo").arg(scene.path(name)).status().unwrap().success());
        model_is_told(&scene, model, name, "found a pipe, expected a file");
    }
}

#[test]
fn faults_within_models_are_told_too() {
    let scene = Scene::new("");
    for (model, name, bytes, words) in [
        (MESH, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "m.obj: "),
        (PATCHES, "m.json", r#"{ "points": [[0, 0, 0]], "patches": [] }"#, "expected \"trochoid_model\": 1"),
        (PATCHES, "n.json", r#"{ "trochoid_model": 1, "points": [], "patches": [[0, 0, 7, 0]] }"#, "names point 0"),
    ] {
        fs::write(scene.path(name), bytes).unwrap();
        model_is_told(&scene, model, name, words);
    }
}

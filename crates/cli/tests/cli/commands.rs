//! `trochoid check`, `nodes`, `schema`, `info`, and help.

use crate::scene::{READS, SCENE, Scene, with_unused};
use serde_json::Value;

#[test]
fn check_tells_guarantees_and_what_is_left_out() {
    let scene = Scene::new(&with_unused());
    let run = scene.run(&["check", "a.json"]).code(0).says(&[
        "a.json: valid, 1 warning",
        "beauty  Color: hull (required: hull) → out/beauty.####.exr",
        "lost: no requested output needs it",
    ]);
    assert!(run.err.contains("warning: a.json:3:14: node \"lost\""), "{}", run.err);
    let run = scene.run(&["check", "a.json", "--strict"]).code(2);
    assert!(run.err.contains("found 1 warning"), "{}", run.err);
    let json = scene.run(&["check", "a.json", "--json"]).code(0).json();
    assert_eq!(json["outputs"]["beauty"]["guarantee"], "hull");
    assert_eq!(json["outputs"]["mask"]["guarantee"], Value::Null);
    assert_eq!(json["left_out"]["lost"], "no requested output needs it");
    assert_eq!(json["diagnostics"][0]["severity"], "warning");
    assert_eq!(scene.run(&["check", "a.json", "--strict", "--json"]).code(2).json()["valid"], false);
    scene.has_no_files();
}

#[test]
fn check_warns_of_files_that_are_not_there() {
    let scene = Scene::new(READS);
    let run = scene.run(&["check", "a.json"]).code(0);
    assert!(
        run.err.contains("warning: a.json:2:46: node \"in\", file: found no file in.exr at frame 1"),
        "{}",
        run.err
    );
    scene.run(&["check", "a.json", "--strict"]).code(2);
    scene.write_picture("in.exr", 0.5);
    assert_eq!(scene.run(&["check", "a.json", "--strict"]).code(0).err, "");
}

#[test]
fn trees_and_previews_tell_their_file() {
    let scene = Scene::new(SCENE);
    scene.run(&["graph", "a.json", "-o", "tree.svg"]).code(0).says(&["graph of a.json → tree.svg\n"]);
    scene.run(&["graph", "a.json", "-o", "-"]).code(0).says(&["<svg"]);
    let preview = |more: &[&str]| scene.run(&[&["preview", "a.json", "--output", "beauty"], more].concat()).code(0);
    preview(&["-o", "all.webp"]).says(&["3 frames: beauty → all.webp  8 × 4 pixels\n"]);
    preview(&["-o", "one.png", "--frames", "2"]).says(&["frame 2: beauty → one.png"]);
    assert_eq!(preview(&["-o", "one.png", "--frames", "2", "--quiet"]).out, "");
    assert_eq!(scene.files(), ["all.webp", "one.png", "tree.svg"]);
}

#[test]
fn check_refuses_names_that_render_would_refuse() {
    let scene = Scene::new(&SCENE.replace("mask.####.png", "mask.png"));
    scene.run(&["check", "a.json"]).fails(2, &["gives all frames one name"]);
    assert_eq!(scene.run(&["check", "a.json", "--json"]).code(2).json()["valid"], false);
}

#[test]
fn check_tells_which_branch_a_weight_cuts_off() {
    let both = SCENE.replace("\"a\": \"#000\"", "\"a\": \"dark\"").replace(
        "\"across\": {",
        "\"down\": { \"type\": \"ScreenY\" }, \"dark\": { \"type\": \"Mix\", \"a\": \"#100\", \"b\": \"#001\", \"weight\": \"down\" }, \"across\": {",
    );
    let scene = Scene::new(&both);
    assert!(!scene.run(&["check", "a.json"]).code(0).out.contains("Left out"));
    let run = scene.run(&["check", "a.json", "--set", "mix.weight=1"]).code(0);
    run.says(&["Left out at frame 1", "dark: its weight at \"mix\" is proved"]);
}

#[test]
fn nodes_and_schema_come_from_the_declarations() {
    let scene = Scene::new(SCENE);
    scene.run(&["nodes"]).code(0).says(&["Mix", "ScreenX", "Front end", "Back end"]);
    let manual = scene.run(&["nodes", "Mix"]).code(0).says(&[
        "What it does\n  Mixes two colors by a mask.",
        "Formula\n  (1 − t)·a + t·b",
        "Edge cases",
        "Source",
        "weight: mask",
    ]);
    assert_eq!(scene.run(&["nodes", "mix"]).code(0).out, manual.out);
    let json = scene.run(&["nodes", "Ramp", "--json"]).code(0).json();
    assert_eq!(json["items"][1]["items"][0]["max"], 1.0);
    let all = scene.run(&["nodes", "--json"]).code(0).json();
    assert_eq!(all.as_array().unwrap().len(), trochoid::registry().iter().count());
    scene.run(&["nodes", "Mixx"]).fails(2, &["did you mean Mix?"]);
    scene.run(&["nodes", "Over"]).fails(2, &["not convex", "Stack for several layers"]);
    let schema = scene.run(&["schema"]).code(0).json();
    assert_eq!(schema["properties"]["trochoid"]["const"], 1);
}

#[test]
fn info_describes_what_render_wrote() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--frames", "1"]).code(0);
    scene.run(&["info", "out/beauty.0001.exr"]).code(0).says(&[
        "EXR, 1 part",
        "16 × 8 pixels",
        "R  half   min 0.000000  max 1.000000",
        "0 NaN",
        "trochoid:guarantee: beauty: hull, 0 outside",
    ]);
    let json = scene.run(&["info", "out/mask.0001.png", "--json"]).code(0).json();
    assert_eq!(json["kind"], "PNG");
    assert_eq!(json["parts"][0]["channels"][0]["max"], 1.0);
    assert_eq!(json["parts"][0]["data"]["x1"], 16);
}

#[test]
fn help_and_version_are_results() {
    let scene = Scene::new(SCENE);
    scene.run(&["--version"]).code(0).says(&["trochoid "]);
    let all: [&[&str]; 7] = [
        &["--help"],
        &["render", "--help"],
        &["check", "-h"],
        &["nodes", "--help"],
        &["info", "--help"],
        &["stability", "--help"],
        &["export", "--help"],
    ];
    for arguments in all {
        let run = scene.run(arguments).code(0).says(&["Usage: trochoid", "Examples:"]);
        assert_eq!(run.err, "");
        assert!(run.out.lines().all(|line| line.chars().count() <= 100), "{}", run.out);
    }
}

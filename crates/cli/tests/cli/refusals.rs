//! Refused commands: their exit codes and messages, and that they write nothing.
//!
//! The messages are stored in `crates/cli/tests/told/GROUP/NAME.txt`; `TROCHOID_UPDATE=1` stores them again.

use crate::scene::{READS, SCENE, Scene};
use crate::told::Told;
use serde_json::Value;
use std::fs;

#[test]
fn usage_is_code_2_and_writes_nothing() {
    let (scene, mut told) = (Scene::new(SCENE), Told::new("usage"));
    let cases: [(&str, &[&str]); 17] = [
        ("frames_that_are_none", &["--frames", "1-,3,x"]),
        ("frames_backward", &["--frames", "9-1"]),
        ("frames_without_end", &["--frames", "1-2000000"]),
        ("unknown_output", &["--output", "beuty"]),
        ("one_name_for_two_outputs", &["--out", "a.####.exr"]),
        ("one_name_for_all_frames", &["--out", "{output}.exr"]),
        ("unknown_ending", &["--out", "{output}.####.jpg"]),
        ("unknown_knob", &["--set", "mix.wieght=1"]),
        ("assignment_without_knob", &["--set", "mix=1"]),
        ("negative_threads", &["--threads", "-1"]),
        ("too_many_threads", &["--threads", "100000"]),
        ("unknown_guarantee", &["--require", "ball"]),
        ("quiet_json", &["--quiet", "--json"]),
        ("two_json", &["--json", "--report", "-"]),
        ("unknown_option", &["--nonsense"]),
        ("report_over_document", &["--report", "a.json"]),
        ("three_at_once", &["--frames", "x", "--output", "y", "--out", "z.jpg"]),
    ];
    for (name, arguments) in cases {
        told.is(name, 2, &scene, &[&["render", "a.json"], arguments].concat());
    }
    told.is("no_graph", 2, &scene, &["render"]);
    told.is("unknown_command", 2, &scene, &["rendr", "a.json"]);
    told.ends();
    scene.run(&[]).code(2);
    scene.has_no_files();
}

#[test]
fn invalid_documents_are_code_2_and_write_nothing() {
    let plus = r#"{ "trochoid": 1, "nodes": { "a": { "type": "Plus" } } }"#;
    let cyclic = SCENE.replace(
        "\"weight\": \"across\" }",
        "\"weight\": \"across\" }, \"me\": { \"type\": \"Invert\", \"weight\": \"me\" }",
    );
    let mask = SCENE.replace("\"color\": \"mix\"", "\"color\": \"across\"");
    let deep = format!("{{ \"notes\": {}", "[".repeat(100_000));
    let mut told = Told::new("documents");
    for (name, document) in [("empty", ""), ("plus", plus), ("loop", &cyclic), ("mask", &mask), ("deep", &deep)] {
        let scene = Scene::new(document);
        told.is(name, 2, &scene, &["render", "a.json", "--report", "r.json"]);
        told.is(&format!("{name}_checked"), 2, &scene, &["check", "a.json"]);
        let json = scene.run(&["check", "a.json", "--json"]).code(2);
        assert_eq!(json.err, "");
        assert_eq!(json.json()["valid"], false);
        assert!(json.json()["diagnostics"][0]["remedy"].is_string());
        scene.has_no_files();
    }
    let scene = Scene::new("");
    fs::write(scene.path("a.json"), b"{ \"notes\":\n \"caf\xe9\" }").unwrap();
    told.is("no_text", 2, &scene, &["render", "a.json"]);
    scene.write_picture("in.exr", 0.5);
    told.is("picture", 2, &scene, &["render", "in.exr"]);
    told.is("picture_blamed", 2, &scene, &["blame", "in.exr", "--at", "0,0"]);
    told.ends();
}

#[test]
fn input_output_and_bad_data_are_code_1() {
    let (scene, mut told) = (Scene::new(READS), Told::new("data"));
    told.is("no_document", 1, &scene, &["render", "none.json"]);
    told.is("folder_for_document", 1, &scene, &["render", "."]);
    told.is("no_picture", 1, &scene, &["render", "a.json"]);
    told.is("no_picture_of_info", 1, &scene, &["info", "none.exr"]);
    told.is("document_for_picture", 1, &scene, &["info", "a.json"]);
    scene.has_no_files();
    scene.write_picture("in.exr", -0.5);
    told.is("negative_color", 1, &scene, &["render", "a.json"]);
    fs::write(scene.path("in.exr"), b"GIF89a").unwrap();
    told.is("gif", 1, &scene, &["render", "a.json"]);
    fs::write(scene.path("in.exr"), b"v/1\x01 no picture at all").unwrap();
    told.is("damaged", 1, &scene, &["render", "a.json"]);
    assert_eq!(scene.files(), ["in.exr"]);
    fs::write(scene.path("x.webp"), b"RIFF\x10\0\0\0WEBPVP8 ").unwrap();
    told.is("webp", 1, &scene, &["info", "x.webp"]);
    scene.write_picture("in.exr", 0.5);
    told.is("unknown_channels", 1, &scene, &["render", "a.json", "--set", "in.channels=[\"X\",\"Y\",\"Z\"]"]);
    told.ends();
}

#[test]
fn pictures_beyond_memory_are_refused_with_their_place() {
    let scene = Scene::new(&SCENE.replace("\"width\": 16, \"height\": 8", "\"width\": 40000, \"height\": 40000"));
    let mut told = Told::new("memory");
    // The number of threads must not depend on the machine.
    told.is("render", 1, &scene, &["render", "a.json", "--frames", "1", "--memory", "8GB", "--threads", "1"]);
    let checked = scene.run(&["check", "a.json", "--memory", "8GB"]);
    told.stands("check", 2, &checked, &scene);
    told.ends();
    scene.has_no_files();
}

#[test]
fn all_faults_of_a_pattern_are_reported_at_once() {
    let fields = SCENE
        .replace("\"across\": {", "\"f\": { \"type\": \"FieldMath\", \"expression\": \"2\" }, \"across\": {")
        .replace("\"outputs\": {", "\"outputs\": { \"x\": { \"field\": \"f\" }, \"y\": { \"field\": \"f\" },");
    let mut told = Told::new("outputs");
    told.is("pattern", 2, &Scene::new(&fields), &["render", "a.json", "--out", "{output}.png"]);
    told.ends();
    let shared = SCENE
        .replace("out/mask.####.png", "m.png")
        .replace("\"mask\": {", "\"other\": { \"weights\": \"across\", \"file\": \"m.png\" }, \"mask\": {");
    let json = Scene::new(&shared).run(&["check", "a.json", "--json"]).code(2).json();
    let found: Vec<&Value> = json["diagnostics"].as_array().unwrap().iter().map(|fault| &fault["found"]).collect();
    assert_eq!(found.len(), 3, "{json:#}");
    assert_eq!(found.iter().filter(|found| found.as_str().unwrap().contains("gives all frames one name")).count(), 2);
}

#[test]
fn outputs_that_cannot_be_written_are_refused_and_leave_no_files() {
    let (scene, mut told) = (Scene::new(SCENE), Told::new("places"));
    told.is("beneath_a_file", 1, &scene, &["render", "a.json", "--out", "a.json/{output}.####.exr"]);
    fs::create_dir_all(scene.path("out/mask.0003.png")).unwrap();
    told.is("a_folder", 1, &scene, &["render", "a.json"]);
    told.is("a_folder_for_the_report", 1, &scene, &["render", "a.json", "--frames", "1", "--report", "out"]);
    scene.has_no_files();
    let reads = Scene::new(READS);
    reads.write_picture("in.exr", 0.5);
    told.is("over_its_input", 2, &reads, &["render", "a.json", "--out", "in.exr"]);
    let bright = Scene::new(&SCENE.replace("\"#fff\"", "[1e6, 1e6, 1e6]"));
    told.is("beyond_half", 1, &bright, &["render", "a.json", "--frames", "1", "--output", "beauty"]);
    bright.has_no_files();
    told.ends();
}

#[test]
fn messages_name_what_is_meant() {
    let mut told = Told::new("names");
    let named = SCENE.replace("\"across\": {", "\"štorm 海\": { \"type\": \"ScreenY\" }, \"across\": {");
    told.is("letters", 2, &Scene::new(&named), &["check", "a.json"]);
    let sea = r#"{ "trochoid": 1, "format": { "width": 8, "height": 4 }, "nodes": { "storm": { "type": "GerstnerSea" },
        "height": { "type": "Height", "surface": "storm" } }, "outputs": { "h": { "field": "height" } } }"#;
    let sea = Scene::new(sea);
    for (name, value) in [
        ("place_in_a_list", r#"[{"amplitude":1,"wavelength":20},{"amplitude":1,"wavelength":0}]"#),
        ("key_in_a_list", r#"[{"wavelenght": 1}]"#),
        ("no_list", "1"),
    ] {
        told.is(name, 2, &sea, &["check", "a.json", "--set", &format!("storm.waves={value}")]);
    }
    let long = READS.replace("\"nodes\"", "\"frames\": { \"first\": 0, \"last\": 20000 }, \"nodes\"");
    let long = Scene::new(&long.replace("in.exr", "in.#####.exr").replace("out.exr", "out.#####.exr"));
    told.stands("many_frames", 0, &long.run(&["check", "a.json"]), &long);
    told.ends();
}

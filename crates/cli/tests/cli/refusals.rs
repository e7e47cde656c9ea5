//! What is refused, with which exit code; and that nothing is written then.

use crate::scene::{READS, SCENE, Scene};
use serde_json::Value;
use std::fs;

#[test]
fn usage_is_code_2_and_writes_nothing() {
    let scene = Scene::new(SCENE);
    let render = |more: &[&str]| scene.run(&[&["render", "a.json"], more].concat());
    let cases: [(&[&str], &[&str]); 17] = [
        (&["--frames", "1-,3,x"], &["found \"1-\"", "found \"x\""]),
        (&["--frames", "9-1"], &["\"9-1\"", "1-9"]),
        (&["--frames", "1-2000000"], &["1-2000000", "at most 1000000"]),
        (&["--output", "beuty"], &["found \"beuty\"", "did you mean beauty?"]),
        (&["--out", "a.####.exr"], &["gives 2 outputs one name", "{output}"]),
        (&["--out", "{output}.exr"], &["gives all frames one name", "####"]),
        (&["--out", "{output}.####.jpg"], &["ending that cannot be written"]),
        (&["--set", "mix.wieght=1"], &["unknown key \"wieght\"", "did you mean \"weight\"?"]),
        (&["--set", "mix=1"], &["NODE.KNOB=VALUE"]),
        (&["--threads", "-1"], &["-1"]),
        (&["--threads", "100000"], &["--threads"]),
        (&["--require", "ball"], &["ball", "hull, box"]),
        (&["--quiet", "--json"], &["--quiet", "--json"]),
        (&["--json", "--report", "-"], &["both write JSON on stdout"]),
        (&["--nonsense"], &["--nonsense"]),
        (&["--report", "a.json"], &["is a file of the document"]),
        (&["--frames", "x", "--output", "y", "--out", "z.jpg"], &["\"x\"", "\"y\"", "z.jpg"]),
    ];
    for (arguments, words) in cases {
        render(arguments).fails(2, words);
    }
    scene.run(&[]).code(2);
    scene.run(&["render"]).fails(2, &["<GRAPH>"]);
    scene.run(&["rendr", "a.json"]).fails(2, &["rendr"]);
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
    let cases: [(&str, &[&str]); 5] = [
        ("", &["a.json:1:1", "an empty file", "write a document"]),
        (plus, &["the operation Plus", "no \"format\"", "no \"outputs\"", "\n  remedy: "]),
        (&cyclic, &["the loop me ← me"]),
        (&mask, &["a.json:5:37: beauty", "a mask"]),
        (&deep, &["a.json:1:"]),
    ];
    for (document, words) in cases {
        let scene = Scene::new(document);
        scene.run(&["render", "a.json", "--report", "r.json"]).fails(2, words);
        scene.run(&["check", "a.json"]).fails(2, words);
        let json = scene.run(&["check", "a.json", "--json"]).code(2);
        assert_eq!(json.err, "");
        assert_eq!(json.json()["valid"], false);
        assert!(json.json()["diagnostics"][0]["remedy"].is_string());
        scene.has_no_files();
    }
}

#[test]
fn a_document_that_is_no_text_is_code_2() {
    let scene = Scene::new("");
    fs::write(scene.path("a.json"), b"{ \"notes\":\n \"caf\xe9\" }").unwrap();
    scene.run(&["render", "a.json"]).fails(2, &["a.json:2:6", "0xe9", "UTF-8"]);
}

#[test]
fn input_output_and_bad_data_are_code_1() {
    let scene = Scene::new(READS);
    scene.run(&["render", "none.json"]).fails(1, &["none.json: cannot open the file"]);
    scene.run(&["render", "."]).fails(1, &["found a folder"]);
    scene
        .run(&["render", "a.json"])
        .fails(1, &["frame 1: a.json:2:46: node \"in\" (Read)", "in.exr", "correct the path"]);
    scene.run(&["info", "none.exr"]).fails(1, &["none.exr"]);
    scene.run(&["info", "a.json"]).fails(1, &["a.json", "found JSON", "expected EXR, PNG, JPEG or TIFF"]);
    scene.has_no_files();
    scene.write_picture("in.exr", -0.5);
    scene.run(&["render", "a.json"]).fails(1, &["-0.5"]);
    fs::write(scene.path("in.exr"), b"GIF89a").unwrap();
    scene.run(&["render", "a.json"]).fails(1, &["in.exr: found a GIF picture", "convert it"]);
    fs::write(scene.path("in.exr"), b"v/1\x01 no picture at all").unwrap();
    scene.run(&["render", "a.json"]).fails(1, &["in.exr"]);
    assert_eq!(scene.files(), ["in.exr"]);
}

#[test]
fn pictures_beyond_memory_are_refused_by_their_place() {
    let scene = Scene::new(&SCENE.replace("\"width\": 16, \"height\": 8", "\"width\": 40000, \"height\": 40000"));
    let words = [
        "a.json:2:13: found a frame that takes about 68.8 GB: writing pictures 43.2 GB, pictures 25.6 GB",
        "lower the format's",
    ];
    scene.run(&["render", "a.json", "--frames", "1", "--memory", "8GB"]).fails(1, &words);
    let checked = scene.run(&["check", "a.json", "--memory", "8GB"]).code(2);
    assert!(words.iter().all(|word| checked.err.contains(word)), "{}", checked.err);
    scene.has_no_files();
}

#[test]
fn all_that_is_wrong_with_a_pattern_is_told_at_once() {
    let fields = SCENE
        .replace("\"across\": {", "\"f\": { \"type\": \"FieldMath\", \"expression\": \"2\" }, \"across\": {")
        .replace("\"outputs\": {", "\"outputs\": { \"x\": { \"field\": \"f\" }, \"y\": { \"field\": \"f\" },");
    let scene = Scene::new(&fields);
    let run = scene.run(&["render", "a.json", "--out", "{output}.png"]).code(2);
    for words in ["\"{output}.png\" gives all frames one name", "output \"x\" is a Field", "output \"y\" is a Field"] {
        assert_eq!(run.err.matches(words).count(), 1, "{}", run.err);
    }
    assert_eq!(run.err.matches("error: ").count(), 3, "{}", run.err);
    let shared = SCENE
        .replace("out/mask.####.png", "m.png")
        .replace("\"mask\": {", "\"other\": { \"weights\": \"across\", \"file\": \"m.png\" }, \"mask\": {");
    let json = Scene::new(&shared).run(&["check", "a.json", "--json"]).code(2).json();
    let found: Vec<&Value> = json["diagnostics"].as_array().unwrap().iter().map(|fault| &fault["found"]).collect();
    assert_eq!(found.len(), 3, "{json:#}");
    assert_eq!(found.iter().filter(|found| found.as_str().unwrap().contains("gives all frames one name")).count(), 2);
}

#[test]
fn places_that_take_no_files_are_found_before_anything_is_evaluated() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--out", "a.json/{output}.####.exr"]).fails(1, &["is no folder"]);
    fs::create_dir_all(scene.path("out/mask.0003.png")).unwrap();
    scene.run(&["render", "a.json"]).fails(1, &["out/mask.0003.png", "is a folder"]);
    scene.run(&["render", "a.json", "--frames", "1", "--report", "out"]).fails(1, &["is a folder"]);
    scene.has_no_files();
    let reads = Scene::new(READS);
    reads.write_picture("in.exr", 0.5);
    reads.run(&["render", "a.json", "--out", "in.exr"]).fails(2, &["in.exr", "written over"]);
}

#[test]
fn values_that_half_cannot_hold_are_refused_and_leave_no_file() {
    let scene = Scene::new(&SCENE.replace("\"#fff\"", "[1e6, 1e6, 1e6]"));
    scene.run(&["render", "a.json", "--frames", "1", "--output", "beauty"]).fails(1, &["beauty.0001.exr"]);
    scene.has_no_files();
}

#[test]
fn messages_name_what_is_meant() {
    let named = Scene::new(&SCENE.replace("\"across\": {", "\"štorm 海\": { \"type\": \"ScreenY\" }, \"across\": {"));
    named.run(&["check", "a.json"]).fails(2, &["the name \"štorm 海\"; expected a–z, A–Z, 0–9 and _"]);
    let sea = r#"{ "trochoid": 1, "format": { "width": 8, "height": 4 }, "nodes": { "storm": { "type": "GerstnerSea" },
        "height": { "type": "Height", "surface": "storm" } }, "outputs": { "h": { "field": "height" } } }"#;
    let sea = Scene::new(sea);
    let set = |value: &str| sea.run(&["check", "a.json", "--set", &format!("storm.waves={value}")]);
    set(r#"[{"amplitude":1,"wavelength":20},{"amplitude":1,"wavelength":0}]"#)
        .fails(2, &["node \"storm\", waves[1].wavelength: found 0"]);
    set("[{\"wavelenght\": 1}]").fails(2, &["node \"storm\", waves[0]: ", "unknown key \"wavelenght\""]);
    set("1").fails(2, &["expected a list of records"]);
    let scene = Scene::new(READS);
    scene.write_picture("in.exr", 0.5);
    let layer = ["render", "a.json", "--set", "in.channels=[\"X\",\"Y\",\"Z\"]"];
    scene.run(&layer).fails(1, &["to try it by --set in.channels=…"]);
    fs::write(scene.path("x.webp"), b"RIFF\x10\0\0\0WEBPVP8 ").unwrap();
    scene.run(&["info", "x.webp"]).fails(1, &["found a WebP picture, expected EXR, PNG, JPEG or TIFF"]);
    let long = READS.replace("\"nodes\"", "\"frames\": { \"first\": 0, \"last\": 20000 }, \"nodes\"");
    let long = Scene::new(&long.replace("in.exr", "in.#####.exr").replace("out.exr", "out.#####.exr"));
    let words = ["in.00000.exr at frame 0, and none at 9999 more frames of the first 10000, which are looked at"];
    assert!(long.run(&["check", "a.json"]).err.contains(words[0]));
}

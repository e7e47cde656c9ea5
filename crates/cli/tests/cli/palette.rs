//! Colors with names: in the document, in files, and from the command line.

use crate::scene::Scene;
use serde_json::json;
use std::fs;

const NAMED: &str = r##"{ "trochoid": 1, "format": { "width": 8, "height": 4 },
  "palette": { "dark": "#101820", "light": { "keys": [[1, "#f0e0d0"], [3, "#a0b0c0"]] } },
  "nodes": { "across": { "type": "ScreenX" },
             "ramp": { "type": "Ramp", "weight": "across",
                       "stops": [{ "at": 0, "color": "palette.dark" }, { "at": 1, "color": "#abcdef" }] },
             "mix": { "type": "Mix", "a": "palette.dark", "b": "palette.light", "weight": "ramped" },
             "ramped": { "type": "Clamp", "field": "across", "min": 0.2, "max": 0.7 },
             "beauty": { "type": "Mix", "a": "mix", "b": "ramp", "weight": 0.25 } },
  "outputs": { "beauty": { "color": "beauty", "file": "a.png" } } }"##;

/// The same document with the colors where they belong.
fn literal() -> String {
    let (palette, light) = ("\"palette\": {", r##"{ "keys": [[1, "#f0e0d0"], [3, "#a0b0c0"]] }"##);
    let start = NAMED.find(palette).unwrap();
    let end = start + NAMED[start..].find("\n").unwrap();
    let without = format!("{}{}", &NAMED[..start], &NAMED[end..]);
    without.replace("\"palette.dark\"", "\"#101820\"").replace("\"palette.light\"", light)
}

/// Renders frame 2 and returns the picture's bytes without what is said of the document.
fn picture(scene: &Scene, arguments: &[&str]) -> Vec<u8> {
    scene.run(&[&["render", "--frames", "2", "--overwrite", "--out", "x.exr", "--quiet"], arguments].concat()).code(0);
    let image = trochoid::io::read(scene.path("x.exr"), &Default::default(), &Default::default()).unwrap();
    image.channels.iter().flat_map(|channel| channel.plane.samples().iter().flat_map(|v| v.to_le_bytes())).collect()
}

#[test]
fn names_stand_for_their_colors() {
    let scene = Scene::new(NAMED);
    fs::write(scene.path("literal.json"), literal()).unwrap();
    let expected = picture(&scene, &["literal.json"]);
    assert_eq!(picture(&scene, &["a.json"]), expected);
    // From a file, as JSON, as a document, and as a palette of GIMP.
    let start = NAMED.find("{ \"dark\"").unwrap();
    let colors = &NAMED[start..start + NAMED[start..].find(",\n").unwrap()];
    fs::write(scene.path("colors.json"), colors).unwrap();
    for file in ["colors.json", "a.json"] {
        fs::write(scene.path("filed.json"), NAMED.replace(colors, &format!("\"{file}\""))).unwrap();
        assert_eq!(picture(&scene, &["filed.json"]), expected, "{file}");
    }
}

#[test]
fn reports_and_diagrams_know_the_names() {
    let scene = Scene::new(NAMED);
    let run = scene.run(&["render", "a.json", "--frames", "1", "--report", "-"]).code(0);
    let colors = &run.json()["frames"][0]["outputs"]["beauty"]["control_colors"];
    assert_eq!((&colors["count"], &colors["images"]), (&json!(3), &json!([])));
    assert_eq!(colors["names"], json!(["dark", "light", "ramp.stops[1].color"]));
    assert_eq!(colors["values"].as_array().unwrap().len(), 3);
    // Colors count as the document has them, whatever constants they are folded to.
    let folded = NAMED.replace(r#""weight": "ramped""#, r#""weight": 0.5"#).replace("palette.light", "#f0e0d0");
    fs::write(scene.path("folded.json"), folded).unwrap();
    let run = scene.run(&["render", "folded.json", "--frames", "1", "--report", "-", "--overwrite"]).code(0);
    let colors = &run.json()["frames"][0]["outputs"]["beauty"]["control_colors"];
    assert_eq!(colors["names"], json!(["dark", "ramp.stops[1].color", "mix.b"]));
    scene.run(&["graph", "a.json", "--out", "a.svg"]).code(0);
    let drawn = fs::read_to_string(scene.path("a.svg")).unwrap();
    assert!(["dark", "light", "#101820"].iter().all(|word| drawn.contains(word)), "{drawn}");
}

#[test]
fn colors_are_changed_from_outside() {
    let scene = Scene::new(NAMED);
    let before = picture(&scene, &["a.json"]);
    fs::write(scene.path("night.json"), r##"{ "dark": "#000010" }"##).unwrap();
    fs::write(scene.path("night.gpl"), "GIMP Palette\nName: night\n  0   0  16\tdark\n").unwrap();
    let by_json = picture(&scene, &["a.json", "--palette", "night.json"]);
    assert_ne!(by_json, before);
    assert_eq!(picture(&scene, &["a.json", "--palette", "night.gpl"]), by_json);
    assert_eq!(picture(&scene, &["a.json", "--set", "palette.dark=#000010"]), by_json);
    // Single colors win over the file, in whatever order they are given.
    let one = ["a.json", "--set", "palette.dark=#101820", "--palette", "night.json"];
    assert_eq!(picture(&scene, &one), before);
    let stop = picture(&scene, &["a.json", "--set", "ramp.stops[1].color=#123456"]);
    assert_ne!(stop, before);
    assert_eq!(picture(&scene, &["a.json", "--set", "ramp.stops[1].color=#abcdef"]), before);
}

#[test]
fn files_that_do_not_fit_are_refused_with_their_places() {
    let scene = Scene::new(NAMED);
    let fails = |file: &str, text: &str, code: i32, words: &[&str]| {
        fs::write(scene.path(file), text).unwrap();
        scene.run(&["render", "a.json", "--palette", file]).fails(code, words);
    };
    fails("n.json", "{\n  \"drak\": \"#000\" }", 2, &["n.json:2:3: found drak", "did you mean \"dark\"?"]);
    fails("n.json", "{ \"dark\": \"#00\" }", 2, &["n.json:1:11: palette.dark: found \"#00\"; expected a color"]);
    fails("n.json", "[]", 2, &["n.json:1:1: found a list of 0; expected an object of colors by name"]);
    fails("n.gpl", "GIMP Palette\n1 2\n", 2, &["n.gpl:2:1: found the line \"1 2\""]);
    scene.run(&["render", "a.json", "--palette", "none.json"]).fails(1, &["none.json: cannot open the file"]);
    assert!(!scene.path("a.png").exists());
    // The file is an input, so nothing is written over it.
    fs::write(scene.path("night.exr"), r##"{ "dark": "#000010" }"##).unwrap();
    scene
        .run(&["render", "a.json", "--palette", "night.exr", "--out", "night.exr", "--overwrite"])
        .fails(2, &["night.exr: is an input of the document and would be overwritten"]);
}

#[test]
fn a_palette_is_read_only_where_the_document_may_read() {
    let scene = Scene::new("");
    for folder in ["shot", "other"] {
        fs::create_dir(scene.path(folder)).unwrap();
    }
    let start = NAMED.find("{ \"dark\"").unwrap();
    let colors = &NAMED[start..start + NAMED[start..].find(",\n").unwrap()];
    fs::write(scene.path("other/colors.json"), colors).unwrap();
    fs::write(scene.path("shot/a.json"), NAMED.replace(colors, "\"../other/colors.json\"")).unwrap();
    scene.run(&["check", "shot/a.json"]).code(0);
    let words = ["shot/a.json:2:14: palette: found the palette file", "expected a file that the document may reach"];
    scene.run(&["check", "shot/a.json", "--strict"]).fails(2, &words);
    scene.run(&["check", "shot/a.json", "--strict", "--allow", "other"]).code(0);
}

#[test]
fn certificates_hold_without_the_palette_file() {
    let scene = Scene::new(NAMED);
    fs::write(scene.path("night.json"), r##"{ "dark": "#000010" }"##).unwrap();
    let night = ["render", "a.json", "--palette", "night.json", "--frames", "1", "--certificate", "c.json"];
    scene.run(&night).code(0);
    fs::remove_file(scene.path("night.json")).unwrap();
    scene.run(&["verify", "c.json", "a.png", "--all"]).code(0);
    fs::write(scene.path("other.gpl"), "GIMP Palette\n0 0 16 dark\n").unwrap();
    let with = |palette: &str| scene.run(&["verify", "c.json", "a.png", "--document", "a.json", "--palette", palette]);
    with("other.gpl").code(0);
    scene.run(&["verify", "c.json", "a.png", "--document", "a.json"]).fails(3, &["a.json: hash of the document"]);
}

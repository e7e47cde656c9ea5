//! `trochoid check --explain`.

use crate::scene::{READS, Scene};

/// A sea that is hidden by a mask of a mask.
const HIDDEN: &str = r##"{ "trochoid": 1, "format": { "width": 96, "height": 54 }, "nodes": {
    "camera": { "type": "Camera" }, "storm": { "type": "GerstnerSea", "count": 40 },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["storm"] },
    "height": { "type": "Height", "view": "view" },
    "high": { "type": "Clamp", "field": "height", "max": 2 },
    "sea": { "type": "Mix", "a": "#123", "b": "#def", "weight": "high" },
    "across": { "type": "ScreenX" },
    "far": { "type": "Clamp", "field": "across", "min": 5, "max": 10 },
    "sky": { "type": "Mix", "a": "#ffe", "b": "#88a", "weight": "across" },
    "lost": { "type": "ScreenY" },
    "both": { "type": "Mix", "a": "sky", "b": "sea", "weight": "far" } },
  "outputs": { "beauty": { "color": "both" }, "height": { "field": "height" } } }"##;

#[test]
fn every_node_is_accounted_for_with_its_proof() {
    let scene = Scene::new(HIDDEN);
    let run = scene.run(&["check", "a.json", "--explain", "--output", "beauty"]).code(0).says(&[
        "beauty (Color) at frame 1",
        "Evaluated: 2 of 11 nodes",
        "Left out: its weight at \"both\" is proved 0 everywhere",
        "· \"far\" is 0: Clamp of \"across\"",
        "· \"across\" lies in [0, 1]: a ScreenX never leaves that",
        "storm   GerstnerSea",
        "Left out: no requested output needs it",
        "Nothing to compute: it passes \"sky\" through unchanged",
    ]);
    assert!(!run.out.contains("height (Field)") && !run.out.contains("Measured"), "{}", run.out);
    assert!(run.out.lines().all(|line| line.chars().count() <= 100), "{}", run.out);
    // All outputs: one needs what another leaves out.
    let run = scene.run(&["check", "a.json", "--explain"]).code(0);
    let run = run.says(&["height (Field) at frame 1", "view (Render): 1 of 25 computed", "of \"storm\", "]);
    assert!(run.out.contains("Left out within nodes, at 96 × 54 pixels"), "{}", run.out);
    scene.has_no_files();
}

#[test]
fn machines_get_the_same_as_json() {
    let scene = Scene::new(HIDDEN);
    let arguments = ["check", "a.json", "--explain", "--measure", "--frame", "3", "--json"];
    let json = scene.run(&arguments).code(0).json();
    let [beauty, height] = &json["explained"].as_array().unwrap()[..] else { panic!("two outputs: {json:#}") };
    assert_eq!((&beauty["output"], &beauty["kind"], &beauty["frame"]), (&"beauty".into(), &"Color".into(), &3.into()));
    let storm = &beauty["nodes"]["storm"];
    assert_eq!((&storm["type"], &storm["fate"]), (&"GerstnerSea".into(), &"left_out".into()));
    assert!(storm["why"].as_str().unwrap().contains("its weight at \"both\""), "{storm:#}");
    let proof = storm["proof"].as_array().unwrap();
    let step = |index: usize, key: &str| proof[index][key].clone();
    assert_eq!((step(0, "node"), step(0, "high")), ("far".into(), 0.0.into()));
    assert_eq!((step(1, "node"), step(1, "low"), step(1, "high")), ("across".into(), 0.0.into(), 1.0.into()));
    assert_eq!(beauty["nodes"]["sky"]["fate"], "evaluated");
    assert_eq!(beauty["nodes"]["both"]["fate"], "hands_on");
    // The sea takes no time if it is left out, and some time with nothing left out.
    assert!(storm["seconds"].is_null() && storm["seconds_in_full"].as_f64().unwrap() > 0.0, "{storm:#}");
    assert!(beauty["nodes"]["lost"]["seconds_in_full"].is_null());
    assert_eq!((&beauty["measured"]["width"], &beauty["measured"]["runs"]), (&96.into(), &3.into()));
    let view = &height["nodes"]["view"]["channels"][0];
    assert!(view["wanted"].as_array().unwrap().contains(&"Height".into()));
    assert!(view["unasked"].as_array().unwrap().contains(&"Jacobian".into()));
    assert_eq!(height["omissions"][0]["of"], "storm");
    assert_eq!(height["omissions"][0]["of_all"], 40.0);
    let text = scene.run(&["check", "a.json", "--explain", "--measure"]).code(0);
    text.says(&["Measured at 96 × 54 pixels, the least of 3 runs", " ms ≈", " —"]);
}

#[test]
fn planes_held_over_the_whole_picture_are_listed() {
    // Seen at this size, tiles would fill much of the noise again.
    let scene = Scene::new(
        r##"{ "trochoid": 1, "format": { "width": 900, "height": 600 }, "nodes": {
        "lace": { "type": "Noise", "scale": 0.1 }, "other": { "type": "Noise", "scale": 0.3 },
        "veil": { "type": "Noise", "scale": 0.2 }, "grain": { "type": "Noise", "scale": 0.05 },
        "sum": { "type": "FieldMath", "expression": "a + b + c + d", "a": "lace", "b": "other", "c": "veil", "d": "grain" },
        "foam": { "type": "Clamp", "field": "sum", "min": 0, "max": 0.3 },
        "water": { "type": "Mix", "a": "#123", "b": "#fff", "weight": "foam" },
        "shift": { "type": "ScreenX" },
        "far": { "type": "Warp", "image": "water", "dx": "shift", "reach": 60 } },
      "outputs": { "beauty": { "color": "far" } } }"##,
    );
    scene.run(&["check", "a.json", "--explain"]).code(0).says(&[
        "Filled over the whole picture first, since filters read far around tiles",
        "far: what it reads, 3 channels, 6.",
    ]);
    let json = scene.run(&["check", "a.json", "--explain", "--json"]).code(0).json();
    let held = &json["explained"][0]["held"];
    let one = held.as_array().unwrap().iter().find(|held| held["what"] == "inputs").unwrap();
    assert_eq!((&one["node"], &one["channels"], &one["bytes"]), (&"far".into(), &3.into(), &(900 * 600 * 12).into()));
    let hidden = Scene::new(HIDDEN).run(&["check", "a.json", "--explain", "--json"]).code(0).json();
    assert_eq!(hidden["explained"][0]["held"], serde_json::json!([]));
}

#[test]
fn what_is_unknown_is_reported_with_its_reason() {
    let scene = Scene::new(READS);
    // The file is missing: the results of planning are printed, with the reason that the rest is unknown.
    let run = scene.run(&["check", "a.json", "--explain", "--measure"]).code(0);
    run.says(&["Evaluated: 1 of 1 nodes", "is unknown", "Not measured", "in.exr"]);
    let json = scene.run(&["check", "a.json", "--explain", "--measure", "--json"]).code(0).json();
    assert!(json["explained"][0]["not_prepared"].as_str().unwrap().contains("in.exr"));
    assert!(json["explained"][0]["measured"]["error"].as_str().unwrap().contains("in.exr"));
    // The input has a fixed size, so the picture is measured at its own size.
    scene.write_picture("in.exr", 0.5);
    scene.run(&["check", "a.json", "--explain", "--measure"]).code(0).says(&["Measured at 4 × 2 pixels"]);
    scene.run(&["check", "a.json", "--explain", "--output", "beaty"]).fails(2, &["did you mean beauty?"]);
    scene.run(&["check", "a.json", "--measure"]).fails(2, &["--explain"]);
}

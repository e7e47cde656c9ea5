//! Warnings: after errors, and only about what is asked for.

use crate::scene::{Scene, with_unused};

#[test]
fn only_what_is_asked_for_is_warned_of() {
    let scene = Scene::new(&with_unused());
    let warned = |arguments: &[&str]| scene.run(arguments).code(0).err;
    let lost = "\"lost\": found a node that no output needs";
    assert!(warned(&["render", "a.json", "--frames", "1"]).contains(lost));
    assert!(warned(&["check", "a.json"]).contains(lost));
    assert_eq!(warned(&["render", "a.json", "--frames", "1", "--output", "beauty"]), "");
    assert_eq!(warned(&["render", "a.json", "--frames", "1", "--view", "across", "--out", "x.exr"]), "");
    assert_eq!(warned(&["preview", "a.json", "--frames", "1", "-o", "x.png"]), "");
    assert_eq!(warned(&["blame", "a.json", "--at", "1,1"]), "");
}

#[test]
fn warnings_about_nodes_that_feed_an_output_stay() {
    // A Mix of two equal colors, and one in a node that nothing needs.
    let document = r##"{ "trochoid": 1, "format": { "width": 16, "height": 8 },
      "palette": { "spare": "#123456" },
      "nodes": { "across": { "type": "ScreenX" }, "values": { "type": "FieldMath", "a": "across", "expression": "a" },
                 "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "across" } },
      "outputs": { "beauty": { "color": "mix" }, "v": { "field": "values", "file": "v.exr", "precision": "half" } } }"##;
    let scene = Scene::new(document);
    let warned = |output: &str| {
        scene.run(&["render", "a.json", "--output", output, "--out", "x.exr", "--overwrite"]).code(0).err
    };
    assert_eq!(warned("beauty"), "");
    let half = warned("v");
    assert!(half.contains("precision half") && !half.contains("spare"), "{half}");
    let all = scene.run(&["check", "a.json"]).code(0).err;
    assert!(all.contains("precision half") && all.contains("spare"), "{all}");
}

#[test]
fn errors_come_first() {
    let scene = Scene::new(&with_unused());
    for more in [&["--frames", "x"][..], &["--out", "x.jpg"]] {
        let run = scene.run(&[&["render", "a.json"], more].concat()).code(2);
        let [error, warning] = ["error: ", "warning: "].map(|word| run.err.find(word).unwrap());
        assert!(run.err.starts_with("error: ") && error < warning, "{}", run.err);
    }
    // Warnings of an invalid document, whatever stands before them in its text.
    let document = r##"{ "trochoid": 1, "format": { "width": 16, "height": 8 },
      "nodes": { "across": { "type": "ScreenX" }, "values": { "type": "FieldMath", "a": "across", "expression": "a" } },
      "outputs": { "v": { "field": "values", "file": "v.exr", "precision": "half" }, "w": { "color": "across" } } }"##;
    for command in ["render", "check"] {
        let run = Scene::new(document).run(&[command, "a.json"]).code(2);
        assert!(run.err.starts_with("error: ") && run.err.contains("\nwarning: "), "{}", run.err);
    }
}

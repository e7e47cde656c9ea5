//! Files that may be overwritten.

use crate::scene::{READS, SCENE, Scene};
use std::fs;

/// Commands, and a file that each writes.
const WRITERS: [(&[&str], &str); 13] = [
    (&["render", "a.json"], "out/beauty.0002.exr"),
    (&["render", "a.json"], "out/mask.0003.png"),
    (&["render", "a.json", "--report", "r.json"], "r.json"),
    (&["render", "a.json", "--certificate", "c.{output}.##.json"], "c.beauty.02.json"),
    (&["render", "a.json", "--error", "e.{output}.##.exr"], "e.mask.01.exr"),
    (&["preview", "a.json", "-o", "p.webp"], "p.webp"),
    (&["preview", "a.json", "--frames", "1", "-o", "one.webp"], "one.webp"),
    (&["preview", "a.json", "--frames", "1", "-o", "p.png"], "p.png"),
    (&["plan", "a.json", "--tolerance", "1/8", "-o", "p.json"], "p.json"),
    (&["graph", "a.json", "-o", "g.svg"], "g.svg"),
    (&["export", "a.json", "--to", "glsl", "--bind", "across", "-o", "g.glsl"], "g.glsl"),
    (&["export", "a.json", "--to", "materialx", "--bind", "across", "-o", "g.mtlx"], "g.mtlx"),
    (&["stability", "sea.json", "-o", "m.png"], "m.png"),
];

/// A sea whose stability is known soon.
const SEA: &str = r#"{ "trochoid": 1, "format": { "width": 4, "height": 2 },
  "nodes": { "sea": { "type": "ToonSea", "columns": 8, "rows": 8, "bursts": [ { "path": [0, 0, 1, 0, 1, 1, 0, 1] } ] },
             "bake": { "type": "Bake", "sea": "sea", "width": 4, "depth": 4 } },
  "outputs": { "height": { "field": "bake.height", "file": "height.exr" } } }"#;

#[test]
fn files_of_others_stay_and_our_own_are_replaced() {
    let scene = Scene::new(SCENE);
    fs::write(scene.path("sea.json"), SEA).unwrap();
    fs::create_dir(scene.path("out")).unwrap();
    for (command, name) in WRITERS {
        fs::write(scene.path(name), "theirs").unwrap();
        let before = scene.files();
        scene.run(command).fails(2, &[name, "does not bear Trochoid's mark", "remedy: ", "--overwrite"]);
        assert_eq!((scene.files(), fs::read(scene.path(name)).unwrap()), (before, b"theirs".to_vec()), "{command:?}");
        scene.run(&[command, &["--overwrite"]].concat()).code(0);
        assert_ne!(fs::read(scene.path(name)).unwrap(), b"theirs", "{command:?}");
        // The file that was written now is recognized by its mark.
        scene.run(command).code(0);
    }
}

#[test]
fn reports_know_their_files() {
    let scene = Scene::new(SCENE);
    let report =
        |more: &[&str]| scene.run(&[&["report", "a.json", "-o", "d", "--size", "8", "--pixels", "1"], more].concat());
    report(&[]).code(0);
    report(&[]).code(0);
    for name in ["report.html", "report.json", "report.csv"] {
        let ours = fs::read(scene.path("d").join(name)).unwrap();
        fs::write(scene.path("d").join(name), "theirs").unwrap();
        report(&[]).fails(2, &[name, "--overwrite"]);
        fs::write(scene.path("d").join(name), ours).unwrap();
    }
}

#[test]
fn documents_are_not_overwritten_by_plans_and_reports() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--out", "x.{output}.##.png", "--output", "beauty"]).code(0);
    // Documents are files of users, whatever their names are.
    fs::copy(scene.path("a.json"), scene.path("b.json")).unwrap();
    scene.run(&["plan", "a.json", "--tolerance", "1/8", "-o", "b.json"]).fails(2, &["b.json", "--overwrite"]);
    scene.run(&["render", "a.json", "--report", "b.json"]).fails(2, &["b.json", "--overwrite"]);
    scene.run(&["render", "a.json", "--report", "/dev/null"]).code(0);
}

#[test]
fn no_input_is_overwritten_by_any_run() {
    let scene = Scene::new(
        &READS
            .replace("\"in.exr\"", "\"seq.####.exr\"")
            .replace("\"outputs\": {", "\"outputs\": { \"ramp\": { \"color\": \"mix\" },")
            .replace("\"in\": {", "\"x\": { \"type\": \"ScreenX\" }, \"mix\": { \"type\": \"Mix\", \"a\": \"#000\", \"b\": \"#fff\", \"weight\": \"x\" }, \"in\": {"),
    );
    scene.write_picture("seq.0001.exr", 0.1);
    scene.write_picture("seq.0002.exr", 0.2);
    let is_input = ["is an input of the document", "give the output another name"];
    let ramp = |frames: &str, out: &str| {
        scene.run(&["render", "a.json", "--output", "ramp", "--frames", frames, "--out", out, "--overwrite"])
    };
    // Inputs of another output, of another frame, that do not exist yet; and the document.
    for (frames, out) in [("1", "seq.0002.exr"), ("2", "seq.####.exr"), ("7", "seq.####.exr"), ("1", "seq.9999999.exr")]
    {
        ramp(frames, out).fails(2, &is_input);
    }
    ramp("-1", "seq.####.exr").fails(2, &is_input);
    ramp("1", "seq.-0002.exr").fails(2, &is_input);
    ramp("1", "seq.00002.exr").code(0);
    scene
        .run(&["render", "a.json", "--output", "beauty", "--frames", "1", "--out", "seq.0002.exr", "--overwrite"])
        .fails(2, &is_input);
    scene.run(&["graph", "a.json", "-o", "a.json", "--overwrite"]).fails(2, &is_input);
    scene.run(&["preview", "a.json", "--output", "ramp", "--frames", "1", "-o", "a.json", "--overwrite"]).code(2);
    #[cfg(unix)]
    {
        fs::hard_link(scene.path("seq.0002.exr"), scene.path("hard.exr")).unwrap();
        std::os::unix::fs::symlink("seq.0002.exr", scene.path("soft.exr")).unwrap();
        fs::hard_link(scene.path("a.json"), scene.path("hard.json")).unwrap();
        ramp("1", "hard.exr").fails(2, &is_input);
        ramp("1", "soft.exr").fails(2, &is_input);
        scene
            .run(&["render", "a.json", "--output", "ramp", "--frames", "1", "--report", "hard.json", "--overwrite"])
            .fails(2, &["--report hard.json"]);
    }
    ramp("1", "free.exr").code(0);
}

#[test]
fn an_input_that_set_replaces_is_still_an_input() {
    let scene = Scene::new(READS);
    scene.write_picture("in.exr", 0.1);
    scene.write_picture("other.exr", 0.2);
    let is_input = ["is an input of the document", "give the output another name"];
    let set = ["--set", "in.file=other.exr", "--overwrite"];
    scene.run(&[&["render", "a.json", "--out", "in.exr"], &set[..]].concat()).fails(2, &is_input);
    scene.run(&[&["render", "a.json", "--out", "other.exr"], &set[..]].concat()).fails(2, &is_input);
    // `check` reports the fault of the document itself.
    fs::write(scene.path("a.json"), READS.replace("\"out.exr\"", "\"./in.exr\"")).unwrap();
    scene.run(&["check", "a.json"]).fails(2, &is_input);
    scene.run(&["render", "a.json", "--overwrite"]).fails(2, &is_input);
}

#[test]
fn an_output_in_a_file_is_not_lost_to_another_with_its_channels() {
    let both = READS.replace(
        "\"outputs\": {",
        "\"outputs\": { \"again\": { \"color\": \"in\", \"file\": \"out.exr\", \"layer\": \"\" },",
    );
    let scene = Scene::new(&both);
    scene.write_picture("in.exr", 0.1);
    scene.run(&["render", "a.json", "--output", "beauty"]).code(0);
    scene.run(&["render", "a.json", "--output", "again"]).fails(2, &["found the output beauty in it"]);
    scene.run(&["render", "a.json"]).code(0);
    scene.run(&["render", "a.json", "--output", "again"]).fails(2, &["found the output beauty in it"]);
}

#[test]
fn frames_are_not_replaced_by_previews_and_maps_unasked() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--output", "beauty", "--frames", "1", "--out", "x.png"]).code(0);
    scene.run(&["render", "a.json", "--output", "beauty", "--frames", "1", "--out", "x.exr"]).code(0);
    let another = ["of another kind", "--overwrite"];
    scene.run(&["preview", "a.json", "--frames", "1", "-o", "x.png"]).fails(2, &another);
    scene.run(&["stability", "-o", "x.png"]).fails(2, &another);
    let error = ["render", "a.json", "--output", "beauty", "--frames", "1", "--out", "y.exr", "--error", "x.exr"];
    scene.run(&error).fails(2, &another);
}

#[test]
fn a_name_that_is_too_long_fails_before_anything_is_rendered() {
    let scene = Scene::new(SCENE);
    let pattern = format!("{}{{output}}.#.exr", "n".repeat(243 - "beauty".len()));
    scene.run(&["render", "a.json", "--output", "beauty", "--frames", "1,99999", "--out", &pattern]).code(0);
    fs::remove_file(scene.path(&pattern.replace("{output}.#", "beauty.1"))).unwrap();
    fs::remove_file(scene.path(&pattern.replace("{output}.#", "beauty.99999"))).unwrap();
    // This name is short enough at the first frame, but not at the second.
    let long = pattern.replace('#', "######");
    scene
        .run(&["render", "a.json", "--output", "beauty", "--frames", "1,9999999", "--out", &format!("n{long}")])
        .fails(1, &["give a shorter one"]);
    scene.has_no_files();
}

#[test]
fn one_file_made_again_is_the_file_of_the_whole_run() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    let names = scene.files();
    let whole: Vec<Vec<u8>> = names.iter().map(|name| fs::read(scene.path(name)).unwrap()).collect();
    for name in &names {
        fs::remove_file(scene.path(name)).unwrap();
        scene.run(&["render", "a.json", "--resume"]).code(0);
        for (name, whole) in names.iter().zip(&whole) {
            assert!(fs::read(scene.path(name)).unwrap() == *whole, "{name}");
        }
    }
    scene.run(&["render", "a.json", "--output", "mask"]).code(0);
    assert!(fs::read(scene.path("out/mask.0002.png")).unwrap() == whole[4], "the same without other outputs");
    let resumed = scene.run(&["render", "a.json", "--resume", "--unoptimized", "--frames", "1"]).code(0).out;
    assert!(!resumed.contains("up to date"), "its metadata name another plan: {resumed}");
}

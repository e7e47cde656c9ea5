//! `trochoid render`.

use crate::scene::{READS, SCENE, Scene};
use serde_json::Value;
use std::fs;

#[test]
fn every_frame_is_written_and_has_one_line() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&["render", "a.json"]).code(0);
    assert_eq!(run.err, "", "no progress bar in a pipe");
    let lines: Vec<&str> = run.out.lines().collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[1].starts_with("frame 2: beauty → out/beauty.0002.exr, mask → out/mask.0002.png  hull, 0 outside, "));
    let names = [1, 2, 3].iter().flat_map(|n| [format!("out/beauty.000{n}.exr"), format!("out/mask.000{n}.png")]);
    let mut names: Vec<String> = names.collect();
    names.sort();
    assert_eq!(scene.files(), names);
}

#[test]
fn frames_outputs_and_pattern_are_chosen() {
    let scene = Scene::new(SCENE);
    let chosen = ["render", "a.json", "--frames", "-2--1,5-9x2,5", "--output", "mask", "--out", "m.##.exr"];
    let run = scene.run(&chosen).code(0);
    assert_eq!(run.out.lines().count(), 5);
    assert_eq!(scene.files(), ["m.-01.exr", "m.-02.exr", "m.05.exr", "m.07.exr", "m.09.exr"]);
    let order: Vec<&str> = run.out.lines().map(|line| line.split(':').next().unwrap()).collect();
    assert_eq!(order, ["frame -2", "frame -1", "frame 5", "frame 7", "frame 9"]);
    assert!(run.err.contains("5 frames, -2 and others, are outside of the document's frames, 1 to 3"), "{}", run.err);
    scene.run(&["render", "a.json", "--frames", "1", "--out", "x/{output}.%03d.exr"]).code(0);
    let run = scene.run(&["render", "a.json", "--frames", "4", "--output", "mask"]).code(0);
    assert!(run.err.contains("frame 4 is outside of the document's frames, 1 to 3"), "{}", run.err);
    assert!(scene.path("x/beauty.001.exr").exists() && scene.path("x/mask.001.exr").exists());
}

#[test]
fn resume_skips_what_is_current_and_nothing_else() {
    let scene = Scene::new(SCENE);
    let resume = |more: &[&str]| {
        let run = scene.run(&[&["render", "a.json", "--resume"], more].concat()).code(0);
        run.out.lines().map(|line| line.ends_with("  up to date")).collect::<Vec<bool>>()
    };
    assert_eq!(resume(&["--frames", "1-2"]), [false, false]);
    assert_eq!(resume(&["--require", "hull"]), [true, true, false]);
    assert_eq!(resume(&["--set", "mix.a=#100", "--frames", "2"]), [false], "another --set");
    assert_eq!(resume(&[]), [true, false, true], "frame 2 was made with --set");
    fs::write(scene.path("out/mask.0001.png"), "damaged").unwrap();
    scene.run(&["render", "a.json", "--resume", "--frames", "1"]).fails(2, &["out/mask.0001.png", "--overwrite"]);
    let run = scene.run(&["render", "a.json", "--resume", "--frames", "1", "--overwrite"]).code(0);
    assert!(run.out.starts_with("frame 1: mask → "), "the other output is current: {}", run.out);
    let other = SCENE.replace("\"last\": 3", "\"last\": 3, \"fps\": 25");
    fs::write(scene.path("a.json"), &other).unwrap();
    assert_eq!(resume(&[]), [false, false, false], "another document");
    fs::write(scene.path("a.json"), format!("\n{}", other.replace("25", "25.0"))).unwrap();
    assert_eq!(resume(&[]), [true, true, true], "the same document, written otherwise");
}

#[test]
fn resume_renders_again_when_an_input_has_changed() {
    let scene = Scene::new(READS);
    let current = || scene.run(&["render", "a.json", "--resume"]).code(0).out.ends_with("up to date\n");
    scene.write_picture("in.exr", 0.25);
    assert!(!current());
    assert!(current());
    scene.write_picture("in.exr", 0.75);
    assert!(!current());
    assert!(current());
}

#[test]
fn replaced_values_are_warned_of_once_with_their_node() {
    let nan = |more: &str| {
        let fm = format!("\"fm\": {{ \"type\": \"FieldMath\", \"expression\": \"0/0*a\", \"a\": \"across\"{more} }}");
        let scene = SCENE.replace(
            "\"across\": {",
            &format!("{fm}, \"c\": {{ \"type\": \"Clamp\", \"field\": \"fm\" }}, \"across\": {{"),
        );
        Scene::new(&scene.replace("\"weight\": \"across\"", "\"weight\": \"c\""))
    };
    let scene = nan("");
    let beauty = ["render", "a.json", "--output", "beauty"];
    let quiet = scene.run(&[&beauty[..], &["--quiet"]].concat()).code(0);
    assert_eq!(quiet.err.matches("warning: ").count(), 1, "{}", quiet.err);
    let words = "warning: a.json:3:14: node \"fm\", frame 1: found 128 illegal values (NaN), which were replaced, \
        first at pixel 0, 0 by 0/0; expected numbers";
    assert!(quiet.err.contains(words) && quiet.err.contains("\n  remedy: "), "{}", quiet.err);
    let json = scene.run(&[&beauty[..], &["--json", "--frames", "2"]].concat()).code(0).json();
    assert_eq!(json["nodes"]["fm"]["repaired"], 128);
    assert_eq!(json["nodes"]["fm"]["first_repaired"], serde_json::json!({ "pixel": [0, 0], "cause": "0/0" }));
    assert_eq!(json["nodes"]["across"]["repaired"], 0);
    assert_eq!(nan(", \"nan\": 0.5").run(&beauty).code(0).err, "", "it was asked for");
}

#[test]
fn requirements_that_hold_are_no_obstacle() {
    for guarantee in ["hull", "box"] {
        let scene = Scene::new(SCENE);
        scene.run(&["render", "a.json", "--require", guarantee]).code(0);
        assert_eq!(scene.files().len(), 6);
    }
}

#[test]
fn the_report_says_what_was_done() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--frames", "1-2", "--report", "deep/r.json", "--quiet"]).code(0);
    let report: Value = serde_json::from_slice(&fs::read(scene.path("deep/r.json")).unwrap()).unwrap();
    assert_eq!(report["status"], "done");
    assert_eq!(report["document_hash"].as_str().unwrap().len(), 64);
    let frame = &report["frames"][1];
    assert_eq!(frame["frame"], 2);
    let beauty = &frame["outputs"]["beauty"];
    assert_eq!((beauty["guarantee"].as_str(), beauty["hull_exits"].as_u64()), (Some("hull"), Some(0)));
    assert_eq!(beauty["control_colors"]["count"], 2);
    assert_eq!(beauty["pixels"], 128);
    assert_eq!(frame["nodes"]["mix"]["state"], "evaluated");
    assert_eq!(frame["files"][0]["path"], "out/beauty.0002.exr");
    assert_eq!(frame["files"][0]["state"], "written");
    let run = scene.run(&["render", "a.json", "--report", "-", "--resume"]).code(0);
    assert_eq!(run.json()["frames"][0]["skipped"], true);
    assert_eq!(run.json()["frames"][2]["frame"], 3);
}

#[test]
fn json_is_one_object_a_frame_and_quiet_is_silent() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&["render", "a.json", "--json"]).code(0);
    let frames: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(frames.len(), 3);
    assert_eq!(frames[2]["files"][1]["outputs"][0], "mask");
    let run = scene.run(&["render", "a.json", "--quiet"]).code(0);
    assert_eq!((run.out, run.err), (String::new(), String::new()));
}

#[test]
fn neither_threads_nor_optimization_change_a_bit() {
    let scene = Scene::new(SCENE);
    let render = |name: &str, more: &[&str]| {
        let pattern = format!("{name}.exr");
        let fixed = ["render", "a.json", "--frames", "1", "--output", "beauty", "--out", &pattern];
        scene.run(&[&fixed, more].concat()).code(0);
        let selection = trochoid::io::Selection::default();
        trochoid::io::read(scene.path(&pattern), &selection, &trochoid::io::Limits::default()).unwrap()
    };
    let one = render("one", &["--threads", "1"]);
    assert_eq!(one, render("three", &["--threads", "3"]));
    assert_eq!(one, render("unoptimized", &["--unoptimized"]));
}

#[test]
fn equal_frames_are_equal_files_whatever_a_cache_held() {
    let scene = Scene::new(&SCENE.replace(
        "\"mix\":",
        "\"camera\": { \"type\": \"Camera\" }, \"s\": { \"type\": \"RippleSea\" }, \"v\": { \"type\": \"Render\",
         \"camera\": \"camera\", \"surfaces\": [\"s\"] }, \"lit\": { \"type\": \"Mix\", \"a\": \"#123\",
         \"b\": \"#456\", \"weight\": \"v.coverage\" }, \"mix\":",
    ).replace("\"a\": \"#000\"", "\"a\": \"lit\""));
    let report = |frames: &str| {
        let run = scene.run(&["render", "a.json", "--frames", frames, "--report", "-"]).code(0);
        run.json()["frames"].as_array().unwrap().last().unwrap()["nodes"]["camera"]["state"].clone()
    };
    assert_eq!(report("1-2"), "cached");
    let files = || ["out/beauty.0002.exr", "out/mask.0002.png"].map(|name| fs::read(scene.path(name)).unwrap());
    let of_run = files();
    assert_eq!(report("2"), "evaluated");
    assert!(files() == of_run);
}

#[test]
fn reserved_space_in_a_file_is_not_shown() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--frames", "1"]).code(0);
    let run = scene.run(&["info", "out/beauty.0001.exr"]).code(0);
    assert!(run.out.contains("trochoid:plan") && !run.out.contains("reserved"), "{}", run.out);
}

#[test]
fn a_surface_that_no_picture_shows_is_told_once() {
    let text = r##"{ "trochoid": 1, "format": { "width": 16, "height": 8 }, "frames": { "first": 1, "last": 2 },
      "nodes": { "eye": { "type": "Camera", "position": [0, 3, 10], "target": [0, 3, 0], "fov": 50 },
                 "sea": { "type": "GerstnerSea", "count": 0 },
                 "view": { "type": "Render", "camera": "eye", "surfaces": ["sea"] },
                 "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "view.coverage" } },
      "outputs": { "beauty": { "color": "mix", "file": "out/beauty.####.png" } } }"##;
    let scene = Scene::new(text);
    assert_eq!(scene.run(&["render", "a.json"]).code(0).err, "");
    let away = ["--set", "eye.position=[0,3000000000,10000000000]", "--report", "r.json", "--overwrite"];
    let run = scene.run(&[&["render", "a.json"][..], &away].concat()).code(0);
    let words = "warning: a.json:4:75: node \"view\", frame 1: found nothing of the surface \"sea\" in the picture";
    assert!(run.err.starts_with(words) && run.err.matches("warning").count() == 1, "{}", run.err);
    let report: Value = serde_json::from_slice(&fs::read(scene.path("r.json")).unwrap()).unwrap();
    assert_eq!(report["frames"][1]["nodes"]["view"]["unseen"], serde_json::json!(["sea"]));
    let explained = scene.run(&["check", "a.json", "--explain", "--set", "eye.position=[0,3000000000,10000000000]"]);
    explained.code(0).says(&["view: of \"sea\", 1 of 1 surfaces: nothing of it is in the picture"]);
}

//! `trochoid plan`, and `trochoid render --tolerance`, `--plan`.

use crate::scene::{READS, SCENE, Scene};
use serde_json::Value;
use std::fs;
use trochoid::io::{Limits, Selection, read};

/// A sea whose mesh is too coarse for most tolerances, in colors that are mixed as displayed.
const SEA: &str = r##"{ "trochoid": 1,
  "format": { "width": 64, "height": 36 }, "working_space": "srgb", "frames": { "first": 1, "last": 2 },
  "nodes": { "camera": { "type": "Camera", "position": [0, 6, 30], "target": [0, 1, 0] },
             "sea": { "type": "GerstnerSea", "count": 12, "height": 1.5 },
             "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
             "fresnel": { "type": "Fresnel", "view": "view" },
             "water": { "type": "Mix", "a": "#1a2438", "b": "#93b4a6", "weight": "fresnel" } },
  "outputs": { "beauty": { "color": "water", "file": "out.##.exr" } } }"##;

fn json(scene: &Scene, name: &str) -> Value {
    serde_json::from_slice(&fs::read(scene.path(name)).unwrap()).unwrap()
}

fn pixels(scene: &Scene, name: &str) -> Vec<f32> {
    let image = read(scene.path(name), &Selection::default(), &Limits::default()).unwrap();
    image.channels.iter().flat_map(|channel| channel.plane.samples().to_vec()).collect()
}

#[test]
fn a_plan_is_certified_to_meet_its_tolerance_and_renders_what_the_tolerance_renders() {
    let scene = Scene::new(SEA);
    scene.run(&["plan", "a.json", "--tolerance", "1/64", "--out", "p.json"]).code(0).says(&[
        "tolerance 1/64: view.points=surface",
        "beauty: unambiguous samples off by ≤ ",
        "s predicted",
    ]);
    let plan = json(&scene, "p.json");
    assert_eq!(plan["set"], serde_json::json!({ "view.points": "surface" }));
    let max = plan["certified"]["beauty"]["max"].as_f64().unwrap();
    assert!(max > 0.0 && max <= 1.0 / 64.0, "{max}");
    scene.run(&["render", "a.json", "--frames", "1", "--plan", "p.json", "--out", "planned.exr"]).code(0);
    let asked =
        ["render", "a.json", "--frames", "1", "--tolerance", "1/64", "--out", "asked.exr", "--report", "r.json"];
    scene.run(&asked).code(0).says(&["tolerance 1/64: view.points=surface", "frame 1: beauty"]);
    let set = ["render", "a.json", "--frames", "1", "--set", "view.points=surface", "--out", "set.exr"];
    scene.run(&set).code(0);
    assert_eq!(pixels(&scene, "planned.exr"), pixels(&scene, "set.exr"));
    assert_eq!(pixels(&scene, "asked.exr"), pixels(&scene, "set.exr"));
    let frame = &json(&scene, "r.json")["frames"][0];
    assert_eq!(frame["accuracy"]["set"], serde_json::json!(["view.points=surface"]));
    assert!(frame["accuracy"]["predicted_seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(frame["outputs"]["beauty"]["certified"]["clear"]["max"].as_f64(), Some(max));
}

#[test]
fn the_document_may_require_a_tolerance() {
    let scene = Scene::new(&SEA.replace("\"working_space\"", "\"tolerance\": \"1/64\", \"working_space\""));
    let run = scene.run(&["render", "a.json", "--frames", "1-2"]).code(0);
    run.says(&["tolerance 1/64: view.points=surface", "frame 2: beauty"]);
    for wrong in ["0", "2", "\"1/0\"", "\"best\"", "[1]"] {
        let scene =
            Scene::new(&SEA.replace("\"working_space\"", &format!("\"tolerance\": {wrong}, \"working_space\"")));
        scene.run(&["check", "a.json"]).fails(2, &["tolerance", "1/512", "exact"]);
    }
}

#[test]
fn a_pass_without_a_bound_is_named_with_its_reason() {
    let lined = SEA
        .replace("\"water\":", "\"net\": { \"type\": \"SurfaceLines\", \"view\": \"view\" }, \"water\":")
        .replace("\"weight\": \"fresnel\"", "\"weight\": \"net.mask\"");
    let scene = Scene::new(&lined);
    let words = [
        "output \"beauty\": found no sample with a certified error, because \"net\" (SurfaceLines) has no error bound: the \
         slope",
        "remedy: plan an output",
    ];
    scene.run(&["plan", "a.json", "--tolerance", "1/64"]).fails(3, &words);
}

#[test]
fn a_tolerance_that_no_method_meets_is_refused_with_the_pass_that_limits_it() {
    let scene = Scene::new(SEA);
    let words = ["output \"beauty\": found ", "limited by the pass \"fresnel\" (Fresnel)", "remedy: ask for 1/"];
    scene.run(&["plan", "a.json", "--tolerance", "1e-9"]).fails(3, &words);
    scene.run(&["render", "a.json", "--tolerance", "1e-9"]).fails(3, &words);
    scene.has_no_files();
    // The tolerance that the remedy names is met.
    let refusal = scene.run(&["plan", "a.json", "--tolerance", "1e-9"]).err;
    let reachable = refusal.split("ask for ").nth(1).unwrap().split(' ').next().unwrap();
    assert!(reachable.starts_with("1/") && !reachable.contains('e'), "{reachable}");
    scene.run(&["plan", "a.json", "--tolerance", reachable]).code(0);
}

#[test]
fn exact_and_reference_are_within_what_is_certified() {
    let scene = Scene::new(SEA);
    let exact = ["render", "a.json", "--frames", "1", "--tolerance", "exact", "--out", "e.exr", "--report", "e.json"];
    scene.run(&[&exact[..], &["--certificate", "c.json"]].concat()).code(0).says(&["view.points=exact"]);
    let reference = ["render", "a.json", "--frames", "1", "--tolerance", "reference", "--out", "r.exr"];
    scene.run(&reference).code(0).says(&["frame 1: beauty → r.exr  hull, 0 outside"]);
    let [exact, reference] = ["e.exr", "r.exr"].map(|name| pixels(&scene, name));
    let bounds = &json(&scene, "c.json")["outputs"][0]["error"]["channels"][0];
    let certified = bounds["clear"]["max"]["bound"].as_f64().unwrap();
    // Edges are ambiguous, and stored values are rounded to 11 bits.
    let within = exact.iter().zip(&reference).filter(|(a, b)| (**a - **b).abs() <= certified as f32 + 5e-4).count();
    assert!(within * 100 > 97 * exact.len(), "{within} of {}", exact.len());
    assert_ne!(
        exact,
        pixels(
            &{
                let scene = Scene::new(SEA);
                scene.run(&["render", "a.json", "--frames", "1", "--out", "m.exr"]).code(0);
                scene
            },
            "m.exr"
        )
    );
}

#[test]
fn a_document_without_a_choice_is_certified_as_it_is() {
    let scene = Scene::new(SCENE);
    scene
        .run(&["plan", "a.json", "--tolerance", "1/512"])
        .code(0)
        .says(&["nothing to choose", "mask: unambiguous samples off by ≤ "]);
    let plan = scene.run(&["plan", "a.json", "--tolerance", "exact", "--json"]).code(0).json();
    assert_eq!((plan["tolerance"].as_str(), plan["set"].as_object().unwrap().len()), (Some("exact"), 0));
}

#[test]
fn wrong_tolerances_and_outputs_are_refused() {
    let scene = Scene::new(SEA);
    scene.run(&["plan", "a.json"]).fails(2, &["--tolerance", "1/512"]);
    scene.run(&["plan", "a.json", "--tolerance", "reference"]).fails(2, &["render with --tolerance reference"]);
    scene.run(&["plan", "a.json", "--tolerance", "1/64", "--output", "mask"]).fails(2, &["beauty"]);
    scene.run(&["render", "a.json", "--tolerance", "none"]).fails(2, &["none", "1/512"]);
}

#[test]
fn a_plan_is_written_over_nothing_that_the_document_reads_and_only_where_it_can_be() {
    let scene = Scene::new(READS);
    scene.write_picture("in.exr", 0.25);
    let plan = |out: &str| scene.run(&["plan", "a.json", "--tolerance", "1/64", "-o", out]);
    for input in ["a.json", "in.exr", "./in.exr"] {
        let before = fs::read(scene.path(input)).unwrap();
        plan(input).fails(2, &[input, "is an input of the document and would be overwritten"]);
        assert_eq!(fs::read(scene.path(input)).unwrap(), before);
    }
    plan("in.exr/p.json").fails(1, &["in.exr/p.json", "is not a folder"]);
    plan(".").fails(1, &["is a folder; name a file"]);
    plan("plans/p.json").code(0);
    assert_eq!(scene.files(), ["in.exr", "plans/p.json"]);
}

#[test]
fn a_file_that_is_no_plan_is_named_with_what_to_do() {
    let scene = Scene::new(SEA);
    let refused = |text: &str, words: &[&str]| {
        fs::write(scene.path("bad.json"), text).unwrap();
        let run = scene.run(&["render", "a.json", "--plan", "bad.json"]);
        assert!(!run.err.contains("unknown field") && !run.err.contains("--set veiw"), "{}", run.err);
        run.fails(2, &[&["error: bad.json: ", "remedy: "], words].concat());
    };
    let fields = |more: &str| {
        format!(
            "{{\"trochoid_plan\": 1, \"document_hash\": \"0\", \"frame\": 1, \"predicted_seconds\": 1, \"certified\": {{}}, {more}}}"
        )
    };
    refused(SEA, &["found a document; expected a plan as `trochoid plan --out` writes it", "trochoid plan GRAPH"]);
    refused("[1]", &["found JSON without \"trochoid_plan\""]);
    refused("frame 1", &["found no JSON"]);
    refused("{\"trochoid_plan\": 2}", &["found a plan of version 2; expected version 1"]);
    refused("{\"trochoid_plan\": 1}", &["found a plan with faults"]);
    refused(&fields("\"set\": {}, \"tolerance\": \"good\""), &["found the tolerance \"good\"", "1/512"]);
    let words = ["bad.json: set veiw.points=exact: found node \"veiw\"", "trochoid plan a.json"];
    refused(&fields("\"set\": {\"veiw.points\": \"exact\"}, \"tolerance\": \"1/64\""), &words);
    let words = ["bad.json: set view.points=best", "view", "points"];
    refused(&fields("\"set\": {\"view.points\": \"best\"}, \"tolerance\": \"1/64\""), &words);
    scene.run(&["render", "a.json", "--plan", "no.json"]).fails(1, &["no.json: cannot open the file"]);
    scene.run(&["render", "a.json", "--plan", "bad.json", "--tolerance", "1/8"]).fails(2, &["--plan", "--tolerance"]);
    assert_eq!(scene.files(), ["bad.json"]);
}

#[test]
fn a_plan_for_another_document_frame_or_tolerance_is_warned_of() {
    let scene = Scene::new(SCENE);
    scene.run(&["plan", "a.json", "--tolerance", "1/64", "--out", "p.json"]).code(0);
    let warned = |arguments: &[&str], words: &[&str]| {
        let run = scene.run(&[&["render", "--plan", "p.json"], arguments].concat()).code(0);
        assert_eq!(run.err.matches("warning: p.json: found ").count(), words.len(), "{}", run.err);
        words.iter().for_each(|word| assert!(run.err.contains(word), "no \"{word}\" in: {}", run.err));
    };
    warned(&["a.json", "--frames", "1"], &[]);
    let other = "found a plan for another document, with the hash ";
    warned(&["a.json", "--frames", "1", "--set", "mix.b=#ffe"], &[other]);
    warned(&["a.json", "--frames", "2"], &["found a plan made at frame 1; expected one for frame 2 as well"]);
    warned(&["a.json"], &["found a plan made at frame 1; expected one for 2 other frames from 2 to 3 as well"]);
    let asks = |tolerance: &str| {
        let text = SCENE.replace("\"format\"", &format!("\"tolerance\": \"{tolerance}\", \"format\""));
        fs::write(scene.path("b.json"), text).unwrap();
    };
    asks("1/512");
    let tighter = "found a plan for the tolerance 1/64; expected 1/512, which the document requires";
    warned(&["b.json", "--frames", "1"], &[other, tighter]);
    asks("1/8");
    warned(&["b.json", "--frames", "1"], &[other]);
}

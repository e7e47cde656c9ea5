//! `trochoid stability`.

use crate::scene::{SCENE, Scene};

/// A small sea, so that the test is quick.
const SMALL: [&str; 4] = ["--set", "sea.columns=24", "--set", "sea.rows=20"];

fn arguments<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["stability"], &SMALL[..], more].concat()
}

#[test]
fn the_default_sea_is_stable_and_drawn() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&arguments(&["-o", "maps/sea.png"])).code(0).says(&[
        "sea (ToonSea): stable",
        "the slowest loses half in 9.02",
        "It becomes unstable with c1 outside",
        "predicted    measured",
        "0.92604     0.92604 = 2³⁰ steps in f64, 8 × 8 cells",
        "map: maps/sea.png",
    ]);
    assert!(run.out.lines().all(|line| line.chars().count() <= 100), "{}", run.out);
    assert!(!run.out.contains('≠'), "{}", run.out);
    scene.run(&["info", "maps/sea.png"]).code(0).says(&["1200 × 1000 pixels"]);
    let json = scene.run(&arguments(&["--json", "--set", "sea.mode=physical"])).code(0).json();
    let sea = &json["nodes"][0];
    assert_eq!((sea["node"].as_str(), sea["verdict"].as_str()), (Some("sea"), Some("stable")));
    let figures = sea["figures"].as_array().unwrap();
    assert!(figures.len() > 8 && figures.iter().all(|figure| figure["holds"] != false), "{json:#}");
    // A sea without coefficients has no map.
    let none = arguments(&["-o", "a.png", "--set", "sea.mode=physical"]);
    scene.run(&none).fails(2, &["found 0 nodes with a map; expected one", "omit --out"]);
}

#[test]
fn an_unstable_sea_is_refused_with_what_would_be_stable() {
    let scene = Scene::new(SCENE);
    let run = arguments(&["--set", "sea.mode=literal", "--set", "sea.c1=0.9", "--set", "sea.c2=-0.5"]);
    scene.run(&run).fails(2, &["grows by 1.77", "set \"c1\" ", "the nearest stable values", "\"mode\" \"physical\""]);
}

#[test]
fn graphs_are_examined_node_by_node() {
    let scene = Scene::new(SCENE);
    scene.run(&["stability", "a.json"]).code(0).says(&["no node depends on time"]);
    let seas = r#"{ "trochoid": 1, "format": { "width": 8, "height": 8 }, "nodes": {
        "camera": { "type": "Camera" }, "sun": { "type": "Light" },
        "storm": { "type": "GerstnerSea", "count": 40, "sharpness": 0.3 },
        "ripples": { "type": "RippleSea" },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["storm", "ripples"] },
        "spray": { "type": "Spray", "view": "view", "sea": "storm" } },
        "outputs": { "spray": { "weights": "spray.alpha" }, "seen": { "weights": "view.coverage" } } }"#;
    let seas = Scene::new(seas);
    let run = seas.run(&["stability", "a.json"]).code(0).says(&[
        "storm (GerstnerSea): closed form",
        "ripples (RippleSea): closed form",
        "spray (Spray): closed form",
        "greatest error of a phase, turns",
        "least det J",
        "Nothing folds",
    ]);
    assert!(run.out.lines().all(|line| line.chars().count() <= 100), "{}", run.out);
    let run = seas.run(&["stability", "a.json", "-o", "maps"]).code(0).says(&["storm (GerstnerSea)"]);
    assert!(run.err.contains("warning: --out maps: found no node with a map"), "{}", run.err);
    seas.has_no_files();
    for name in ["m.jpg", "map.PNGs"] {
        seas.run(&["stability", "a.json", "-o", name]).fails(2, &[name, "found the extension .", "expected .png"]);
    }
}

#[test]
fn errors_by_steps_are_told_and_drawn() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&arguments(&["--steps", "40", "-o", "maps"])).code(0).says(&[
        "Errors of f32 beside f64, 24 × 20 cells",
        "after steps                          10       40      f64",
        "resampled, 24 Hz",
        "1 - c1 - c2 = 1e-6",
        "c1 = 1 - 1e-4, c2 = 9e-5",
        "a moving body",
        "plot: maps/sea.steps.png",
    ]);
    assert!(run.out.lines().all(|line| line.chars().count() <= 100), "{}", run.out);
    scene.run(&["info", "maps/sea.steps.png"]).code(0).says(&["1500 × 1000 pixels"]);
    let json = scene.run(&arguments(&["--json", "--steps", "12", "--set", "sea.mode=physical"])).code(0).json();
    let steps = &json["nodes"][0]["steps"];
    assert_eq!(steps["steps"], serde_json::json!([1, 2, 5, 10, 12]));
    let groups = steps["groups"].as_array().unwrap();
    let rows = groups.iter().flat_map(|group| group["rows"].as_array().unwrap());
    assert!(rows.clone().count() >= 14);
    assert!(rows.flat_map(|row| row["errors"].as_array().unwrap()).all(|error| error.as_f64().unwrap() < 1e-4));
}

/// Tests seas on and near the edges of the stable region, whose verdict and exit code agree.
#[test]
fn sound_seas_do_not_fail() {
    let scene = Scene::new(SCENE);
    for (c1, c2, boundary, side) in [
        ("0.9", "-0.1", "periodic", "16"),
        ("0.95", "0.05", "replicate", "24"),
        ("0.9999", "9.999e-5", "replicate", "24"),
    ] {
        let set = [("c1", c1), ("c2", c2), ("boundary", boundary), ("columns", side)];
        let set: Vec<String> = set.iter().map(|(knob, value)| format!("sea.{knob}={value}")).collect();
        let mut arguments = vec!["stability", "--set", "sea.rows=16", "--set", "sea.mode=literal"];
        set.iter().for_each(|set| arguments.extend(["--set", set.as_str()]));
        let run = scene.run(&arguments).code(0);
        assert!(run.out.contains("bounded") || run.out.contains("stable"), "{}", run.out);
        assert!(!run.out.contains('≠'), "{}", run.out);
    }
}

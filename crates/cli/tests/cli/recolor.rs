//! Pictures that are taken apart and painted in other colors.

use crate::scene::Scene;
use serde_json::Value;
use std::fs;
use trochoid::io::{Picture, read};

/// A picture of five colors, with mixes of all of them.
const SCENE: &str = r##"{ "trochoid": 1, "format": { "width": 40, "height": 30 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "dusk": "#5a3f5e", "sun": "#f0cf8e", "foam": "#e8f4ff", "moss": "#2f6b3a" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "n": { "type": "Noise", "scale": 5 }, "m": { "type": "Clamp", "field": "n", "min": -0.5, "max": 0.5 },
             "sky": { "type": "Mix", "a": "palette.dusk", "b": "palette.sun", "weight": "x" },
             "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "m" },
             "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" },
             "land": { "type": "Mix", "a": "all", "b": "palette.moss", "weight": 0.25 } },
  "outputs": { "land": { "color": "land", "file": "land.png", "precision": "uint16" } } }"##;

fn made() -> Scene {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    scene
}

fn picture(scene: &Scene, name: &str) -> Picture {
    read(scene.path(name), &Default::default(), &Default::default()).unwrap()
}

/// Returns the largest difference of two pictures, in steps of 255.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.channels.iter().zip(&b.channels);
    let off = |(a, b): (&f32, &f32)| 255.0 * (a - b).abs();
    pairs.flat_map(|(a, b)| a.plane.samples().iter().zip(b.plane.samples()).map(off)).fold(0.0, f32::max)
}

#[test]
fn a_picture_is_painted_again_in_its_own_colors_and_in_others() {
    let scene = made();
    // A document is a palette, too.
    let run = scene.run(&["decompose", "land.png", "--palette", "a.json", "--out", "r.exr"]).code(0);
    run.says(&["land.png → r.exr: 5 colors, "]);
    scene.run(&["recolor", "r.exr", "--out", "same.png"]).code(0);
    assert!(apart(&picture(&scene, "land.png"), &picture(&scene, "same.png")) < 1.01);
    scene.run(&["decompose", "land.png", "--palette", "a.json", "--out", "f.exr", "--float"]).code(0);
    scene.run(&["recolor", "f.exr", "--out", "deep.png", "--deep"]).code(0);
    assert!(apart(&picture(&scene, "land.png"), &picture(&scene, "deep.png")) < 0.02);
    // Other colors, from a file and one by one, are the same picture.
    fs::write(scene.path("warm.json"), r##"{ "sun": "#ff8844", "foam": "#ffeecc" }"##).unwrap();
    scene.run(&["recolor", "f.exr", "--palette", "warm.json", "--out", "warm.png"]).code(0);
    let set = ["--set", "sun=#ff8844", "--set", "foam=#ffeecc"];
    scene.run(&[&["recolor", "f.exr", "--out", "set.png"][..], &set].concat()).code(0);
    assert_eq!(apart(&picture(&scene, "warm.png"), &picture(&scene, "set.png")), 0.0);
    assert!(apart(&picture(&scene, "warm.png"), &picture(&scene, "land.png")) > 20.0);
}

#[test]
fn what_was_painted_is_told_as_json() {
    let scene = made();
    scene.run(&["decompose", "land.png", "--palette", "a.json", "--out", "r.exr"]).code(0);
    let json = scene.run(&["recolor", "r.exr", "--out", "{name}.png", "--json"]).code(0).json();
    let painted = &json["pictures"][0];
    assert_eq!((&painted["recipe"], &painted["file"]), (&"r.exr".into(), &"r.png".into()));
    assert_eq!((&painted["colors"], &painted["outside"]), (&5.into(), &0.into()));
    assert!((0.0..1.0 / 255.0).contains(&painted["within"].as_f64().unwrap()), "{json}");
    scene.run(&["recolor", "r.exr", "--out", "s.png", "--json", "--quiet"]).fails(2, &["--quiet"]);
}

#[test]
fn weights_are_masks_whose_sum_is_exactly_1() {
    let scene = made();
    for (out, more) in [("h.exr", &[][..]), ("f.exr", &["--float"]), ("s.exr", &["--softness", "0"])] {
        scene.run(&[&["decompose", "land.png", "--palette", "a.json", "--out", out][..], more].concat()).code(0);
        let recipe = scene.layers(out);
        let names: Vec<&str> = recipe.channels.iter().map(|channel| channel.full_name.as_str()).collect();
        for name in ["night", "dusk", "sun", "foam", "moss"] {
            assert!(names.contains(&format!("recipe.{name}.Y").as_str()), "{names:?}");
        }
        for pixel in 0..recipe.data.area() {
            let weights = recipe.channels.iter().map(|channel| channel.plane.samples()[pixel]);
            assert!(weights.clone().all(|weight| weight >= 0.0));
            assert_eq!(weights.sum::<f32>(), 1.0, "{out}, pixel {pixel}");
        }
    }
}

#[test]
fn many_pictures_are_taken_apart_alike() {
    let scene = made();
    fs::copy(scene.path("land.png"), scene.path("again.png")).unwrap();
    let all = ["decompose", "land.png", "again.png", "--palette", "a.json", "--out", "r.{name}.exr", "--json"];
    let json: Value = scene.run(&all).code(0).json();
    assert_eq!(json["recipes"][1]["files"][0], "r.again.exr");
    assert_eq!(apart(&scene.layers("r.land.exr"), &scene.layers("r.again.exr")), 0.0);
    scene.run(&["recolor", "r.land.exr", "r.again.exr", "--out", "{name}.png"]).code(0);
    assert!(scene.path("r.again.png").exists());
}

#[test]
fn pixels_outside_are_counted() {
    let scene = made();
    fs::write(scene.path("few.json"), r##"{ "night": "#101a33", "sun": "#f0cf8e", "foam": "#e8f4ff" }"##).unwrap();
    let json =
        scene.run(&["decompose", "land.png", "--palette", "few.json", "--out", "r.exr", "--json"]).code(0).json();
    let found = &json["recipes"][0];
    assert!(found["outside"].as_u64().unwrap() > 100 && found["farthest"].as_f64().unwrap() > 1.0, "{found}");
    scene.run(&["recolor", "r.exr", "--out", "x.png"]).code(0);
}

#[test]
fn what_only_the_file_rounds_is_not_outside() {
    let scene = made();
    let stored = |file: &str, precision: &str| {
        let land = format!(r#""file": "{file}", "precision": "{precision}""#);
        fs::write(scene.path("b.json"), SCENE.replace(r#""file": "land.png", "precision": "uint16""#, &land)).unwrap();
        scene.run(&["render", "b.json"]).code(0);
        let decompose = |more: &[&str]| {
            let out = ["decompose", file, "--palette", "a.json", "--out", "r.exr"];
            scene.run(&[&out[..], more].concat()).code(0)
        };
        decompose(&[]).says(&["5 colors, every pixel is a mix of them, up to the rounding of the file\n"]);
        let found = decompose(&["--json"]).json()["recipes"][0].clone();
        assert_eq!(found["outside"], 0, "{file}: {found}");
        found["farthest"].as_f64().unwrap()
    };
    // Half a step along each of three axes, at most; never nothing, for edges of the hull are among the colors.
    for (file, precision, most) in
        [("b8.png", "uint8", 0.87), ("b16.png", "uint16", 0.87 / 257.0), ("b.exr", "half", 0.095)]
    {
        let farthest = stored(file, precision);
        assert!((most / 100.0..most).contains(&farthest), "{file}: {farthest}");
    }
}

#[test]
fn what_cannot_be_done_is_told_before_anything_is_written() {
    let scene = made();
    let decompose = |more: &[&str]| scene.run(&[&["decompose", "land.png"][..], more].concat());
    decompose(&["--palette", "a.json", "--out", "r.png"]).fails(2, &["expected .exr"]);
    decompose(&["again.png", "--palette", "a.json", "--out", "r.exr"]).fails(2, &["expected {name} in it"]);
    decompose(&["--palette", "none.json", "--out", "r.exr"]).fails(1, &["none.json"]);
    decompose(&["--palette", "a.json", "--out", "r.exr", "--softness", "2"]).fails(2, &["a number from 0 to 1"]);
    let many: Vec<String> = (0..25).map(|index| format!("\"c{index}\": \"#0000{:02x}\"", 10 * index)).collect();
    fs::write(scene.path("many.json"), format!("{{ {} }}", many.join(", "))).unwrap();
    decompose(&["--palette", "many.json", "--out", "r.exr"]).fails(2, &["found 25 colors; expected at most 24"]);
    assert!(!scene.path("r.exr").exists());
    decompose(&["--palette", "a.json", "--out", "r.exr"]).code(0);
    let recolor = |more: &[&str]| scene.run(&[&["recolor", "r.exr"][..], more].concat());
    recolor(&["--set", "glow=#fff", "--out", "x.png"]).fails(2, &["found the color \"glow\"", "night, dusk, sun"]);
    recolor(&["--set", "foma=#fff", "--out", "x.png"]).fails(2, &["did you mean \"foam\"?"]);
    recolor(&["--set", "foam", "--out", "x.png"]).fails(2, &["--set foam: found no =; expected NAME=#rrggbb"]);
    let no_color = "--set foam=white: found \"white\" as the color; expected #rrggbb";
    recolor(&["--set", "foam=white", "--out", "x.png"]).fails(2, &[no_color, "such as foam=#f2c14e"]);
    // Both are told at once.
    recolor(&["--set", "foma=white", "--out", "x.png"]).fails(2, &["found \"white\"", "did you mean \"foam\"?"]);
    recolor(&["--out", "r.exr"]).fails(2, &["r.exr"]);
    scene.run(&["recolor", "land.png", "--out", "x.png"]).fails(2, &["land.png: found a picture without weights"]);
    assert!(!scene.path("x.png").exists());
}

//! Colors nearest to a painting, and recolorings for other programs.

use crate::scene::Scene;
use serde_json::Value;
use std::fs;

/// Four colors, all of which a sunset is a mix of.
const SUNSET: &str = r##"{ "trochoid": 1, "format": { "width": 48, "height": 32 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "dusk": "#5a3f5e", "sun": "#f0cf8e", "foam": "#e8f4ff" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "sky": { "type": "Mix", "a": "palette.dusk", "b": "palette.sun", "weight": "x" },
             "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "x" },
             "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" } },
  "outputs": { "all": { "color": "all", "file": "sunset.png" } } }"##;
const OTHERS: &str = r##"{ "night": "#3a1020", "dusk": "#20605a", "sun": "#d0e08e", "foam": "#fff0e0" }"##;

fn channels(text: &str) -> [f64; 3] {
    trochoid::parse_hex(text).unwrap().map(|v| 255.0 * v)
}

/// Asserts that a palette has these colors, within steps of 255.
fn near(scene: &Scene, file: &str, expected: &Value, within: f64) {
    let found: Value = serde_json::from_slice(&fs::read(scene.path(file)).unwrap()).unwrap();
    for (name, color) in expected.as_object().unwrap() {
        let [own, wanted] = [&found["palette"][name], color].map(|text| channels(text.as_str().unwrap()));
        let off = own.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off <= within, "{name}: {own:?} for {wanted:?}");
    }
}

#[test]
fn the_colors_of_a_painting_are_found() {
    let scene = Scene::new(SUNSET);
    fs::write(scene.path("others.json"), OTHERS).unwrap();
    scene.run(&["render", "a.json", "--palette", "others.json", "-o", "painting.png"]).code(0);
    let others: Value = serde_json::from_str(OTHERS).unwrap();
    let run = scene.run(&["fit", "a.json", "painting.png", "--aligned", "--keep", "0", "-o", "aligned.json"]).code(0);
    run.says(&["night", "#101a33", "rms, of 1"]);
    near(&scene, "aligned.json", &others, 1.0);
    // Wherever the colors are.
    scene.run(&["fit", "a.json", "painting.png", "--keep", "0", "-o", "free.json"]).code(0);
    near(&scene, "free.json", &others, 24.0);
    // The same from the recipe; and what is fixed stays.
    scene.run(&["render", "a.json", "--recipe", "a.recipe.exr"]).code(0);
    let fixed = ["fit", "a.recipe.exr", "painting.png", "--aligned", "--fix", "sun", "-o", "fixed.json", "--json"];
    let run = scene.run(&fixed).code(0);
    let told: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(told["colors"].as_array().unwrap().len(), 3, "{told}");
    assert!(told["after"].as_f64() < told["before"].as_f64(), "{told}");
    let found: Value = serde_json::from_slice(&fs::read(scene.path("fixed.json")).unwrap()).unwrap();
    assert!(found["palette"].get("sun").is_none(), "{found}");
    // A palette that it wrote is one that a render takes.
    scene.run(&["render", "a.json", "--palette", "aligned.json", "-o", "again.png"]).code(0);
}

#[test]
fn what_cannot_be_fitted_is_told() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json", "--recipe", "a.recipe.exr"]).code(0);
    let fit = |arguments: &[&str]| scene.run(&[&["fit"], arguments].concat());
    fit(&["a.json", "sunset.png", "-o", "p.txt"]).fails(2, &["expected .json, .gpl"]);
    fit(&["a.json", "sunset.png", "-o", "a.json"]).code(2);
    fit(&["a.json", "sunset.png", "-o", "p.json", "--fix", "nigth"]).fails(2, &["did you mean \"night\"?"]);
    fit(&["a.recipe.exr", "sunset.png", "-o", "p.json", "--frame", "2"]).fails(2, &["expected a document"]);
    fit(&["a.json", "sunset.png", "-o", "p.json", "--output", "none"]).fails(2, &["the document has: all"]);
    fit(&["a.json", "gone.png", "-o", "p.json"]).fails(1, &["gone.png"]);
    fs::write(
        scene.path("plain.json"),
        SUNSET
            .replace("palette.dusk", "#123")
            .replace("palette.sun", "#fed")
            .replace("palette.night", "#000")
            .replace("palette.foam", "#fff"),
    )
    .unwrap();
    fit(&["plain.json", "sunset.png", "-o", "p.json"]).fails(2, &["expected a palette"]);
    assert!(!scene.path("p.json").exists());
}

#[test]
fn a_recoloring_is_a_document_and_a_table_for_other_programs() {
    let scene = Scene::new(SUNSET);
    fs::write(scene.path("others.json"), OTHERS).unwrap();
    scene.run(&["render", "a.json"]).code(0);
    let graph = ["decompose", "sunset.png", "--palette", "a.json", "--graph", "again.json", "--softness", "0"];
    scene.run(&graph).code(0).says(&["again.json: 4 colors"]);
    scene.run(&["check", "again.json"]).code(0);
    scene.run(&["render", "again.json", "-o", "again.png"]).code(0);
    let pixels = |file: &str| {
        let picture = trochoid::io::read(scene.path(file), &Default::default(), &Default::default()).unwrap();
        picture.channels.into_iter().flat_map(|channel| channel.plane.samples().to_vec()).collect::<Vec<f32>>()
    };
    let off = pixels("sunset.png").iter().zip(pixels("again.png")).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // Pixels of 8 bits lie a little outside of the hull.
    assert!(off <= 2.0 / 255.0, "{off}");
    // A document is its author's: it is not replaced.
    scene.run(&graph).fails(2, &["again.json"]);
    let cube = ["decompose", "--palette", "a.json", "--to", "others.json", "--cube", "night.cube", "--cube-size", "9"];
    scene.run(&cube).code(0).says(&["9 colors along each axis"]);
    scene.run(&cube).code(0);
    let text = fs::read_to_string(scene.path("night.cube")).unwrap();
    assert!(text.contains("LUT_3D_SIZE 9\n") && text.lines().count() == 6 + 729, "{text}");
    fs::write(scene.path("wrong.json"), r##"{ "nigth": "#000" }"##).unwrap();
    let wrong = ["decompose", "--palette", "a.json", "--to", "wrong.json", "--cube", "b.cube"];
    scene.run(&wrong).fails(2, &["did you mean \"night\"?"]);
    scene.run(&["decompose", "--palette", "a.json", "--to", "others.json", "--cube", "b.txt"]).code(2);
    assert!(!scene.path("b.cube").exists());
}

#[test]
fn the_colors_of_a_pixel_are_told_and_sum_to_1() {
    let scene = Scene::new(SUNSET);
    let run = scene.run(&["blame", "a.json", "--at", "0,0", "--at", "47,31"]).code(0);
    run.says(&["all, frame 1, pixel 0,0: #5", "100.00 %  #5a3f5e  dusk"]);
    let run = scene.run(&["blame", "a.json", "--at", "20,11", "--json"]).code(0);
    let told: Value = serde_json::from_str(&run.out).unwrap();
    let colors = told["pixels"][0]["colors"].as_array().unwrap();
    let weights: Vec<f64> = colors.iter().map(|color| color["weight"].as_f64().unwrap()).collect();
    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-6 && weights.len() == 4, "{told}");
    assert!(weights.windows(2).all(|pair| pair[0] >= pair[1]), "{told}");
    // They mix the pixel that is rendered.
    scene.run(&["render", "a.json"]).code(0);
    let picture = trochoid::io::read(scene.path("sunset.png"), &Default::default(), &Default::default()).unwrap();
    for (c, channel) in picture.channels.iter().enumerate() {
        let mixed: f64 =
            colors.iter().zip(&weights).map(|(own, w)| w * channels(own["color"].as_str().unwrap())[c]).sum();
        let pixel = 255.0 * f64::from(channel.plane.samples()[11 * 48 + 20]);
        assert!((pixel - mixed).abs() < 0.51, "{pixel} {mixed}");
    }
    scene.run(&["blame", "a.json", "--at", "48,0"]).fails(2, &["--at 48,0", "the last one is 47,31"]);
    scene.run(&["blame", "sunset.png", "--at", "0,0"]).fails(2, &["expected a document", "--graph"]);
    scene.run(&["blame", "a.json", "--at", "x"]).fails(2, &["such as 960,540"]);
}

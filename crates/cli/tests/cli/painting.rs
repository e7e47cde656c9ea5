//! Palettes that are read off pictures.

use crate::scene::Scene;
use serde_json::Value;
use std::fs;
use trochoid::io::{PngImage, Samples, write_png8};

/// A picture of a sunset: mixes of four colors, in steps of 8 bits.
const SUNSET: &str = r##"{ "trochoid": 1, "format": { "width": 48, "height": 32 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "dusk": "#5a3f5e", "sun": "#f0cf8e", "foam": "#e8f4ff" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "sky": { "type": "Mix", "a": "palette.dusk", "b": "palette.sun", "weight": "x" },
             "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "x" },
             "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" } },
  "outputs": { "all": { "color": "all", "file": "sunset.png" } } }"##;

#[test]
fn a_palette_is_read_off_a_picture_and_used_by_a_document() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let out = ["--out", "p.json", "--out", "p.gpl", "--out", "p.png"];
    let run = scene.run(&[&["palette", "sunset.png"][..], &out].concat()).code(0);
    let run = run.says(&["colors in 1 picture of 1536 pixels", "  colors   hull  farthest"]);
    let palette: Value = serde_json::from_slice(&fs::read(scene.path("p.json")).unwrap()).unwrap();
    let colors = palette["palette"].as_object().unwrap();
    assert!((4..=6).contains(&colors.len()), "{palette}");
    for (name, color) in colors {
        assert!(run.out.contains(&format!("{name} ")) && run.out.contains(color.as_str().unwrap()), "{name}");
    }
    // A document takes it as it is, from either file.
    for file in ["p.json", "p.gpl"] {
        let document = SUNSET.replace("{ \"night\"", "\"FILE\" , \"notes\": { \"night\"").replace("FILE", file);
        let first = colors.keys().next().unwrap();
        let names = ["night", "dusk", "sun", "foam"];
        let named = names
            .iter()
            .fold(document, |text, name| text.replace(&format!("palette.{name}"), &format!("palette.{first}")));
        fs::write(scene.path("b.json"), named).unwrap();
        scene.run(&["check", "b.json"]).code(0);
    }
    let swatches = trochoid::io::info(scene.path("p.png"), &Default::default()).unwrap();
    assert_eq!(swatches.parts[0].display.width(), 128 * colors.len());
    // Files of ours are replaced, others are not.
    scene.run(&[&["palette", "sunset.png", "--quiet"][..], &out].concat()).code(0);
    fs::write(scene.path("p.gpl"), "GIMP Palette\n1 2 3 mine\n").unwrap();
    scene.run(&["palette", "sunset.png", "--out", "p.gpl"]).fails(2, &["p.gpl"]);
    scene.run(&["palette", "sunset.png", "--out", "sunset.png"]).fails(2, &["sunset.png"]);
}

#[test]
fn every_pixel_lies_in_the_hull_of_the_palette() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let json = scene.run(&["palette", "sunset.png", "--json"]).code(0).json();
    let picture = trochoid::io::read(scene.path("sunset.png"), &Default::default(), &Default::default()).unwrap();
    let [r, g, b] = [0, 1, 2].map(|c| picture.channels[c].plane.samples());
    for palette in json["enclosing"].as_array().unwrap() {
        let colors: Vec<[f32; 3]> = serde_json::from_value::<Vec<[f64; 3]>>(palette["colors"].clone())
            .unwrap()
            .into_iter()
            .map(|color| color.map(|v| v as f32))
            .collect();
        let hull = trochoid::Hull::new(&colors);
        for ((r, g), b) in r.iter().zip(g).zip(b) {
            let point = [f64::from(*r), f64::from(*g), f64::from(*b)];
            assert!(hull.signed_distance(point) < 1e-6, "{point:?} outside of {palette}");
        }
    }
    let parts = scene.run(&["palette", "sunset.png", "--region", "0,0,8,4", "--json"]).code(0).json();
    assert_eq!((parts["pixels"].as_u64(), json["pixels"].as_u64()), (Some(32), Some(1536)));
}

#[test]
fn what_cannot_be_done_is_told_before_anything_is_read() {
    let scene = Scene::new(SUNSET);
    scene.run(&["palette"]).fails(2, &["<PICTURE>..."]);
    scene.run(&["palette", "none.png"]).fails(1, &["none.png"]);
    scene.run(&["palette", "none.png", "--out", "p.txt"]).fails(2, &["expected .json, .gpl or .png"]);
    scene.run(&["palette", "none.png", "--region", "1,2,3"]).fails(2, &["--region", "expected four whole numbers"]);
    scene.run(&["palette", "a.json"]).fails(1, &["a.json"]);
    let gray: Vec<[f32; 3]> = (0..64).map(|v| [v as f32 / 255.0; 3]).collect();
    write_png8(scene.path("gray.png"), &PngImage::new(8, 8, Samples::rgb(&gray))).unwrap();
    scene.run(&["palette", "gray.png"]).code(0).says(&["64 colors", "#000000", "#3f3f3f"]);
    let words = ["found no palette of 5 colors that encloses every pixel; expected one of 2 colors"];
    scene.run(&["palette", "gray.png", "--colors", "5"]).fails(3, &words);
    scene.run(&["palette", "gray.png", "--region", "9,9,4,4"]).fails(2, &["none of them in a --region"]);
}

#[test]
fn stray_pixels_may_be_left_out() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let picture = trochoid::io::read(scene.path("sunset.png"), &Default::default(), &Default::default()).unwrap();
    let [r, g, b] = [0, 1, 2].map(|c| picture.channels[c].plane.samples());
    let mut pixels: Vec<[f32; 3]> = (0..r.len()).map(|at| [r[at], g[at], b[at]]).collect();
    pixels[700] = [0.0, 1.0, 0.0];
    write_png8(scene.path("stray.png"), &PngImage::new(48, 32, Samples::rgb(&pixels))).unwrap();
    let all = scene.run(&["palette", "stray.png", "--json"]).code(0).json();
    assert_eq!([&all["ignored"], &all["outside"]], [0, 0]);
    assert!(all["palette"].as_object().unwrap().values().any(|color| color == "#00ff00"), "{all}");
    let left = scene.run(&["palette", "stray.png", "--ignore", "0.001", "--json"]).code(0).json();
    assert_eq!([&left["ignored"], &left["outside"]], [1, 1]);
    assert!(left["outside_largest"].as_f64().unwrap() > 50.0, "{left}");
    let whole = scene.run(&["palette", "sunset.png", "--json"]).code(0).json();
    assert!(left["enclosing"][0]["volume"].as_f64().unwrap() < 1.5 * whole["enclosing"][0]["volume"].as_f64().unwrap());
    let words = ["1 pixel ignored; 1 outside of this palette, by up to "];
    scene.run(&["palette", "stray.png", "--ignore", "0.001"]).code(0).says(&words);
    let nothing = scene.run(&["palette", "stray.png", "--ignore", "0.0001"]).code(0);
    assert!(!nothing.out.contains("ignored"), "{}", nothing.out);
    scene.run(&["palette", "stray.png", "--ignore", "0.5"]).fails(2, &["--ignore", "a number from 0 to 0.1"]);
}

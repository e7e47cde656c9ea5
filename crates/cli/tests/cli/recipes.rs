//! Recipes that come out of renders, and pictures that come out of recipes.

use crate::scene::Scene;
use std::fs;
use trochoid::io::{Picture, read};

/// A picture of colors with and without names, at frames 1 to 3, with its recipe.
const SCENE: &str = r##"{ "trochoid": 1, "format": { "width": 40, "height": 50, "samples": 4 },
  "frames": { "first": 1, "last": 3 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "sun": { "keys": [[1, "#f0cf8e"], [3, "#c0392b"]] }, "foam": "#e8f4ff" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "sky": { "type": "Ramp", "weight": "x",
                      "stops": [{ "at": 0, "color": "palette.sun" }, { "at": 1, "color": "#5a3f5e" }] },
             "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "x" },
             "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" },
             "soft": { "type": "Blur", "image": "all", "size": 3 } },
  "outputs": { "beauty": { "color": "soft", "file": "b.####.exr", "precision": "float" },
               "weights": { "recipe": "soft", "file": "r.####.exr", "precision": "float" } } }"##;

fn picture(scene: &Scene, name: &str) -> Picture {
    read(scene.path(name), &Default::default(), &Default::default()).unwrap()
}

/// Returns the largest difference of two pictures.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.channels.iter().zip(&b.channels);
    let off = |(a, b): (&f32, &f32)| (a - b).abs();
    pairs.flat_map(|(a, b)| a.plane.samples().iter().zip(b.plane.samples()).map(off)).fold(0.0, f32::max)
}

#[test]
fn sequences_are_painted_again_as_a_render_would() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0).says(&["weights → "]);
    fs::write(
        scene.path("night.json"),
        r##"{ "sun": { "keys": [[1, "#ff0000"], [3, "#00ff00"]] }, "foam": "#0a0b0c" }"##,
    )
    .unwrap();
    let run = ["recolor", "r.####.exr", "--frames", "1-3", "--palette", "night.json", "--float", "--out", "n.####.exr"];
    scene.run(&run).code(0).says(&["r.0002.exr → n.0002.exr: 4 colors, hull, 0 outside, within 0.00/255"]);
    scene.run(&["render", "a.json", "--palette", "night.json", "--output", "beauty", "--out", "o.####.exr"]).code(0);
    for frame in 1..=3 {
        let (painted, rendered) =
            (picture(&scene, &format!("n.000{frame}.exr")), picture(&scene, &format!("o.000{frame}.exr")));
        assert!(apart(&painted, &rendered) < 1e-6, "{}", apart(&painted, &rendered));
        assert!(apart(&rendered, &picture(&scene, &format!("b.000{frame}.exr"))) > 0.1);
    }
    // The frame of a file is known from the file, too.
    scene.run(&["recolor", "r.0002.exr", "--palette", "night.json", "--float", "--out", "m.##.exr"]).code(0);
    assert_eq!(fs::read(scene.path("m.02.exr")).unwrap(), fs::read(scene.path("n.0002.exr")).unwrap());
}

#[test]
fn recipes_are_rendered_beside_pictures_on_request() {
    let scene = Scene::new(SCENE);
    let run = ["render", "a.json", "--frames", "2", "--output", "beauty", "--out", "p.png", "--recipe", "q.####.exr"];
    scene.run(&run).code(0).says(&["beauty → p.png, beauty-recipe → q.0002.exr"]);
    let recipe = scene.layers("q.0002.exr");
    let mut names: Vec<&str> = recipe.channels.iter().map(|channel| channel.full_name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["recipe.foam.Y", "recipe.night.Y", "recipe.sky_stops_1_color.Y", "recipe.sun.Y"]);
    for pixel in 0..recipe.data.area() {
        let weights = recipe.channels.iter().map(|channel| channel.plane.samples()[pixel]);
        assert!(weights.clone().all(|weight| weight >= 0.0));
        assert_eq!(weights.sum::<f32>(), 1.0, "pixel {pixel}");
    }
    // No bit depends on threads, nor on what else is rendered; a complete file is not rendered again.
    let alone = ["render", "a.json", "--frames", "2", "--threads", "1", "--unoptimized", "--output", "beauty"];
    scene.run(&[&alone[..], &["--out", "p.exr", "--recipe", "s.exr"]].concat()).code(0);
    let planes = |name: &str| scene.layers(name).channels;
    assert!(planes("s.exr") == planes("q.0002.exr"));
    scene.run(&[&run[..], &["--resume"]].concat()).code(0).says(&["up to date"]);
    // Unnamed colors are set by node and port.
    scene.run(&["recolor", "q.0002.exr", "--set", "sky.stops[1].color=#ffffff", "--out", "w.png"]).code(0);
    assert!(apart(&picture(&scene, "w.png"), &picture(&scene, "p.png")) > 0.1);
    scene.run(&["recolor", "q.0002.exr", "--out", "same.png"]).code(0);
    assert!(apart(&picture(&scene, "same.png"), &picture(&scene, "p.png")) < 1.01 / 255.0);
}

#[test]
fn recipes_share_files_but_are_never_the_main_layer() {
    let shared = SCENE.replace(r#""file": "r.####.exr""#, r#""file": "b.####.exr", "layer": """#);
    let scene = Scene::new(&shared.replace(r#""color": "soft""#, r#""color": "soft", "layer": "picture""#));
    scene.run(&["render", "a.json", "--frames", "1"]).code(0).says(&["beauty + weights → b.0001.exr"]);
    let mut names: Vec<String> = scene.layers("b.0001.exr").channels.into_iter().map(|one| one.full_name).collect();
    names.sort_unstable();
    assert_eq!(names[..4], ["picture.B", "picture.G", "picture.R", "recipe.foam.Y"]);
    scene.run(&["recolor", "b.0001.exr", "--out", "c.png"]).code(0);
}

#[test]
fn what_recipes_cannot_do_is_told() {
    let scene = Scene::new(SCENE);
    let render = |more: &[&str]| scene.run(&[&["render", "a.json", "--frames", "1"][..], more].concat());
    render(&["--output", "beauty", "--recipe", "q.png"]).fails(2, &["--recipe", "which PNG cannot hold"]);
    render(&["--output", "beauty", "--recipe", "b.0001.exr"]).fails(2, &["is the same file as"]);
    render(&["--output", "weights", "--recipe", "q.exr"]).fails(2, &["--recipe: found no output that is a color"]);
    render(&["--certificate", "c.{output}.json"]).fails(2, &["--certificate: found a recipe among the outputs"]);
    render(&["--tolerance", "reference"]).fails(2, &["the tolerance \"reference\": found a recipe"]);
    render(&["--float"]).fails(2, &["--recipe"]);
    render(&[]).code(0);
    scene.run(&["recolor", "r.####.exr", "--out", "n.png"]).fails(2, &["expected --frames"]);
    scene.run(&["recolor", "r.0001.exr", "--frames", "1-2", "--out", "n.##.png"]).fails(2, &["expected #### or %04d"]);
    scene.run(&["recolor", "r.##.exr", "--frames", "x", "--out", "n.##.png"]).fails(2, &["x"]);
}

//! Any node, and pictures at another size, without a change of the document.

use crate::scene::{SCENE, Scene};
use crate::told::Told;
use std::fs;
use trochoid::Plane;

/// A document with lists of connections, a Field, a view, and a disabled node.
const NODES: &str = r##"{ "trochoid": 1, "format": { "width": 16, "height": 8 }, "frames": { "first": 1, "last": 2 },
  "nodes": {
    "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "both": { "type": "Multiply", "weights": ["across", "down"] },
    "values": { "type": "FieldMath", "a": "across", "expression": "1000 + a" },
    "off": { "type": "Invert", "weight": "both", "disabled": true },
    "camera": { "type": "Camera" }, "sea": { "type": "RippleSea" },
    "render": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "depth": { "type": "Depth", "view": "render" },
    "parts": { "type": "Bands", "field": "across", "thresholds": [0.3, 0.6], "width": 0.1 },
    "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "off" } },
  "outputs": { "beauty": { "color": "mix", "file": "out/beauty.####.exr" } } }"##;

/// A document whose nodes stand in a group, used once.
const GROUPS: &str = r##"{ "trochoid": 1, "format": { "width": 16, "height": 8 },
  "groups": { "Half": { "inputs": { "weight": "Mask" }, "nodes": { "turned": { "type": "Invert", "weight": "weight" } },
                        "outputs": { "mask": "turned" } } },
  "nodes": { "across": { "type": "ScreenX" }, "front": { "type": "Half", "weight": "across" },
             "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "front" } },
  "outputs": { "beauty": { "color": "mix" } } }"##;

/// Returns the samples of the only channel of an EXR, which has this name.
fn only(scene: &Scene, file: &str, channel: &str) -> Vec<f32> {
    let found = trochoid::io::info(scene.path(file), &Default::default()).unwrap();
    let names: Vec<&str> = found.parts[0].channels.iter().map(|channel| channel.full_name.as_str()).collect();
    assert_eq!(names, [channel], "{file}");
    scene.layers(file).channels[0].plane.samples().to_vec()
}

/// Returns the planes of an EXR.
fn planes(scene: &Scene, file: &str) -> Vec<Plane> {
    scene.layers(file).channels.into_iter().map(|channel| channel.plane).collect()
}

fn across(x: usize) -> f32 {
    x as f32 / 15.0
}

#[test]
fn any_node_is_written_as_it_is() {
    let scene = Scene::new(NODES);
    let view = |node: &str| scene.run(&["render", "a.json", "--frames", "1", "--view", node]).code(0);
    let run = view("across").says(&["frame 1: across → across.0001.exr"]);
    assert_eq!(run.err, "");
    let mask = only(&scene, "across.0001.exr", "Y");
    assert!((0..16).all(|x| (mask[x] - across(x)).abs() < 1e-3), "{mask:?}");
    view("values");
    // Half would round them to whole numbers.
    let values = only(&scene, "values.0001.exr", "Y");
    assert!((0..16).all(|x| (values[x] - 1000.0 - across(x)).abs() < 1e-4), "{values:?}");
    view("render.coverage");
    view("depth");
    assert!(only(&scene, "depth.0001.exr", "Z").iter().any(|depth| *depth > 1.0));
    // A disabled node shows what it passes on.
    view("off");
    view("both");
    assert_eq!(planes(&scene, "off.0001.exr"), planes(&scene, "both.0001.exr"));
    assert_eq!(fs::metadata(scene.path("a.json")).unwrap().len(), NODES.len() as u64);
    assert_eq!(scene.files().len(), 6);
    // All weights, and one of them.
    view("parts");
    view("parts.2");
    let weights = planes(&scene, "parts.0001.exr");
    assert_eq!((weights.len(), &weights[2..]), (3, &planes(&scene, "parts.2.0001.exr")[..]));
}

#[test]
fn what_feeds_a_port_is_written() {
    let scene = Scene::new(NODES);
    for (port, same) in [("both.weights[1]", "down"), ("values.a", "across"), ("mix.weight", "both")] {
        for node in [port, same] {
            scene.run(&["render", "a.json", "--frames", "1", "--view", node]).code(0);
        }
        let [port, same] = [port, same].map(|name| planes(&scene, &format!("{name}.0001.exr")));
        assert_eq!(port, same);
    }
    scene.run(&["render", "a.json", "--frames", "1", "--view", "across", "--view", "down", "--out", "{output}.png"]);
    assert!(scene.path("across.png").exists() && scene.path("down.png").exists());
}

#[test]
fn nodes_of_groups_and_their_uses_are_views_too() {
    let scene = Scene::new(GROUPS);
    for node in ["front", "front.mask", "front/turned"] {
        scene.run(&["render", "a.json", "--view", node, "--out", "x.exr", "--overwrite"]).code(0);
        let mask = only(&scene, "x.exr", "Y");
        assert!((0..16).all(|x| (mask[x] - (1.0 - across(x))).abs() < 1e-3), "{node}: {mask:?}");
    }
    scene.run(&["render", "a.json", "--view", "front/turned"]).code(0).says(&["front-turned → front-turned.0001.exr"]);
    scene.run(&["render", "a.json", "--view", "front/turned.weight", "--out", "y.exr"]).code(0);
    assert!((only(&scene, "y.exr", "Y")[3] - across(3)).abs() < 1e-3);
}

#[test]
fn what_is_no_picture_is_refused_with_what_to_do() {
    let (scene, mut told) = (Scene::new(NODES), Told::new("view"));
    let cases = [
        ("a_surface", "sea"),
        ("a_view", "render"),
        ("a_camera", "render.camera"),
        ("an_unknown_node", "acros"),
        ("an_unknown_output", "render.coverge"),
        ("an_unknown_port", "mix.wieght"),
        ("neither", "mix.x"),
        ("a_value", "mix.a"),
        ("several", "both.weights"),
        ("nothing", ""),
    ];
    for (name, node) in cases {
        told.is(name, 2, &scene, &["render", "a.json", "--view", node]);
    }
    told.is("png_of_a_field", 2, &scene, &["render", "a.json", "--view", "values", "--out", "x.####.png"]);
    told.is("output_and_view", 2, &scene, &["render", "a.json", "--view", "values", "--output", "beauty"]);
    told.is("groups_output", 2, &Scene::new(GROUPS), &["render", "a.json", "--view", "front.masks"]);
    told.ends();
    scene.has_no_files();
}

#[test]
fn views_replace_no_rendered_picture_and_resume() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json", "--output", "beauty"]).code(0);
    let onto = ["render", "a.json", "--view", "across", "--frames", "1", "--out", "out/beauty.0001.exr"];
    scene.run(&onto).fails(2, &["beauty", "discard"]);
    let resumed = |more: &[&str]| {
        let command = ["render", "a.json", "--view", "across", "--frames", "1", "--out", "a.exr", "--resume"];
        scene.run(&[&command[..], more].concat()).code(0).out
    };
    assert!(!resumed(&[]).contains("up to date"));
    assert!(resumed(&[]).contains("up to date"));
    assert!(!resumed(&["--scale", "1/2", "--overwrite"]).contains("up to date"), "another size");
    assert!(resumed(&["--scale", "0.5"]).contains("up to date"));
    // An output with the name of a node is not that node.
    let command = ["render", "a.json", "--frames", "1", "--out", "b.exr", "--resume"];
    scene.run(&[&command[..], &["--output", "mask"]].concat()).code(0);
    let run = scene.run(&[&command[..], &["--view", "mix"]].concat()).code(0);
    assert!(!run.out.contains("up to date"), "{}", run.out);
}

/// Returns a document with sizes in pixels.
fn in_pixels([width, height]: [u32; 2], [radius, offset, reach, edge]: [f64; 4]) -> String {
    format!(
        r##"{{ "trochoid": 1, "format": {{ "width": {width}, "height": {height}, "samples": 4 }},
          "nodes": {{
            "disc": {{ "type": "Shape", "edge": {edge}, "shapes": [{{ "form": "disc", "radius": 0.2 }}] }},
            "soft": {{ "type": "Blur", "image": "disc", "size": {radius} }},
            "moved": {{ "type": "Warp", "image": "soft", "dx": {offset}, "reach": {reach} }},
            "mix": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "moved" }},
            "painted": {{ "type": "Strokes", "image": "mix", "anchor": "screen", "height": 64,
                        "layers": [{{ "length": 24, "width": 8, "spacing": 8 }}] }} }},
          "outputs": {{ "beauty": {{ "color": "painted", "file": "whole.exr" }} }} }}"##
    )
}

#[test]
fn a_smaller_picture_is_the_one_with_smaller_pixel_sizes() {
    let whole = Scene::new(
        &in_pixels([128, 64], [8.0, 12.0, 32.0, 4.0])
            .replace(r#""anchor": "screen", "height": 64,"#, r#""anchor": "screen","#),
    );
    whole.run(&["render", "a.json", "--scale", "1/4", "--out", "small.exr"]).code(0);
    let small = Scene::new(&in_pixels([32, 16], [2.0, 3.0, 8.0, 1.0]));
    small.run(&["render", "a.json"]).code(0);
    assert_eq!(planes(&whole, "small.exr"), planes(&small, "whole.exr"));
    // The picture is where it is in the large one.
    whole.run(&["render", "a.json"]).code(0);
    let (large, small) = (planes(&whole, "whole.exr"), planes(&whole, "small.exr"));
    let mean = |x: usize, y: usize| {
        let block = (0..16).map(|i| large[0].samples()[(4 * y + i / 4) * 128 + 4 * x + i % 4]);
        block.sum::<f32>() / 16.0
    };
    let off = (0..512).map(|i| (small[0].samples()[i] - mean(i % 32, i / 32)).abs());
    let mean = off.sum::<f32>() / 512.0;
    assert!(mean < 0.03, "{mean}");
}

#[test]
fn a_draft_replaces_no_larger_picture_unasked() {
    let scene = Scene::new(SCENE);
    let (draft, whole) = (["render", "a.json", "--frames", "1-2", "--scale", "1/2"], ["render", "a.json"]);
    scene.run(&draft).code(0);
    // Drafts replace drafts, and finished pictures replace them.
    scene.run(&draft).code(0);
    scene.run(&whole).code(0);
    let before: Vec<Vec<u8>> = scene.files().iter().map(|name| fs::read(scene.path(name)).unwrap()).collect();
    let mut told = Told::new("draft");
    told.is("over_the_finished_pictures", 2, &scene, &draft);
    told.is("over_a_recipe", 2, &scene, &{
        let recipe = ["render", "a.json", "--output", "beauty", "--frames", "1", "--out", "x.exr", "--recipe", "r.exr"];
        scene.run(&recipe).code(0);
        fs::remove_file(scene.path("x.exr")).unwrap();
        [&recipe[..], &["--scale", "1/2"]].concat()
    });
    fs::remove_file(scene.path("r.exr")).unwrap();
    told.ends();
    let after: Vec<Vec<u8>> = scene.files().iter().map(|name| fs::read(scene.path(name)).unwrap()).collect();
    assert!(before == after);
    // The whole size is no draft, and another name or the option is a way out.
    scene.run(&[&whole[..], &["--scale", "1"]].concat()).code(0);
    scene.run(&[&draft[..], &["--out", "draft.{output}.####.png", "--output", "beauty"]].concat()).code(0);
    scene.run(&[&draft[..], &["--overwrite"]].concat()).code(0);
    let found = trochoid::io::info(scene.path("out/mask.0001.png"), &Default::default()).unwrap();
    assert_eq!(found.parts[0].display.width(), 8);
}

#[test]
fn a_scale_is_a_factor_and_excludes_what_needs_the_whole() {
    let (scene, mut told) = (Scene::new(SCENE), Told::new("scale"));
    for (name, factor) in [("zero", "0"), ("larger", "2"), ("word", "half")] {
        told.is(name, 2, &scene, &["render", "a.json", "--scale", factor]);
    }
    told.is("certificate", 2, &scene, &["render", "a.json", "--scale", "1/2", "--certificate", "c.json"]);
    told.is("region", 2, &scene, &["render", "a.json", "--scale", "1/2", "--region", "0,0,16,8"]);
    told.ends();
    scene.has_no_files();
    // A tolerance of the document is for its own size.
    let scene = Scene::new(&SCENE.replace("\"nodes\":", "\"tolerance\": 1e-30, \"nodes\":"));
    scene.run(&["render", "a.json", "--frames", "1", "--output", "mask"]).code(3);
    scene.run(&["render", "a.json", "--frames", "1", "--output", "mask", "--scale", "1/2"]).code(0);
    scene.run(&["render", "a.json", "--frames", "1", "--view", "across", "--out", "x.exr"]).code(0);
}

//! `trochoid render --region` and `trochoid join`.

use crate::scene::{SCENE, Scene};
use serde_json::Value;
use std::fs;

/// A picture with noise, a filter of a filter and strokes, whose sizes are no multiples of anything.
const PAINTED: &str = r##"{ "trochoid": 1,
  "format": { "width": 83, "height": 57, "samples": 4 }, "working_space": "srgb", "frames": { "first": 1, "last": 3 },
  "palette": { "deep": "#10305a", "foam": "#f2ead2", "sun": "#d8513a" },
  "nodes": {
    "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "cells": { "type": "Noise", "kind": "ridged", "scale": 0.2 },
    "light": { "type": "Clamp", "field": "cells", "min": 0.2, "max": 0.8 },
    "sea": { "type": "Mix", "a": "palette.deep", "b": "palette.foam", "weight": "light" },
    "lit": { "type": "Mix", "a": "sea", "b": "palette.sun", "weight": "down" },
    "soft": { "type": "Blur", "image": "lit", "size": 2 },
    "softer": { "type": "Blur", "image": "soft", "size": 1.5 },
    "painted": { "type": "Strokes", "image": "softer", "layers": [{ "length": 12, "width": 4, "spacing": 6 }] } },
  "outputs": {
    "beauty": { "color": "painted", "file": "out/beauty.####.exr" },
    "light": { "weights": "light", "file": "out/light.####.exr" },
    "cells": { "field": "cells", "file": "out/cells.####.exr" },
    "shown": { "color": "painted", "file": "out/shown.####.png" },
    "deep": { "color": "painted", "file": "out/deep.####.png", "precision": "uint16" } } }"##;

/// Regions that partition the picture, none of whose rows lie as those of the whole file do.
const REGIONS: [&str; 5] = ["0,0,29,57", "29,0,54,21", "29,21,20,36", "49,21,34,7", "49,28,34,29"];

/// Renders the regions of an output at frame 2; returns the files.
fn tiles(scene: &Scene, output: &str, ending: &str) -> Vec<String> {
    let tile = |(index, region): (usize, &&str)| {
        let file = format!("tiles/{output}.{index}.{ending}");
        let own = ["render", "a.json", "--frames", "2", "--region", region, "--out", &file, "--output", output];
        scene.run(&own).code(0);
        file
    };
    REGIONS.iter().enumerate().map(tile).collect()
}

#[test]
fn tiles_are_joined_to_the_bytes_of_the_whole() {
    let scene = Scene::new(PAINTED);
    scene.run(&["render", "a.json", "--frames", "2"]).code(0);
    for file in ["beauty.0002.exr", "light.0002.exr", "cells.0002.exr", "shown.0002.png", "deep.0002.png"] {
        let (output, ending) = file.split_once(".0002.").unwrap();
        let mut tiles = tiles(&scene, output, ending);
        tiles.rotate_left(2);
        tiles.swap(0, 1);
        let joined = format!("joined/{file}");
        let named: Vec<&str> = tiles.iter().map(String::as_str).collect();
        let run = scene.run(&[&["join"], &named[..], &["-o", &joined]].concat()).code(0);
        assert_eq!(run.out, format!("5 tiles → {joined}  83 × 57\n"));
        let [whole, joined] = [format!("out/{file}"), joined].map(|file| fs::read(scene.path(&file)).unwrap());
        assert!(whole == joined, "{file}");
    }
    // What is joined is up to date.
    fs::rename(scene.path("joined/beauty.0002.exr"), scene.path("out/beauty.0002.exr")).unwrap();
    let again = ["render", "a.json", "--frames", "2", "--resume", "--output", "beauty"];
    assert!(scene.run(&again).code(0).out.ends_with("up to date\n"));
}

#[test]
fn tiles_of_recipes_are_joined_too() {
    let scene = Scene::new(PAINTED);
    let recipe = |region: Option<&str>, file: &str| {
        let more = region.map_or(Vec::new(), |region| vec!["--region", region]);
        let arguments = ["render", "a.json", "--frames", "2", "--output", "shown", "--out", "x.png", "--recipe", file];
        scene.run(&[&arguments[..], &more].concat()).code(0);
        file.to_owned()
    };
    recipe(None, "whole.exr");
    let tiles: Vec<String> =
        REGIONS.iter().enumerate().map(|(index, region)| recipe(Some(region), &format!("r{index}.exr"))).collect();
    let named: Vec<&str> = tiles.iter().map(String::as_str).collect();
    let run = scene.run(&[&["join", "--json"], &named[..], &["-o", "joined.exr"]].concat()).code(0);
    let told: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((&told["tiles"], &told["width"]), (&5.into(), &83.into()));
    assert!(fs::read(scene.path("whole.exr")).unwrap() == fs::read(scene.path("joined.exr")).unwrap());
}

#[test]
fn what_is_not_one_picture_is_refused() {
    let scene = Scene::new(PAINTED);
    let tiles = tiles(&scene, "cells", "exr");
    let named: Vec<&str> = tiles.iter().map(String::as_str).collect();
    let join = |tiles: &[&str], out: &str| scene.run(&[&["join"], tiles, &["-o", out]].concat());
    join(&named[1..], "j.exr").fails(2, &["4 tiles without 1653 of 4731 pixels", "expected tiles of all pixels"]);
    join(&[&named[..], &named[..1]].concat(), "j.exr")
        .fails(2, &["tiles/cells.0.exr: found pixels", "each pixel once"]);
    let other = |file: &str, more: &[&str]| {
        let own = ["render", "a.json", "--output", "cells", "--region", REGIONS[0], "--out", file];
        scene.run(&[&own[..], more].concat()).code(0);
    };
    other("frame.exr", &["--frames", "3"]);
    other("set.exr", &["--frames", "2", "--set", "cells.scale=0.3"]);
    for file in ["frame.exr", "set.exr"] {
        join(&[&[file], &named[1..]].concat(), "j.exr").fails(2, &["tiles/cells.1.exr: found trochoid:", file]);
    }
    scene.run(&["render", "a.json", "--frames", "2", "--output", "cells", "--out", "whole.exr"]).code(0);
    join(&["whole.exr"], "j.exr").fails(2, &["whole.exr: found a picture that is no tile"]);
    scene.run(&["render", "a.json", "--frames", "2", "--output", "shown", "--out", "whole.png"]).code(0);
    join(&["whole.png"], "j.png").fails(2, &["whole.png: found a picture that is no tile"]);
    join(&["whole.png"], "j.exr").fails(2, &["whole.png: found a PNG file"]);
    let bytes = fs::read(scene.path(named[2])).unwrap();
    fs::write(scene.path("cut.exr"), &bytes[..bytes.len() - 9]).unwrap();
    join(&[&["cut.exr"], &named[..2], &named[3..]].concat(), "j.exr").fails(1, &["cut.exr"]);
    join(&[&["none.exr"], &named[1..]].concat(), "j.exr").fails(1, &["none.exr: cannot open"]);
    join(&named, named[3]).fails(2, &["is a tile and would be overwritten"]);
    fs::write(scene.path("mine.exr"), "mine").unwrap();
    join(&named, "mine.exr").fails(2, &["mine.exr", "exists already"]);
    assert!(!scene.path("j.exr").exists() && !scene.path("j.png").exists());
    for region in ["0,0,84,57", "80,50,9,2", "83,0,1,1"] {
        let run = scene.run(&["render", "a.json", "--frames", "2", "--region", region]);
        run.fails(2, &["--region: found pixels", "expected some of the picture's"]);
    }
    for region in ["1,2,3", "a,0,1,1", "0,0,0,4", "-1,0,4,4"] {
        let run = scene.run(&["render", "a.json", "--frames", "2", &format!("--region={region}")]);
        run.fails(2, &["left, top, width and height"]);
    }
}

#[test]
fn progress_is_told_to_programs() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&["render", "a.json", "--progress", "openjd", "--json"]).code(0);
    let shares: Vec<f64> =
        run.out.lines().filter_map(|line| line.strip_prefix("openjd_progress: ")).map(|n| n.parse().unwrap()).collect();
    assert!(shares.is_sorted() && shares.first() == Some(&0.0) && shares.last() == Some(&100.0), "{shares:?}");
    assert!(run.out.lines().any(|line| line.starts_with("openjd_status: frame 1")));
    assert_eq!(run.out.lines().filter(|line| line.starts_with('{')).count(), 3);
    let run = scene.run(&["render", "a.json", "--progress", "json"]).code(0);
    let told: Vec<Value> = run.err.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(told.last().unwrap()["progress"], 100.0);
    assert!(told.iter().any(|line| line["status"] == "frame 1" && line["frame"] == 1));
    let failed = scene.run(&["render", "a.json", "--progress", "openjd", "--frames", "1", "--out", "/dev/full/x.exr"]);
    assert_ne!(failed.code, 0);
    fs::write(scene.path("in.json"), crate::scene::READS).unwrap();
    let failed = scene.run(&["render", "in.json", "--progress", "openjd"]);
    assert!(failed.out.contains("openjd_fail: "), "{} {}", failed.out, failed.err);
    scene.run(&["render", "a.json", "--quiet", "--progress", "json"]).fails(2, &["cannot be used with"]);
}

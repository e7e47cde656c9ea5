//! Runs that share a folder, and runs that go on after a failure.

use crate::scene::{SCENE, Scene};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// 200 frames, each of which takes a moment.
const MANY: &str = r##"{ "trochoid": 1,
  "format": { "width": 96, "height": 54, "samples": 16 }, "frames": { "first": 1, "last": 200 },
  "nodes": { "cells": { "type": "Noise", "kind": "cellular", "scale": 0.05, "octaves": 6,
                        "offset": { "keys": [[1, [0, 0, 0]], [200, [0, 0, 9]]] } },
             "light": { "type": "Clamp", "field": "cells", "min": 0, "max": 1 },
             "soft": { "type": "Blur", "image": "light", "size": 3 },
             "mix": { "type": "Mix", "a": "#103050", "b": "#f0e0c0", "weight": "soft" } },
  "outputs": { "beauty": { "color": "mix", "file": "out/b.####.exr" } } }"##;

/// Returns how often each frame was made, as the lines of runs say.
fn made(lines: &str, counts: &mut BTreeMap<i64, usize>) {
    for line in lines.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        if line["skipped"] != true {
            *counts.entry(line["frame"].as_i64().unwrap()).or_default() += 1;
        }
    }
}

#[test]
fn eight_runs_make_each_frame_once_also_when_three_are_killed() {
    let scene = Scene::new(MANY);
    // Files, because a run whose pipe nobody reads would wait with its claim.
    let told = tempfile::tempdir().unwrap();
    let lines = |index: usize| told.path().join(index.to_string());
    let start = |index: usize| -> Child {
        let mut command = scene.command(&["render", "a.json", "--share", "--json", "--threads", "1"]);
        command.stdout(fs::File::create(lines(index)).unwrap()).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut runs: Vec<Child> = (0..8).map(start).collect();
    let count = || scene.files().iter().filter(|file| file.starts_with("out/b.")).count();
    let started = Instant::now();
    while count() < 30 {
        assert!(started.elapsed() < Duration::from_secs(60), "{} frames in a minute", count());
        std::thread::sleep(Duration::from_millis(5));
    }
    let at_kill = count();
    runs.iter_mut().take(3).for_each(|run| run.kill().unwrap());
    let mut counts = BTreeMap::new();
    for (index, mut run) in runs.into_iter().enumerate() {
        assert_eq!(run.wait().unwrap().success(), index >= 3, "run {index}");
        // The last line of a killed run may be cut off.
        let text = fs::read_to_string(lines(index)).unwrap();
        made(&text[..text.rfind('\n').map_or(0, |end| end + 1)], &mut counts);
    }
    assert!(at_kill < 200, "they were killed in the middle");
    assert!(counts.values().all(|count| *count == 1), "{counts:?}");
    // A run that was killed may not have told of its last frame.
    assert!(counts.len() >= 197, "{}", counts.len());
    let alone = Scene::new(MANY);
    alone.run(&["render", "a.json"]).code(0);
    let files = alone.files();
    assert_eq!(scene.files(), files, "nothing is missing, and no claim is left");
    for file in files {
        assert!(fs::read(scene.path(&file)).unwrap() == fs::read(alone.path(&file)).unwrap(), "{file}");
    }
}

#[test]
fn a_frame_that_another_run_has_is_waited_for() {
    let scene = Scene::new(SCENE);
    fs::create_dir(scene.path("out")).unwrap();
    let claims = trochoid::io::Claims::new(Duration::from_secs(60));
    let claim = claims.claim(&scene.path("out/beauty.0002.exr")).unwrap().unwrap();
    let mut command = scene.command(&["render", "a.json", "--share"]);
    let run = command.stdout(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    while !scene.path("out/beauty.0003.exr").exists() {
        assert!(started.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    assert!(!scene.path("out/beauty.0002.exr").exists());
    drop(claim);
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success());
    let order: Vec<char> =
        String::from_utf8(output.stdout).unwrap().lines().map(|line| line.chars().nth(6).unwrap()).collect();
    assert_eq!(order, ['1', '3', '2']);
    let again = scene.run(&["render", "a.json", "--share"]).code(0);
    assert!(again.out.lines().all(|line| line.ends_with("up to date")), "{}", again.out);
}

#[test]
fn a_run_goes_on_after_frames_that_fail() {
    let scene = Scene::new(SCENE);
    // The picture of frame 2 is missing.
    let read = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "frames": { "first": 1, "last": 3 },
      "nodes": { "in": { "type": "Read", "file": "in.####.png", "as": "color" } },
      "outputs": { "beauty": { "color": "in", "file": "o.####.exr" } } }"##;
    fs::write(scene.path("r.json"), read).unwrap();
    for frame in [1, 3] {
        let image = trochoid::io::PngImage::new(4, 2, trochoid::io::Samples::rgb(&[[0.5; 3]; 8]));
        trochoid::io::write_png8(scene.path(&format!("in.000{frame}.png")), &image).unwrap();
    }
    let run = scene.run(&["render", "r.json"]).code(1);
    assert!(run.err.contains("frame 2") && run.err.contains("in.0002.png"), "{}", run.err);
    assert!(scene.path("o.0001.exr").exists() && !scene.path("o.0003.exr").exists());
    let run = scene.run(&["render", "r.json", "--keep-going", "--json"]).code(1);
    assert!(run.err.contains("1 of 3 frames failed: 2"), "{}", run.err);
    assert!(run.err.contains("in.0002.png"), "{}", run.err);
    let lines: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3, "one for each frame");
    assert_eq!((&lines[1]["frame"], &lines[1]["code"]), (&2.into(), &1.into()));
    assert!(lines[1]["failed"].as_str().unwrap().contains("in.0002.png"));
    assert!(scene.path("o.0003.exr").exists());
}

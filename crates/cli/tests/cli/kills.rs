//! Runs that are killed and resumed.

use crate::scene::Scene;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Default number of kills; the environment variable `TROCHOID_KILLS` sets another.
const KILLS: usize = 20;

/// Documents of several frames: EXR and PNG of a pointwise graph, EXR and PNG of a graph with a slow stage, and EXR
/// only, which is written while its rows are computed.
const DOCUMENTS: [&str; 3] = [
    r##"{ "trochoid": 1, "format": { "width": 320, "height": 180 }, "frames": { "first": 1, "last": 4 },
      "nodes": { "across": { "type": "ScreenX" }, "noise": { "type": "Noise", "scale": 0.3 },
                 "mask": { "type": "Clamp", "field": "noise", "min": -1, "max": 1 },
                 "mix": { "type": "Mix", "a": { "keys": [[1, "#102040"], [4, "#402010"]] }, "b": "#fed", "weight": "mask" } },
      "outputs": { "beauty": { "color": "mix", "file": "out/beauty.####.exr" },
                   "show": { "color": "mix", "file": "out/show.####.png" },
                   "mask": { "weights": "across", "file": "out/deep/mask.####.png", "precision": "uint16" } } }"##,
    r##"{ "trochoid": 1, "format": { "width": 96, "height": 54, "samples": 4 }, "frames": { "first": 1, "last": 3 },
      "nodes": { "camera": { "type": "Camera" }, "sea": { "type": "RippleSea" },
                 "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
                 "depth": { "type": "Depth", "view": "view" },
                 "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "view.coverage" } },
      "outputs": { "beauty": { "color": "mix", "file": "out/all.####.exr" },
                   "depth": { "field": "depth", "file": "out/all.####.exr" },
                   "show": { "color": "mix", "file": "out/show.####.png" } } }"##,
    r##"{ "trochoid": 1, "format": { "width": 320, "height": 180, "samples": 4 }, "frames": { "first": 1, "last": 3 },
      "nodes": { "noise": { "type": "Noise", "scale": 0.3, "octaves": 6 },
                 "mask": { "type": "Clamp", "field": "noise", "min": -1, "max": 1 },
                 "mix": { "type": "Mix", "a": { "keys": [[1, "#102040"], [4, "#402010"]] }, "b": "#fed", "weight": "mask" } },
      "outputs": { "beauty": { "color": "mix", "file": "out/beauty.####.exr" },
                   "mask": { "weights": "mask", "file": "out/deep/mask.####.exr" } } }"##,
];

/// Returns every file under a folder with its contents, including hidden files.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.insert(path.display().to_string(), fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn a_killed_and_resumed_run_equals_a_whole_run_and_leaves_no_partial_files() {
    let kills = std::env::var("TROCHOID_KILLS").map_or(KILLS, |kills| kills.parse().expect("a number of kills"));
    let (mut killed, mut left) = (0, 0);
    // A fixed sequence: the fractions of multiples of the golden ratio are evenly distributed.
    let moment = |kill: usize| (kill as f64 * 0.618_033_988_75).fract();
    for (number, document) in DOCUMENTS.iter().enumerate() {
        let scene = Scene::new(document);
        let out = scene.path("out");
        let started = Instant::now();
        scene.run(&["render", "a.json", "--threads", "1"]).code(0);
        let takes = started.elapsed();
        let whole = contents(&out);
        // Shares of the documents that add up to all kills.
        let share = kills * (number + 1) / DOCUMENTS.len() - kills * number / DOCUMENTS.len();
        let mut done = 0;
        while done < share {
            fs::remove_dir_all(&out).unwrap();
            // Up to four kills before a run may end, so that runs that resume are also killed.
            for _ in 0..(1 + done % 4).min(share - done) {
                let mut child =
                    scene.command(&["render", "a.json", "--threads", "1", "--resume", "--quiet"]).spawn().unwrap();
                std::thread::sleep(takes.mul_f64(moment(done)) + Duration::from_micros(200));
                child.kill().unwrap();
                killed += usize::from(child.wait().unwrap().code().is_none());
                done += 1;
            }
            left += contents(&out).keys().filter(|name| name.ends_with(".partial")).count();
            scene.run(&["render", "a.json", "--threads", "1", "--resume", "--quiet"]).code(0);
            let found = contents(&out);
            assert_eq!(found.keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>(), "after {done} kills");
            for (name, bytes) in &found {
                assert!(*bytes == whole[name], "{name} differs after {done} kills");
            }
        }
    }
    println!("{kills} kills, {killed} of them before the end, {left} partial files left and cleared up");
    // Machines differ in speed, but not so much that every run ends before its kill.
    assert!(killed > 0);
}

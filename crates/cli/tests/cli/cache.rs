//! Simulations that runs leave for each other in a folder.

use crate::scene::Scene;
use std::fs;

/// A sea that takes many steps to its frames: seconds, whatever the machine.
const SEA: &str = r##"{ "trochoid": 1, "format": { "width": 32, "height": 18 }, "frames": { "first": 1, "last": 3 },
  "nodes": {
    "camera": { "type": "Camera", "position": [4, 3, 12], "target": [4, 0, 4] },
    "waves": { "type": "ToonSea", "columns": 256, "rows": 256, "spacing": 0.05, "preroll": 2500,
               "bursts": [{ "path": [0, 0, 2, 4, 4, 4, 8, 6], "duration": 3, "height": 1 }] },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["waves"] },
    "height": { "type": "Height", "view": "view" },
    "high": { "type": "Clamp", "field": "height", "min": -0.2, "max": 0.8 },
    "sea": { "type": "Mix", "a": "#102040", "b": "#ffffff", "weight": "high" } },
  "outputs": { "beauty": { "color": "sea", "file": "out/b.####.exr" } } }"##;

fn entries(scene: &Scene) -> Vec<String> {
    scene.files().into_iter().filter(|file| file.starts_with("kept/") && file.ends_with(".entry")).collect()
}

#[test]
fn a_run_goes_on_from_what_another_one_kept() {
    let scene = Scene::new(SEA);
    let render = |more: &[&str]| scene.run(&[&["render", "a.json"], more].concat()).code(0);
    let picture = |name: &str| fs::read(scene.path(name)).unwrap();
    render(&["--frames", "1-3", "--out", "alone.####.exr"]);
    assert_eq!(
        render(&["--frames", "1", "--cache", "kept"]).err,
        "note: --cache: went on from 0 states, kept 1 state\n"
    );
    let kept = entries(&scene);
    assert_eq!(kept.len(), 1, "{kept:?}");
    let changed = || fs::metadata(scene.path(&kept[0])).unwrap().modified().unwrap();
    let before = changed();
    assert_eq!(
        render(&["--frames", "3", "--cache", "kept"]).err,
        "note: --cache: went on from 1 state, kept 0 states\n"
    );
    assert!(changed() > before, "it was read, which counts as use");
    for frame in ["0001", "0003"] {
        let [found, alone] = [format!("out/b.{frame}.exr"), format!("alone.{frame}.exr")].map(|name| picture(&name));
        assert!(found == alone, "frame {frame}");
    }
    // A damaged file is told of, and the picture is right.
    let mut bytes = picture(&kept[0]);
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(scene.path(&kept[0]), bytes).unwrap();
    let run = render(&["--frames", "2", "--cache", "kept"]);
    assert!(run.err.contains("warning: --cache: found 1 file damaged"), "{}", run.err);
    assert!(picture("out/b.0002.exr") == picture("alone.0002.exr"));
}

#[test]
fn a_folder_that_cannot_be_is_refused_before_anything_is_rendered() {
    let scene = Scene::new(SEA);
    fs::write(scene.path("kept"), "").unwrap();
    let run = scene.run(&["render", "a.json", "--frames", "1", "--cache", "kept"]).code(1);
    assert!(
        run.err.contains("error: --cache kept: ") && run.err.contains("remedy: name another folder"),
        "{}",
        run.err
    );
    assert!(!scene.path("out").exists());
    let run = scene.run(&["render", "a.json", "--cache-limit", "1GB"]).code(2);
    assert!(run.err.contains("--cache"), "{}", run.err);
}

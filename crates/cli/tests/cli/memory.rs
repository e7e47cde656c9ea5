//! Memory limits of runs, and runs that would exceed them.

use crate::scene::{Run, Scene};
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// Width and height of a picture that is small only as a file.
const SIDE: u32 = 16_000;

/// Writes a black picture with one bit per pixel.
pub(crate) fn write_large(path: &Path) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), SIDE, SIDE);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let mut rows = writer.stream_writer().unwrap();
    let row = vec![0; SIDE as usize / 8];
    (0..SIDE).for_each(|_| rows.write_all(&row).unwrap());
    rows.finish().unwrap();
}

/// Returns a document with the average of twelve nodes that read the picture.
fn twelve(node: &str, side: u32) -> String {
    let nodes: Vec<String> = (0..12).map(|index| format!(r#""n{index}": {{ {node} }},"#)).collect();
    let names: Vec<String> = (0..12).map(|index| format!(r#""n{index}""#)).collect();
    let weights = ["0.08333333333333333"; 12].join(", ");
    format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {side}, "height": {side} }}, "nodes": {{ "x": {{ "type": "ScreenX" }}, {}
            "out": {{ "type": "Blend", "colors": [{}], "weights": [{weights}] }} }},
            "outputs": {{ "out": {{ "color": "out", "file": "out.png" }} }} }}"#,
        nodes.concat(),
        names.join(", ")
    )
}

#[test]
fn many_files_that_are_too_large_together_are_refused() {
    // Each node reads another name of the picture, so that no two are merged.
    let texture = r#""type": "Texture", "file": "large.png", "as": "color", "u": "x", "v": "x""#;
    let scene = Scene::new(&twelve(texture, 8));
    write_large(&scene.path("large.png"));
    for index in 0..12 {
        std::os::unix::fs::symlink(scene.path("large.png"), scene.path(&format!("large{index}.png"))).unwrap();
    }
    let each = |text: String| {
        (0..12).fold(text, |text, index| text.replacen(r#""large.png""#, &format!(r#""large{index}.png""#), 1))
    };
    let write = |text: String| std::fs::write(scene.path("a.json"), each(text)).unwrap();
    write(twelve(texture, 8));
    let run = scene.run(&["check", "a.json", "--memory", "8GB"]);
    let run = run.code(2);
    for words in ["takes about 36.9 GB", "(Texture) 3.1 GB", "expected at most 8.0 GB", "crop or scale"] {
        assert!(run.err.contains(words), "no \"{words}\" in: {}", run.err);
    }
    scene.run(&["render", "a.json", "--memory", "8GB"]).fails(1, &["36.9 GB", "8.0 GB"]);
    assert!(!scene.path("out.png").exists());
    // A Read keeps only the pixels that the document's samples need.
    let read = r#""type": "Read", "file": "large.png", "as": "color", "fit": "nearest""#;
    write(twelve(read, 8));
    scene
        .run(&["check", "a.json", "--memory", "500MB"])
        .code(0)
        .says(&["MB of memory at frame 1, of 500.0 MB allowed"]);
    write(twelve(read, SIDE));
    scene.run(&["check", "a.json", "--memory", "8GB"]).code(2);
}

/// A picture whose tiles take much memory beside the planes of their stages: samples where it is rough, strokes, a blur.
const ROUGH: &str = r##"{
  "trochoid": 1,
  "format": { "width": 720, "height": 405, "samples": 4, "adaptive": 0.02 },
  "frames": { "first": 1, "last": 2, "fps": 24 },
  "nodes": {
    "camera": { "type": "Camera", "position": [0, 3, 10], "target": [0, 2, 0] },
    "sea": { "type": "GerstnerSea", "count": 24 },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "height": { "type": "Height", "view": "view" },
    "mask": { "type": "Clamp", "field": "height", "min": -0.1, "max": 0.1 },
    "line": { "type": "Outline", "view": "view", "width": 3 },
    "soft": { "type": "Blur", "image": "mask", "size": 12 },
    "water": { "type": "Mix", "a": "#0b2545", "b": "#8da9c4", "weight": "soft" },
    "drawn": { "type": "Mix", "a": "water", "b": "#000000", "weight": "line" },
    "painted": { "type": "Strokes", "image": "drawn", "view": "view", "layers": [{ "spacing": 4 }] }
  },
  "outputs": { "beauty": { "color": "painted", "file": "out.####.png" } }
}"##;

#[test]
fn the_memory_that_a_frame_is_said_to_take_is_enough() {
    let scene = Scene::new(ROUGH);
    for threads in ["1", "2", "16"] {
        let render = |memory: &str| scene.run(&["render", "a.json", "--threads", threads, "--memory", memory]);
        let refused = render("64MB").code(1);
        let (_, taken) = refused.err.split_once("takes about ").unwrap();
        let (megabytes, _) = taken.split_once(" MB").unwrap();
        render(&format!("{}MB", megabytes.parse::<f64>().unwrap().ceil())).code(0);
    }
}

#[test]
fn sizes_need_a_unit() {
    let scene = Scene::new(crate::scene::SCENE);
    scene.run(&["render", "a.json", "--memory", "8"]).fails(2, &["--memory", "8GB"]);
    scene.run(&["render", "a.json", "--memory", "64MB", "--quiet"]).code(0);
}

/// A picture that stays in memory as a whole, with a filter.
const WHOLE: &str = r##"{ "trochoid": 1, "format": { "width": 1500, "height": 1500 }, "nodes": {
    "noise": { "type": "Noise", "scale": 0.3 },
    "mask": { "type": "Clamp", "field": "noise", "min": -1, "max": 1 },
    "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "mask" },
    "soft": { "type": "Blur", "image": "mix", "size": 30 } },
    "outputs": { "out": { "color": "soft", "file": "out/out.png" }, "mask": { "weights": "mask", "file": "out/mask.exr" } } }"##;

#[test]
fn memory_that_the_system_refuses_is_an_error_and_leaves_no_partial_files() {
    let scene = Scene::new(WHOLE);
    let mut codes = Vec::new();
    for megabytes in (60..=1400).step_by(40) {
        let binary = env!("CARGO_BIN_EXE_trochoid");
        let script = format!("ulimit -v {} && exec {binary} render a.json --quiet --threads 2", megabytes * 1000);
        let mut command = Command::new("sh");
        let run = Run::of(command.args(["-c", &script]).current_dir(scene.path("")));
        assert!(matches!(run.code, 0 | 1), "{megabytes} MB: exit code {}: {}", run.code, run.err);
        assert!(run.code == 0 || run.err.contains("error: "), "{megabytes} MB: {}", run.err);
        let left: Vec<String> = scene.files().into_iter().filter(|file| file.contains(".partial")).collect();
        assert_eq!(left, [""; 0], "{megabytes} MB");
        if run.code == 1 {
            assert!(scene.files().len() < 2, "{megabytes} MB: {:?}", scene.files());
        }
        let _ = std::fs::remove_dir_all(scene.path("out"));
        codes.push(run.code);
        // More memory would only make the same picture again.
        if codes.ends_with(&[0, 0]) {
            break;
        }
    }
    assert!(codes.contains(&0) && codes.contains(&1), "no limit made a difference: {codes:?}");
}

#[test]
fn meshes_count_before_they_are_made() {
    let points: Vec<String> = (0..16).map(|at| format!(r#"{{ "at": [{}, 0, {}] }}"#, at % 4, at / 4)).collect();
    let patch = format!(r#"{{ "points": [{}] }}"#, points.join(", "));
    let patches = vec![patch; 60].join(", ");
    let scene = Scene::new(&format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 64, "height": 64 }}, "nodes": {{
            "camera": {{ "type": "Camera", "position": [1.5, 6, 1.6], "target": [1.5, 0, 1.5] }},
            "model": {{ "type": "BezierModel", "patches": [{patches}], "tessellation": "uniform", "segments": 256 }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["model"] }},
            "depth": {{ "type": "Depth", "view": "view" }} }},
            "outputs": {{ "depth": {{ "field": "depth", "file": "depth.exr" }} }} }}"#
    ));
    scene
        .run(&["render", "a.json", "--memory", "64MB"])
        .fails(1, &["(Render)", "fineness", "expected at most 64.0 MB"]);
    scene.has_no_files();
}

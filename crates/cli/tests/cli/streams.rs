//! Pipes, colors, full disks and interrupts.

use crate::scene::{Run, SCENE, Scene, with_unused};
use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn no_color_codes_in_a_pipe() {
    let scene = Scene::new(&with_unused());
    let all: [&[&str]; 7] = [
        &["render", "a.json"],
        &["check", "a.json"],
        &["check", "none.json"],
        &["nodes", "Mix"],
        &["info", "a.json"],
        &["--help"],
        &["render", "--nonsense"],
    ];
    for arguments in all {
        let run = scene.run(arguments);
        assert!(!run.out.contains('\u{1b}') && !run.err.contains('\u{1b}'), "{arguments:?}");
    }
    let forced = Run::of(scene.command(&["check", "a.json"]).env("CLICOLOR_FORCE", "1"));
    assert!(forced.err.starts_with('\u{1b}') && forced.out.contains('\u{1b}'));
    let refused = Run::of(scene.command(&["check", "a.json"]).env("NO_COLOR", "1"));
    assert!(!refused.err.contains('\u{1b}'));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let scene = Scene::new(SCENE);
    let all: [&[&str]; 4] = [&["render", "a.json"], &["schema"], &["nodes"], &["--help"]];
    for arguments in all {
        let mut child = scene.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    }
    assert_eq!(scene.files().len(), 6, "the frames are rendered all the same");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_code_1() {
    let scene = Scene::new(SCENE);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = scene.command(&["schema"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().contains("stdout: cannot be written"));
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_with_code_130_and_leaves_whole_files_alone() {
    let large = SCENE.replace("\"width\": 16, \"height\": 8", "\"width\": 1024, \"height\": 1024, \"samples\": 16");
    let scene = Scene::new(&large.replace("\"last\": 3", "\"last\": 5000"));
    let arguments = ["render", "a.json", "--threads", "1", "--report", "r.json"];
    let child = scene.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while !scene.path("out/mask.0001.png").exists() {
        assert!(begun.elapsed() < Duration::from_secs(120), "nothing is rendered");
        std::thread::sleep(Duration::from_millis(10));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(err.starts_with("error: interrupted"), "{err}");
    let files = scene.files();
    assert!(files.len() < 5000 && files.iter().all(|name| !name.contains("partial")), "{files:?}");
    for name in files.iter().filter(|name| name.starts_with("out/")) {
        scene.run(&["info", name]).code(0);
    }
    let report: Value = serde_json::from_slice(&fs::read(scene.path("r.json")).unwrap()).unwrap();
    assert_eq!(report["status"], "interrupted");
    assert!(!report["frames"].as_array().unwrap().is_empty());
}

/// A sea that takes much longer to compute than the process waits after an interrupt.
#[cfg(unix)]
const HEAVY: &str = r##"{ "trochoid": 1, "format": { "width": 3840, "height": 2160 },
  "nodes": { "camera": { "type": "Camera", "position": [0, 40, 0.1], "target": [0, 0, 0] },
             "sea": { "type": "GerstnerSea", "count": 20000 },
             "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
             "height": { "type": "Height", "view": "view" } },
  "outputs": { "height": { "field": "height" } } }"##;

#[cfg(unix)]
#[test]
fn an_interrupt_within_a_file_leaves_nothing_of_it() {
    // After one signal the process waits for work to stop, up to a limit; after two it does not wait.
    for interrupts in [1, 2] {
        let scene = Scene::new(HEAVY);
        let arguments = ["render", "a.json", "--out", "h.####.exr"];
        let child = scene.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        while !scene.files().iter().any(|name| name.contains("partial")) {
            assert!(begun.elapsed() < Duration::from_secs(120), "no file is begun");
            std::thread::sleep(Duration::from_millis(10));
        }
        for _ in 0..interrupts {
            // The second signal may find that the process has ended.
            Command::new("kill").args(["-INT", &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(scene.files().is_empty(), "{:?}", scene.files());
    }
}

//! Previews as movies and sequences.

use crate::scene::{SCENE, Scene};
#[cfg(unix)]
use crate::told::Told;
use std::fs;

#[test]
fn a_sequence_and_a_view_are_written_small() {
    let scene = Scene::new(SCENE);
    let run = scene.run(&["preview", "a.json", "--view", "across", "--scale", "1/4", "-o", "small/x.##.png"]).code(0);
    run.says(&["3 frames: across → small/x.##.png  4 × 2 pixels\n"]);
    assert_eq!(scene.files(), ["small/x.01.png", "small/x.02.png", "small/x.03.png"]);
    // The document is not changed, and nothing is written over.
    scene.run(&["preview", "a.json", "--frames", "1", "-o", "small/x.01.png"]).code(0);
    fs::write(scene.path("small/x.02.png"), "theirs").unwrap();
    scene.run(&["preview", "a.json", "-o", "small/x.##.png"]).fails(2, &["x.02.png", "--overwrite"]);
    assert_eq!(fs::metadata(scene.path("small/x.02.png")).unwrap().len(), 6);
}

/// Adds a program ffmpeg, which is this shell script, and runs a preview with it.
#[cfg(unix)]
fn with_ffmpeg(scene: &Scene, script: &str, more: &[&str]) -> std::process::Command {
    use std::os::unix::fs::PermissionsExt;
    let folder = scene.path("bin");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("ffmpeg");
    fs::write(&path, format!("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor to; do :; done\n{script}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = scene.command(&[&["preview", "a.json", "-o", "x.mp4"], more].concat());
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", folder.display()));
    command
}

#[cfg(unix)]
#[test]
fn a_movie_gets_all_frames_and_appears_whole() {
    use crate::scene::Run;
    let scene = Scene::new(&SCENE.replace("\"width\": 16, \"height\": 8", "\"width\": 18, \"height\": 10"));
    let script = r#"printf '%s\n' "$@" > arguments; printf '\000\000\000\010ftyp' > "$to"; cat >> "$to""#;
    let run = |more: &[&str]| Run::of(&mut with_ffmpeg(&scene, script, more));
    // 9 × 5 would be odd.
    run(&[]).code(0).says(&["3 frames: beauty → x.mp4  10 × 6 pixels\n"]);
    let length = || fs::metadata(scene.path("x.mp4")).unwrap().len() as usize;
    let end = 8 + "Trochoid ".len() + trochoid::VERSION.len();
    assert_eq!(length(), 8 + 3 * 10 * 6 * 3 + end);
    let arguments = trochoid::io::read_text(scene.path("arguments"), 10_000).unwrap();
    for word in ["10x6", "24", "rgb24", "libx264"] {
        assert!(arguments.lines().any(|line| line == word), "{word} in {arguments}");
    }
    // It is ours, so it is replaced. Frame 1 stays for 2 frames.
    run(&["--frames", "1,3"]).code(0);
    assert_eq!(length(), 8 + 2 * 10 * 6 * 3 + end);
    assert!(trochoid::io::read_text(scene.path("arguments"), 10_000).unwrap().lines().any(|line| line == "12"));
    fs::write(scene.path("x.mp4"), "theirs").unwrap();
    run(&[]).fails(2, &["x.mp4", "--overwrite"]);
    assert_eq!(scene.files(), ["arguments", "bin/ffmpeg", "x.mp4"]);
}

#[cfg(unix)]
#[test]
fn without_ffmpeg_or_if_it_fails_nothing_is_written() {
    use crate::scene::Run;
    let (scene, mut told) = (Scene::new(SCENE), Told::new("movie"));
    // A movie that is there stays.
    let written = "printf '\\000\\000\\000\\010ftyp' > \"$to\"; cat >> \"$to\"";
    assert_eq!(Run::of(&mut with_ffmpeg(&scene, written, &[])).code, 0);
    let before = trochoid::io::read_bytes(scene.path("x.mp4"), 1 << 20).unwrap();
    let failing = "cat > \"$to\"; echo \"Unknown encoder 'libx264'\" >&2; exit 1";
    told.stands("failing", 1, &Run::of(&mut with_ffmpeg(&scene, failing, &[])), &scene);
    // One that takes no frames.
    let closed = "exec <&-; echo 'half' > \"$to\"; echo 'no space left' >&2; exit 28";
    let run = Run::of(&mut with_ffmpeg(&scene, closed, &["--scale", "1"])).code(1);
    assert!(run.err.contains("no space left"), "{}", run.err);
    let mut command = with_ffmpeg(&scene, "", &[]);
    told.stands("missing", 1, &Run::of(command.env("PATH", scene.path("none"))), &scene);
    told.ends();
    assert_eq!(trochoid::io::read_bytes(scene.path("x.mp4"), 1 << 20).unwrap(), before);
    assert_eq!(scene.files(), ["bin/ffmpeg", "x.mp4"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_movie_leaves_nothing() {
    let scene = Scene::new(SCENE);
    let mut command = with_ffmpeg(&scene, "cat > \"$to\"; echo $$ > running; exec sleep 600", &[]);
    let mut child = command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    while !fs::metadata(scene.path("running")).is_ok_and(|found| found.len() > 1) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let signalled = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("interrupted"));
    let id = trochoid::io::read_text(scene.path("running"), 100).unwrap();
    let alive = std::process::Command::new("kill").args(["-0", id.trim()]).output().unwrap();
    assert!(!alive.status.success(), "ffmpeg still runs");
    assert_eq!(scene.files(), ["bin/ffmpeg", "running"]);
}

//! Malicious files and documents: each is refused with a message, or works as it should, in little memory.
//!
//! The memory is the resident memory of the whole process as the system counts it. `-- --nocapture` prints it with the
//! time.

use crate::memory::write_large;
use crate::scene::{READS, Run, SCENE, Scene};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Memory limit of any run, in bytes.
const MOST: u64 = 300_000_000;
/// Memory limit for reading a small file, in bytes.
const SMALL: u64 = 50_000_000;
/// Time after which a run is killed, because it seems to wait forever.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs a command, and checks its peak memory against a limit.
///
/// The system's high-water mark is read while the command runs, because the figure that a parent process gets at the
/// end includes the parent's own memory.
#[track_caller]
fn within(most: u64, command: &mut Command) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| fs::File::create(folder.path().join(name)).unwrap();
    let start = Instant::now();
    let mut child = command.stdout(file("out")).stderr(file("err")).spawn().unwrap();
    let of_child = |name: &str| format!("/proc/{}/{name}", child.id());
    let (program, status) = (of_child("exe"), of_child("status"));
    let own = std::env::current_exe().unwrap();
    let mut peak = 0;
    let end = loop {
        // For a moment after it is started, a child still has the parent's memory.
        let has_begun = fs::read_link(&program).is_ok_and(|program| program != own);
        let lines = if has_begun { fs::read_to_string(&status).unwrap_or_default() } else { String::new() };
        let mark = lines.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak = peak.max(mark.map_or(0, |kilobytes| kilobytes.parse::<u64>().unwrap() * 1024));
        if let Some(end) = child.try_wait().unwrap() {
            break end;
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_micros(500));
    };
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let run = Run { code: end.code().unwrap_or(-1), out: text("out"), err: text("err") };
    eprintln!("{:.2} s, {} MB: {:?}", start.elapsed().as_secs_f64(), peak / 1_000_000, command.get_args());
    assert!(peak <= most, "{peak} bytes resident: {}", run.err);
    run
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn few_pixels_of_a_huge_picture_take_little_memory() {
    let scene = Scene::new(&READS.replace("\"in.exr\"", "\"in.png\", \"fit\": \"nearest\""));
    write_large(&scene.path("in.png"));
    within(MOST, &mut scene.command(&["render", "a.json"])).code(0);
    assert_eq!(scene.files(), ["in.png", "out.exr"]);
}

#[test]
fn twelve_huge_pictures_are_refused_unread() {
    let scene = Scene::new(SCENE);
    write_large(&scene.path("0.png"));
    let mut nodes = String::new();
    for index in 0..12 {
        let _ = fs::hard_link(scene.path("0.png"), scene.path(&format!("{index}.png")));
        nodes += &format!(r#""n{index}": {{ "type": "Read", "file": "{index}.png", "as": "color" }},"#);
    }
    let names: Vec<String> = (0..12).map(|index| format!("\"n{index}\"")).collect();
    let weights = ["0.08333333333333333"; 12].join(", ");
    let document = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 16000, "height": 16000 }}, "nodes": {{ {nodes}
            "out": {{ "type": "Blend", "colors": [{}], "weights": [{weights}] }} }},
            "outputs": {{ "out": {{ "color": "out", "file": "out.exr" }} }} }}"#,
        names.join(", ")
    );
    fs::write(scene.path("a.json"), document).unwrap();
    for (command, code) in [("check", 2), ("render", 1)] {
        let run = within(MOST, &mut scene.command(&[command, "a.json", "--memory", "8GB"])).code(code);
        for words in ["takes about 36.9 GB", "(Read) 3.1 GB", "expected at most 8.0 GB"] {
            assert!(run.err.contains(words), "no \"{words}\" in: {}", run.err);
        }
    }
    assert_eq!(scene.files().len(), 12);
}

#[test]
fn a_pipe_is_no_file_to_wait_for() {
    let reads = |node: &str| {
        format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 8, "height": 8 }}, "nodes": {{
                "x": {{ "type": "ScreenX" }},
                "camera": {{ "type": "Camera", "position": [0, 1, 5], "target": [0, 0, 0] }},
                {node} }}, "outputs": {{ "out": {{ "color": "out", "file": "out.png" }} }} }}"#
        )
    };
    let view = |model: &str| {
        reads(&format!(
            r##""model": {model}, "view": {{ "type": "Render", "camera": "camera", "surfaces": ["model"] }},
            "mask": {{ "type": "Silhouette", "view": "view" }},
            "out": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "mask" }}"##
        ))
    };
    for (name, document) in [
        ("f.obj", view(r#"{ "type": "Mesh", "file": "f.obj" }"#)),
        ("f.json", view(r#"{ "type": "BezierModel", "model": "f.json" }"#)),
        ("f.png", reads(r#""out": { "type": "Read", "file": "f.png", "as": "color" }"#)),
        ("f.exr", reads(r#""out": { "type": "Read", "file": "f.exr", "as": "color" }"#)),
        ("f.png", reads(r#""out": { "type": "Texture", "file": "f.png", "as": "color", "u": "x", "v": "x" }"#)),
    ] {
        let scene = Scene::new(&document);
        pipe(&scene.path(name));
        for command in ["check", "render"] {
            let run = within(MOST, &mut scene.command(&[command, "a.json"]));
            assert!(matches!(run.code, 1 | 2), "{name}: {}", run.err);
            assert!(run.err.contains(name) && run.err.contains("a pipe"), "{name}: {}", run.err);
        }
        assert_eq!(scene.files(), [name]);
    }
    let scene = Scene::new(SCENE);
    pipe(&scene.path("pipe"));
    scene.write_picture("in.exr", 0.5);
    for arguments in [&["check", "pipe"][..], &["verify", "pipe", "in.exr"], &["info", "pipe"]] {
        let run = within(MOST, &mut scene.command(arguments));
        assert!(run.code != 0 && run.err.contains("a pipe"), "{arguments:?}: {}", run.err);
    }
}

/// Returns a small EXR that claims to have a chunk of 800 MB.
fn claiming(compression: u8) -> Vec<u8> {
    let mut bytes = [0x0131_2f76_u32.to_le_bytes(), 2_u32.to_le_bytes()].concat();
    let channels: Vec<u8> = ["B", "G", "R"]
        .iter()
        .flat_map(|name| [name.as_bytes(), &[0], &[2, 0, 0, 0], &[0; 4], &[1, 0, 0, 0, 1, 0, 0, 0]].concat())
        .chain([0])
        .collect();
    let window: Vec<u8> = [0, 0, (1 << 18) - 1, 255_i32].into_iter().flat_map(i32::to_le_bytes).collect();
    let attributes: [(&str, &str, &[u8]); 8] = [
        ("channels", "chlist", &channels),
        ("compression", "compression", &[compression]),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", &[0]),
        ("pixelAspectRatio", "float", &1_f32.to_le_bytes()),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &1_f32.to_le_bytes()),
    ];
    for (name, kind, value) in attributes {
        let length = (value.len() as i32).to_le_bytes();
        bytes.extend([name.as_bytes(), &[0], kind.as_bytes(), &[0], &length, value].concat());
    }
    bytes.push(0);
    // One chunk with all rows, as with the compression method that has the largest chunks.
    let at = bytes.len() as u64 + 8;
    bytes.extend(at.to_le_bytes());
    bytes.extend([0_i32.to_le_bytes(), 16_i32.to_le_bytes()].concat());
    bytes.extend([0x78; 16]);
    bytes
}

#[test]
fn a_small_file_that_claims_to_be_large_takes_little_memory() {
    for compression in 0..=9 {
        let scene = Scene::new(&READS.replace("\"as\"", "\"fit\": \"nearest\", \"as\""));
        let bytes = claiming(compression);
        assert!(bytes.len() < 500);
        fs::write(scene.path("in.exr"), bytes).unwrap();
        within(SMALL, &mut scene.command(&["render", "a.json"])).fails(1, &["in.exr", "the file is damaged"]);
        assert_eq!(scene.files(), ["in.exr"]);
        within(SMALL, &mut scene.command(&["info", "in.exr"]));
    }
}

#[test]
fn memory_that_the_system_refuses_leaves_nothing() {
    // Renders an output with 600 MB of address space, although much more memory is allowed.
    let render = |width: u32, height: u32, output: &str| {
        let size = format!("\"width\": {width}, \"height\": {height}");
        let scene = Scene::new(&SCENE.replace("\"width\": 16, \"height\": 8", &size));
        let binary = env!("CARGO_BIN_EXE_trochoid");
        let options = "--frames 1 --threads 2 --memory 64GB --quiet --output";
        let script = format!("ulimit -v 600000 && exec {binary} render a.json {options} {output}");
        let mut command = Command::new("sh");
        let run = within(600_000_000, command.args(["-c", &script]).current_dir(scene.path("")));
        (scene, run)
    };
    // PNG needs the whole picture.
    let (scene, run) = render(20_000, 20_000, "mask");
    run.fails(1, &["error: frame 1: out of memory for 1600000000 bytes of pictures"]);
    scene.has_no_files();
    // An EXR file is begun before the memory for its rows is taken.
    let (scene, run) = render(1 << 20, 64, "beauty");
    run.fails(1, &["error: out of memory: found", "asked for, more than the machine has left"]);
    scene.has_no_files();
    for (output, file) in [("mask", "out/mask.0001.png"), ("beauty", "out/beauty.0001.exr")] {
        let (scene, run) = render(16, 8, output);
        run.code(0);
        assert_eq!(scene.files(), [file]);
    }
}

#[test]
fn a_document_from_elsewhere_writes_beneath_its_folder_alone() {
    let elsewhere = tempfile::tempdir().unwrap();
    let victim = elsewhere.path().join("x.png");
    fs::write(&victim, "mine").unwrap();
    let scene = Scene::new(SCENE);
    fs::create_dir(scene.path("deep")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path(), scene.path("deep/link")).unwrap();
    let above = format!("../../{}/x.png", elsewhere.path().file_name().unwrap().to_string_lossy());
    for file in [victim.to_str().unwrap(), &above, "link/x.png", "link/made/x.png"] {
        fs::write(scene.path("deep/a.json"), SCENE.replace("out/mask.####.png", file)).unwrap();
        let mut command = scene.command(&["render", "a.json", "--frames", "1", "--overwrite"]);
        within(MOST, command.current_dir(scene.path("deep"))).fails(2, &["x.png", "--allow"]);
    }
    assert_eq!(fs::read(&victim).unwrap(), b"mine");
    assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 1);
}

#[test]
fn an_input_that_the_run_does_not_read_stays() {
    let reads = READS
        .replace("\"outputs\": {", "\"outputs\": { \"flat\": { \"color\": \"flat\", \"file\": \"seq.0002.exr\" },");
    let flat = r##""flat": { "type": "Constant", "color": "#345" }, "in": {"##;
    let scene = Scene::new(&reads.replace("\"in.exr\"", "\"seq.####.exr\"").replace("\"in\": {", flat));
    scene.write_picture("seq.0001.exr", 0.1);
    scene.write_picture("seq.0002.exr", 0.2);
    let before = fs::read(scene.path("seq.0002.exr")).unwrap();
    for arguments in [
        &["render", "a.json", "--frames", "1", "--output", "flat", "--overwrite"][..],
        &["render", "a.json", "--frames", "1", "--output", "beauty", "--out", "seq.0002.exr", "--overwrite"],
    ] {
        within(MOST, &mut scene.command(arguments)).fails(2, &["seq.0002.exr", "is an input of the document"]);
    }
    assert!(fs::read(scene.path("seq.0002.exr")).unwrap() == before);
}

#[test]
fn a_file_with_a_number_sign_in_its_name_can_be_read() {
    let scene = Scene::new(&READS.replace("in.exr", r"take \\#3.exr"));
    scene.write_picture("take #3.exr", 0.4);
    within(MOST, &mut scene.command(&["render", "a.json"])).code(0);
    assert_eq!(scene.files(), ["out.exr", "take #3.exr"]);
}

#[test]
fn the_next_run_removes_partial_files_of_a_killed_run() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    let whole = scene.files();
    for name in ["out/.trochoid-dead01.partial", "out/.trochoid-Xy12Zw.partial"] {
        fs::write(scene.path(name), "half a picture").unwrap();
    }
    within(MOST, &mut scene.command(&["render", "a.json", "--resume"])).code(0);
    assert_eq!(scene.files(), whole);
}

#[test]
fn one_of_two_files_of_a_frame_is_resumed_as_it_was() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    for name in ["out/beauty.0002.exr", "out/mask.0002.png"] {
        let whole = fs::read(scene.path(name)).unwrap();
        fs::remove_file(scene.path(name)).unwrap();
        within(MOST, &mut scene.command(&["render", "a.json", "--resume"])).code(0);
        assert!(fs::read(scene.path(name)).unwrap() == whole, "{name}");
    }
}

//! `trochoid job`: the folders that it writes, and what their commands render.

use crate::scene::{SCENE, Scene};
use crate::stored;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A document with its palette and a sequence in files.
const READS: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "frames": { "first": 1, "last": 2 },
  "palette": "colors/day.json",
  "nodes": { "in": { "type": "Read", "file": "in/./a.##.exr", "as": "color" },
             "mix": { "type": "Mix", "a": "in", "b": "palette.sun", "weight": 0.5 } },
  "outputs": { "beauty": { "color": "mix" } } }"##;

fn reads() -> Scene {
    let scene = Scene::new(READS);
    for folder in ["in", "colors"] {
        fs::create_dir(scene.path(folder)).unwrap();
    }
    scene.write_picture("in/a.01.exr", 0.25);
    scene.write_picture("in/a.02.exr", 0.5);
    scene.write_picture("in/a.03.exr", 0.75);
    fs::write(scene.path("colors/day.json"), r##"{ "sun": "#f0cf8e" }"##).unwrap();
    fs::write(scene.path("night.json"), r##"{ "sun": "#102040" }"##).unwrap();
    scene
}

fn text(scene: &Scene, name: &str) -> String {
    fs::read_to_string(scene.path(name)).unwrap()
}

fn template(scene: &Scene, folder: &str) -> Value {
    serde_json::from_str(&text(scene, &format!("{folder}/template.json"))).unwrap()
}

/// Returns the arguments of a step's command.
fn arguments(template: &Value, step: usize) -> Vec<String> {
    let arguments = template["steps"][step]["script"]["actions"]["onRun"]["args"].as_array().unwrap();
    arguments.iter().map(|argument| argument.as_str().unwrap().to_owned()).collect()
}

/// Asserts that a file of a job is the stored one.
#[track_caller]
fn is_stored(scene: &Scene, name: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/told/job").join(name.replace('/', "."));
    stored::holds(&path, &text(scene, name)).unwrap();
}

#[test]
fn templates_and_scripts_are_the_stored_ones() {
    let scene = Scene::new(SCENE);
    let all =
        ["--chunk", "2", "--tiles", "3x2", "--wedge", "mix.b=#fff,#f00", "--set", "mix.a=#012", "--minutes", "90"];
    for engine in ["openjd", "slurm"] {
        let run = scene.run(&[&["job", "a.json", "--engine", engine, "-o", engine], &all[..]].concat()).code(0);
        assert_eq!(run.err, "");
        run.says(&["24 tasks, and 6 tasks to join tiles, of 4 threads"]);
    }
    for name in ["openjd/template.json", "slurm/job.sh", "slurm/join.sh", "slurm/submit.sh"] {
        is_stored(&scene, name);
    }
    // Without tiles nothing is joined, and scripts of the former job do not stay.
    scene.run(&["job", "a.json", "--engine", "slurm", "-o", "slurm"]).code(0).says(&["slurm: 1 task, of 4 threads"]);
    assert!(!scene.path("slurm/join.sh").exists());
    scene.run(&["job", "a.json", "--engine", "openjd", "-o", "slurm"]).code(0);
    let left = ["job.sh", "submit.sh"].map(|name| scene.path("slurm").join(name).exists());
    assert_eq!(left, [false, false]);
}

#[test]
fn the_time_of_a_task_is_measured_and_its_cache_passed_on() {
    let scene = Scene::new(SCENE);
    let all = ["job", "a.json", "--engine", "slurm", "--chunk", "2", "--measure", "--cache", "kept"];
    let run = scene.run(&[&all[..], &["--tiles", "2x2", "-o", "farm"]].concat()).code(0);
    run.says(&["and at most 3 minutes each", "a task takes 0.", " s here: its first frame 0.", "% of it is done anew"]);
    let script = text(&scene, "farm/job.sh");
    assert!(script.contains("#SBATCH --time=3\n"), "{script}");
    assert!(script.contains(&format!("--cache={}", scene.path("kept").display())), "{script}");
    let given = scene.run(&[&all[..], &["--minutes", "7", "-o", "farm"]].concat()).code(0);
    given.says(&["and at most 7 minutes each", "a task takes"]);
    assert!(!scene.path("out").exists() && !scene.path("kept").exists(), "nothing is rendered");
    // What cannot be written is not measured.
    fs::write(scene.path("here"), "").unwrap();
    let run = scene.run(&[&all[..], &["-o", "here"]].concat()).code(2);
    assert!(!run.out.contains("takes"), "{}", run.out);
}

/// Runs the script of a Slurm job as its array does, with the program under test in place of an installed one.
fn run_array(scene: &Scene, folder: &str) {
    let script = text(scene, &format!("{folder}/job.sh"));
    let last = script.split_once("--array=0-").unwrap().1.lines().next().unwrap();
    for task in 0..=last.parse::<usize>().unwrap() {
        let mut bash = Command::new("bash");
        bash.arg("job.sh").current_dir(scene.path(folder)).env("SLURM_ARRAY_TASK_ID", task.to_string());
        let done = bash.env("TROCHOID", env!("CARGO_BIN_EXE_trochoid")).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    }
}

#[cfg(unix)]
#[test]
fn a_copy_renders_the_same_bytes_as_the_document() {
    let scene = reads();
    let named = ["--palette", "night.json", "--set", "mix.weight=0.25"];
    scene.run(&[&["job", "a.json", "--engine", "slurm", "--chunk", "1", "-o", "farm"], &named[..]].concat()).code(0);
    let copied: Vec<String> = scene.files().into_iter().filter(|name| name.starts_with("farm/")).collect();
    let expected = [
        "farm/graph/a.json",
        "farm/graph/colors/day.json",
        "farm/graph/in/a.01.exr",
        "farm/graph/in/a.02.exr",
        "farm/job.sh",
        "farm/palette/night.json",
        "farm/submit.sh",
        "farm/trochoid-job.json",
    ];
    assert_eq!(copied, expected, "only what these frames need");
    scene.run(&[&["render", "a.json", "--out", "{output}.####.exr"], &named[..]].concat()).code(0);
    // The folder is moved: it needs nothing else.
    fs::rename(scene.path("farm"), scene.path("it's $HOME 2")).unwrap();
    fs::remove_dir_all(scene.path("in")).unwrap();
    fs::remove_file(scene.path("a.json")).unwrap();
    run_array(&scene, "it's $HOME 2");
    for name in ["beauty.0001.exr", "beauty.0002.exr"] {
        let [whole, farm] = [scene.path(name), scene.path("it's $HOME 2/out").join(name)]
            .map(|p| scene.layers(&p.display().to_string()));
        let samples = |picture: &trochoid::io::Picture| -> Vec<f32> {
            picture.channels.iter().flat_map(|channel| channel.plane.samples().to_vec()).collect()
        };
        assert_eq!(samples(&whole), samples(&farm));
    }
}

#[cfg(unix)]
#[test]
fn a_wedge_has_a_folder_for_each_value_and_a_task_skips_what_is_done() {
    let scene = Scene::new(SCENE);
    let wedge = ["--wedge", "mix.b=#fff,#f00,\"#0f0\"", "--frames", "1-3", "--chunk", "2", "--output", "beauty"];
    scene.run(&[&["job", "a.json", "--engine", "slurm", "-o", "farm"], &wedge[..]].concat()).code(0);
    run_array(&scene, "farm");
    for (value, folder) in [("#fff", "_fff"), ("#f00", "_f00"), ("#0f0", "__0f0_")] {
        let set = format!("mix.b={value}");
        scene
            .run(&["render", "a.json", "--output", "beauty", "--set", &set, "--out", "w.####.exr", "--overwrite"])
            .code(0);
        for frame in 1..=3 {
            let found = scene.path(&format!("farm/out/mix.b={folder}/beauty.000{frame}.exr"));
            let [found, expected] = [found, scene.path(&format!("w.000{frame}.exr"))].map(|path| {
                let picture = scene.layers(path.to_str().unwrap());
                picture.channels.iter().flat_map(|channel| channel.plane.samples().to_vec()).collect::<Vec<f32>>()
            });
            assert_eq!(found, expected, "{value}");
        }
    }
    let first = scene.path("farm/out/mix.b=_fff/beauty.0001.exr");
    let written = fs::metadata(&first).unwrap().modified().unwrap();
    // Written again, the job is the same, and its copies are as old as before.
    scene.run(&[&["job", "a.json", "--engine", "slurm", "-o", "farm"], &wedge[..]].concat()).code(0);
    run_array(&scene, "farm");
    assert_eq!(fs::metadata(&first).unwrap().modified().unwrap(), written);
}

#[cfg(unix)]
#[test]
fn a_task_is_tried_again_only_if_another_try_may_succeed() {
    let scene = Scene::new(SCENE);
    scene.run(&["job", "a.json", "--engine", "slurm", "-o", "farm"]).code(0);
    fs::create_dir(scene.path("bin")).unwrap();
    let program = |name: &str, body: &str| {
        use std::os::unix::fs::PermissionsExt;
        fs::write(scene.path("bin").join(name), format!("#!/bin/sh\n{body}\n")).unwrap();
        fs::set_permissions(scene.path("bin").join(name), fs::Permissions::from_mode(0o755)).unwrap();
    };
    program("scontrol", "echo \"$@\"");
    let path = format!("{}:{}", scene.path("bin").display(), std::env::var("PATH").unwrap());
    for (code, restarts, requeues) in [
        (0, "", false),
        (1, "", true),
        (1, "2", true),
        (1, "3", false),
        (2, "", false),
        (3, "1", false),
        (130, "", false),
        (137, "", true),
        (137, "3", false),
        (139, "1", true),
        (143, "", false),
        (127, "", false),
    ] {
        program("trochoid", &format!("exit {code}"));
        let mut bash = Command::new("bash");
        bash.arg("job.sh").current_dir(scene.path("farm")).env("PATH", &path).env("SLURM_ARRAY_TASK_ID", "0");
        bash.env("SLURM_ARRAY_JOB_ID", "7").env("SLURM_RESTART_COUNT", restarts).env_remove("TROCHOID");
        let run = crate::scene::Run::of(&mut bash);
        assert_eq!((run.code, run.out.as_str()), (code, if requeues { "requeue 7_0\n" } else { "" }), "{}", run.err);
        assert_eq!(run.err.contains("export TROCHOID="), code == 127, "{}", run.err);
    }
}

#[test]
fn words_of_users_stay_what_they_are() {
    let scene = Scene::new(SCENE);
    let name = "a b'$c`d`\n#.json";
    fs::rename(scene.path("a.json"), scene.path(name)).unwrap();
    let out = r#"it's $(x) `y` "z"! {output}.####.exr"#;
    let set = "mix.b= \"#fff\"\n";
    let job = |engine: &str| {
        let more = ["--output=beauty", "--set", set, "--out", out, "-o", engine];
        scene.run(&[&["job", name, "--engine", engine], &more[..]].concat()).code(0)
    };
    job("openjd");
    let found = arguments(&template(&scene, "openjd"), 0);
    assert!(
        found.contains(&format!("--set={set}")) && found.contains(&format!("{{{{Param.Out}}}}/{out}")),
        "{found:?}"
    );
    assert_eq!(template(&scene, "openjd")["parameterDefinitions"][0]["default"], format!("graph/{name}"));
    if cfg!(unix) {
        job("slurm");
        run_array(&scene, "slurm");
        let picture = r#"slurm/out/it's $(x) `y` "z"! beauty.0003.exr"#;
        assert!(scene.path(picture).exists(), "{:?}", scene.files());
    }
}

#[test]
fn texts_that_an_engine_would_read_otherwise_are_refused() {
    let scene = Scene::new(SCENE);
    fs::rename(scene.path("a.json"), scene.path("{{Param.Out}}.json")).unwrap();
    let job = ["job", "{{Param.Out}}.json", "-o", "farm", "--engine"];
    scene.run(&[&job[..], &["openjd"]].concat()).fails(2, &["two braces in a row", "expected none", "remedy: "]);
    assert!(!scene.path("farm").exists());
    scene.run(&[&job[..], &["slurm"]].concat()).code(0);
    let scene = Scene::new(SCENE);
    let scattered: Vec<String> = (0..600).map(|n: i64| (n * n).to_string()).collect();
    let job = ["job", "a.json", "-o", "farm", "--frames", &scattered.join(","), "--engine", "openjd"];
    scene.run(&job).fails(2, &["--frames: found a list of ", "expected at most 1024", "several jobs"]);
}

#[test]
fn tiles_are_named_and_joined_by_the_pattern() {
    let scene = Scene::new(SCENE);
    let job = ["job", "a.json", "--engine", "openjd", "--frames", "-2-1", "--tiles", "2x1", "-o", "farm"];
    scene.run(&[&job[..], &["--out", "{output}/b.%03d.exr"]].concat()).code(0).says(&["2 tasks, and 4 tasks to join"]);
    let template = template(&scene, "farm");
    let found = arguments(&template, 0);
    let out = "{{Param.Out}}/tiles/{output}/b.%03d.t{{Task.Param.Tile}}.exr";
    assert!(found.windows(2).any(|pair| pair == ["--out", out]), "{found:?}");
    let definitions = &template["steps"][0]["parameterSpace"]["taskParameterDefinitions"];
    assert_eq!(definitions[2]["range"], serde_json::json!(["0,0,8,8", "8,0,8,8"]));
    assert_eq!(template["steps"][1]["dependencies"][0]["dependsOn"], "Render");
    if !cfg!(unix) {
        return;
    }
    // The script names the same files as `render`.
    let script = template["steps"][1]["script"]["embeddedFiles"][0]["data"].as_str().unwrap();
    fs::write(scene.path("join.sh"), script).unwrap();
    let run = crate::scene::Run::of(
        Command::new("bash").args(["join.sh", "echo", "o u t", "-2"]).current_dir(scene.path("")),
    );
    let line = |name: &str| {
        let tile = |tile: usize| format!("o u t/tiles/{name}/b.-002.t000{tile}.exr");
        format!("join {} {} -o o u t/{name}/b.-002.exr\n", tile(0), tile(1))
    };
    assert_eq!(run.code(0).out, line("beauty") + &line("mask"));
}

#[test]
fn shared_documents_are_named_by_their_place() {
    let scene = reads();
    fs::create_dir(scene.path("other")).unwrap();
    fs::rename(scene.path("in"), scene.path("other/in")).unwrap();
    fs::create_dir(scene.path("doc")).unwrap();
    fs::rename(scene.path("colors"), scene.path("doc/colors")).unwrap();
    let document = READS.replace("in/./a", "../other/in/a");
    fs::write(scene.path("doc/a.json"), document).unwrap();
    let job = ["job", "doc/a.json", "--engine", "openjd", "-o", "farm"];
    scene.run(&job).fails(2, &["other/in/a.01.exr: found a file outside of the document's folder", "--shared"]);
    let shared = [&job[..], &["--shared"]].concat();
    scene.run(&shared).fails(2, &["node \"in\"", "--allow "]);
    let run = scene.run(&[&shared[..], &["--allow", "other"]].concat()).code(0);
    run.says(&["openjd run farm/template.json -p ", "Graph=", "doc/a.json"]);
    let values: Value = serde_json::from_str(&text(&scene, "farm/parameter_values.json")).unwrap();
    let document = values["parameterValues"][0]["value"].as_str().unwrap().to_owned();
    assert!(Path::new(&document).is_absolute() && Path::new(&document).ends_with("doc/a.json"), "{document}");
    let found = arguments(&template(&scene, "farm"), 0);
    let allowed = found.iter().find_map(|argument| argument.strip_prefix("--allow=")).unwrap();
    assert!(Path::new(allowed).is_absolute() && allowed.ends_with("other"), "{found:?}");
    assert!(!scene.path("farm/graph").exists());
}

#[test]
fn absolute_and_missing_inputs_are_told() {
    let scene = reads();
    let absolute = scene.path("in/a.##.exr").display().to_string();
    fs::write(scene.path("b.json"), READS.replace("in/./a.##.exr", &absolute)).unwrap();
    let document = scene.path("b.json").display().to_string();
    let job = ["job", &document, "--engine", "slurm", "-o", "farm"];
    scene.run(&job).fails(2, &["node \"in\", file: found the absolute path", "--shared"]);
    let job = ["job", "a.json", "--engine", "slurm", "-o", "farm", "--frames", "1-5"];
    scene.run(&job).fails(1, &["a.04.exr: found no file", "reads it at frame 4", "a.05.exr"]);
    assert!(!scene.path("farm").exists());
}

#[test]
fn folders_of_others_stay_as_they_are() {
    let scene = Scene::new(SCENE);
    fs::create_dir(scene.path("mine")).unwrap();
    fs::write(scene.path("mine/job.sh"), "mine").unwrap();
    let job = |folder: &str| scene.run(&["job", "a.json", "--engine", "slurm", "-o", folder]);
    job("mine").fails(2, &["mine: found a folder with files of others", "new or empty", "name another folder"]);
    job("a.json").fails(2, &["a.json: found a file; expected a folder"]);
    job(".").fails(2, &["found a folder with files of others"]);
    assert_eq!(text(&scene, "mine/job.sh"), "mine");
    fs::create_dir(scene.path("farm")).unwrap();
    job("farm").code(0);
    fs::write(scene.path("farm/join.sh"), "mine").unwrap();
    fs::write(scene.path("farm/notes.txt"), "mine").unwrap();
    job("farm").code(0);
    let tiles = ["job", "a.json", "--engine", "slurm", "-o", "farm", "--tiles", "2x2"];
    scene.run(&tiles).fails(2, &["join.sh: exists already, and no job wrote it"]);
    assert_eq!([text(&scene, "farm/join.sh"), text(&scene, "farm/notes.txt")], ["mine", "mine"]);
    fs::write(scene.path("farm/trochoid-job.json"), "{").unwrap();
    job("farm").fails(2, &["that lists no files"]);
    // A document within the job is not copied over itself.
    job("other").code(0);
    let own = ["job", "other/graph/a.json", "--engine", "slurm", "-o", "other"];
    scene.run(&own).fails(2, &["is an input of the document and would be overwritten"]);
}

#[test]
fn wrong_options_are_told_with_what_to_do() {
    let scene = Scene::new(SCENE);
    let job = |more: &[&str]| scene.run(&[&["job", "a.json", "-o", "farm", "--engine", "slurm"], more].concat());
    scene.run(&["job", "a.json", "-o", "farm", "--engine", "make"]).fails(2, &["make", "openjd", "slurm"]);
    job(&["--frames", "9-1"]).fails(2, &["--frames: found \"9-1\"", "1-9"]);
    job(&["--tiles", "4"]).fails(2, &["--tiles", "4x2"]);
    job(&["--tiles", "17x1"]).fails(2, &["more tiles than pixels", "16x8"]);
    job(&["--tiles", "2x2", "--out", "{output}.####.png"]).fails(2, &["expected .exr with --tiles"]);
    job(&["--out", "../{output}.####.exr"]).fails(2, &["may lead out of the output folder"]);
    job(&["--out", "b.####.exr"]).fails(2, &["--out", "one name", "{output}"]);
    job(&["--wedge", "mix"]).fails(2, &["--wedge mix", "NODE.KNOB"]);
    job(&["--wedge", "mix.c=1,2"]).fails(2, &["error: --wedge mix.c=1: node \"mix\""]);
    job(&["--set", "palette=a.gpl"]).fails(2, &["give the palette as --palette a.gpl"]);
    job(&["--chunk", "0"]).fails(2, &["--chunk"]);
    job(&["--frames", "1-200000", "--chunk", "1"])
        .fails(2, &["found 200000 tasks; expected at most 100000", "--chunk"]);
    scene.has_no_files();
    let run = job(&["--frames", "1-2000", "--chunk", "1", "--quiet"]).code(0);
    assert!(run.out.is_empty() && run.err.contains("MaxArraySize"), "{}", run.err);
    let help = scene.run(&["job", "--help"]).code(0).says(&["Usage: trochoid", "Examples:"]);
    assert!(help.out.lines().all(|line| line.chars().count() <= 100), "{}", help.out);
}

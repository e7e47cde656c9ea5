//! Remedies work as printed.

use crate::scene::{READS, Run, SCENE, Scene};
use std::fs;

/// Returns the text of the last remedy of a run.
#[track_caller]
fn remedy(run: &Run) -> &str {
    let (_, remedy) = run.err.rsplit_once("  remedy: ").unwrap_or_else(|| panic!("no remedy in: {}", run.err));
    remedy.trim_end()
}

/// Runs the program with arguments in shell syntax, in a folder of the scene.
fn in_shell(scene: &Scene, folder: &str, words: &str) -> Run {
    let program = env!("CARGO_BIN_EXE_trochoid");
    let mut shell = std::process::Command::new("sh");
    Run::of(shell.args(["-c", &format!("'{program}' {words}")]).current_dir(scene.path(folder)))
}

/// Runs commands of a remedy, which call the program by its name.
#[track_caller]
fn pasted(scene: &Scene, commands: &str) {
    let program = env!("CARGO_BIN_EXE_trochoid");
    let script = format!("set -e; trochoid() {{ '{program}' \"$@\"; }}; {commands}");
    Run::of(std::process::Command::new("sh").args(["-c", &script]).current_dir(scene.path(""))).code(0);
}

/// A picture of two colors.
const PAINTED: &str = r##"{ "trochoid": 1, "format": { "width": 12, "height": 8 }, "working_space": "srgb",
  "nodes": { "x": { "type": "ScreenX" }, "mix": { "type": "Mix", "a": "#102030", "b": "#f0e0c0", "weight": "x" } },
  "outputs": { "mix": { "color": "mix", "file": "it's in.png" } } }"##;

/// That picture, half covered.
const HALF: &str = r##"{ "trochoid": 1, "format": { "width": 12, "height": 8 }, "working_space": "srgb",
  "nodes": { "in": { "type": "Read", "file": "it's in.png", "as": "color" },
             "half": { "type": "Mix", "a": "in", "b": "#fff", "weight": 0.5 } },
  "outputs": { "half": { "color": "half", "file": "half.png" } } }"##;

#[test]
fn pictures_become_documents_and_recipes_as_the_remedies_say() {
    let scene = Scene::new(PAINTED);
    scene.run(&["render", "a.json"]).code(0);
    let after = |run: &Run, word: &str| remedy(run).split_once(word).expect(word).1.to_owned();
    let run = scene.run(&["check", "it's in.png"]).code(2);
    pasted(&scene, &after(&run, "for a picture, make one first: "));
    scene.run(&["render", "repainted.json"]).code(0);
    for command in [&["page", "it's in.png", "-o", "p.html"][..], &["recolor", "it's in.png", "--out", "r.png"]] {
        let run = scene.run(command).code(2);
        pasted(&scene, &after(&run, "or make one: "));
        scene.run(&[&[command[0], "it's in.recipe.exr"], &command[2..]].concat()).code(0);
    }
    fs::write(scene.path("half.json"), HALF).unwrap();
    scene.run(&["render", "half.json", "--recipe", "half.exr"]).code(0);
    let run = scene.run(&["page", "half.exr", "-o", "p.html"]).code(2);
    pasted(&scene, &after(&run, "take the finished picture apart: "));
    scene.run(&["page", "half.recipe.exr", "-o", "p.html"]).code(0);
    // A recipe that is damaged is no picture.
    let recipe = fs::read(scene.path("half.recipe.exr")).unwrap();
    let at = recipe.windows(6).position(|bytes| bytes == b"colors").unwrap();
    let damaged = [&recipe[..at], b"kolors", &recipe[at + 6..]].concat();
    fs::write(scene.path("damaged.exr"), damaged).unwrap();
    let run = scene.run(&["recolor", "damaged.exr", "--out", "r.png"]).code(2);
    assert_eq!(remedy(&run), "render its document with --recipe FILE");
}

#[test]
fn signs_in_folders_and_names_can_be_escaped_as_the_remedy_says() {
    let cases = [
        ("take #3", "in.exr"),
        ("take #3", "a#1.exr"),
        ("100%02d", "in.exr"),
        ("take #3", "seq.####.exr"),
        ("##/50%04d", "x#.exr"),
    ];
    for (folder, name) in cases {
        let scene = Scene::new(&READS.replace("in.exr", &format!("{folder}/{name}")));
        fs::create_dir_all(scene.path(folder)).unwrap();
        scene.write_picture(&format!("{folder}/{}", name.replace("####", "0001")), 0.5);
        let run = scene.run(&["render", "a.json"]).code(1);
        let checked = scene.run(&["check", "a.json"]).code(0);
        assert!(checked.err.contains("that is part of a name: "), "{}", checked.err);
        let (_, told) = run.err.split_once("that is part of a name: ").unwrap_or_else(|| panic!("{}", run.err));
        let (json, word) = told.trim_end().split_once(" in a document, ").unwrap();
        let word = word.strip_suffix(" in a shell").unwrap();
        in_shell(&scene, "", &format!("render a.json --set in.file={word}")).code(0);
        let written = READS.replace("\"in.exr\"", json);
        fs::write(scene.path("a.json"), written).unwrap();
        scene.run(&["render", "a.json"]).code(0);
    }
}

#[test]
fn one_remedy_allows_all_that_is_refused() {
    let scene = Scene::new("");
    let folders = ["shot", "it's #1 \"a\"", "new $HOME"];
    for folder in &folders[..2] {
        fs::create_dir(scene.path(folder)).unwrap();
    }
    scene.write_picture("it's #1 \"a\"/in.exr", 0.5);
    let document = READS
        .replace("\"in.exr\"", r#""../it's \\#1 \"a\"/in.exr""#)
        .replace("\"out.exr\"", "\"../new $HOME/out.exr\"")
        .replace(
            "\"outputs\": {",
            "\"outputs\": { \"more\": { \"color\": \"in\", \"file\": \"../new $HOME/more.exr\" },",
        );
    fs::write(scene.path("shot/a.json"), document).unwrap();
    for command in ["render", "check"] {
        let run = Run::of(scene.command(&[command, "a.json"]).current_dir(scene.path("shot"))).code(2);
        assert_eq!(run.err.matches("error: ").count(), 3, "{}", run.err);
        assert_eq!(run.err.matches("  remedy: ").count(), 1, "{}", run.err);
        let options = remedy(&run).strip_prefix("if you trust the document with these files: ").unwrap();
        in_shell(&scene, "shot", &format!("{command} a.json {options}")).code(0);
    }
    assert!(scene.path("new $HOME/more.exr").exists());
    let strict = scene.run(&["render", "shot/a.json", "--strict"]).code(2);
    let told = remedy(&strict).strip_prefix("--strict restricts the document to its own folder: add ").unwrap();
    let (options, without) = told.split_once("; or omit --strict").unwrap();
    assert!(without.contains("current folder"), "{told}");
    in_shell(&scene, "", &format!("render shot/a.json --strict {options}")).code(0);
    scene.run(&["render", "shot/a.json"]).code(0);
    // In another folder, omitting --strict would not help.
    let strict = Run::of(scene.command(&["render", "a.json", "--strict"]).current_dir(scene.path("shot"))).code(2);
    assert!(!remedy(&strict).contains("or omit"), "{}", strict.err);
    let json = Run::of(scene.command(&["check", "a.json", "--json"]).current_dir(scene.path("shot"))).code(2).json();
    let faults = json["diagnostics"].as_array().unwrap();
    assert!(faults.len() == 3 && faults.iter().all(|fault| fault["remedy"] == faults[0]["remedy"]), "{json:#}");
}

#[test]
fn a_late_frame_beside_a_file_that_is_allowed_is_refused_before_the_first() {
    let scene = Scene::new("");
    fs::create_dir(scene.path("shot")).unwrap();
    fs::write(scene.path("shot/a.json"), SCENE.replace("out/mask", "../new/mask")).unwrap();
    let arguments = ["render", "a.json", "--output", "mask", "--allow", "../new/mask.0001.png"];
    let run = Run::of(scene.command(&arguments).current_dir(scene.path("shot"))).code(2);
    assert!(run.err.contains("new/mask.0002.png"), "{}", run.err);
    assert!(!scene.path("new").exists());
}

#[test]
fn check_says_what_strict_demands() {
    let scene = Scene::new(READS);
    let run = scene.run(&["check", "a.json", "--strict"]).code(2);
    assert!(run.err.contains("found 1 warning; expected none: --strict treats warnings as errors"), "{}", run.err);
    assert_eq!(remedy(&run), "fix the warnings, or omit --strict");
}

#[test]
fn an_allowed_path_that_does_not_exist_is_warned_of_once() {
    let scene = Scene::new(SCENE);
    for command in [&["render", "a.json", "--tolerance", "exact"][..], &["check", "a.json"]] {
        let run = scene.run(&[command, &["--allow", "no such", "--allow", "."]].concat()).code(0);
        assert_eq!(run.err.matches("warning: --allow 'no such': found nothing there").count(), 1, "{}", run.err);
        assert_eq!(run.err.matches("warning: ").count(), 1, "{}", run.err);
    }
}

#[test]
fn a_number_sign_in_the_name_of_a_still_is_noted_with_the_name_that_is_written() {
    let still = SCENE.replace(r#""frames": { "first": 1, "last": 3 },"#, "");
    let scene = Scene::new(&still);
    let render = |out: &str| scene.run(&["render", "a.json", "--output", "beauty", "--out", out]).code(0);
    let run = render("take #3.png").says(&["beauty → take 13.png"]);
    assert!(
        run.err.contains("note: --out 'take #3.png': the # stands for the frame, so the file is 'take 13.png'"),
        "{}",
        run.err
    );
    let option = remedy(&run).strip_prefix("if the # is part of the name: ").unwrap();
    in_shell(&scene, "", &format!("render a.json --output beauty {option}")).code(0);
    assert!(scene.path("take #3.png").exists());
    for plain in ["a.####.png", "a.#.png", r"take \#3.png", "a.png"] {
        assert_eq!(render(plain).err, "", "{plain}");
    }
    let frames = Scene::new(SCENE);
    assert_eq!(frames.run(&["render", "a.json", "--output", "beauty", "--out", "take #.png"]).code(0).err, "");
}

#[test]
fn the_memory_that_a_remedy_names_is_enough() {
    let scene = Scene::new(&SCENE.replace("\"width\": 16, \"height\": 8", "\"width\": 4000, \"height\": 2000"));
    let run = scene.run(&["render", "a.json", "--frames", "1", "--threads", "1", "--memory", "64MB"]).code(1);
    assert!(!run.err.contains("Settings"), "{}", run.err);
    let (_, enough) = remedy(&run).split_once("; or allow more: --memory ").unwrap();
    for command in ["render", "preview"] {
        let more: &[&str] = if command == "preview" { &["-o", "x.webp"] } else { &["--threads", "1"] };
        let with = |memory: &str| {
            scene.run(&[&[command, "a.json", "--frames", "1", "--memory", memory, "--quiet"], more].concat())
        };
        assert!(with("64MB").code(1).err.contains("--memory "), "{command}");
        if command == "render" {
            with(enough).code(0);
        }
    }
    let scene = Scene::new(READS);
    scene.write_picture("in.exr", 0.5);
    scene.run(&["render", "a.json", "--certificate", "c.json"]).code(0);
    scene.run(&["verify", "c.json", "out.exr", "--memory", "64MB"]).code(0);
}

//! Which files a run writes, wherever their names lead.

use crate::scene::{SCENE, Scene};
use std::fs;

/// Three outputs in one EXR a frame.
fn shared() -> Scene {
    let outputs = r#""outputs": { "beauty": { "color": "mix", "file": "all.####.exr" },
        "z": { "weights": "across", "file": "all.####.exr" }, "w": { "weights": "across", "file": "./all.####.exr" } } }"#;
    Scene::new(&format!("{}{outputs}", SCENE.split("\"outputs\"").next().unwrap()))
}

#[test]
fn outputs_of_a_shared_file_are_not_removed_unasked() {
    let scene = shared();
    scene.run(&["render", "a.json"]).code(0);
    let whole = fs::read(scene.path("all.0002.exr")).unwrap();
    let z = ["render", "a.json", "--output", "z"];
    let words = [
        "all.0001.exr: found the outputs beauty, w in it",
        "all.0003.exr: found the outputs beauty, w in it",
        "remedy: render all of them: --output z --output beauty --output w; or give another name, such as --out 'z.####.exr'",
        "--overwrite",
    ];
    scene.run(&z).fails(2, &words);
    scene.run(&[&z[..], &["--resume"]].concat()).fails(2, &words);
    let refused = scene.run(&[&z[..], &["--frames", "9,2"]].concat()).code(2);
    assert_eq!(refused.err.matches("error: ").count(), 1, "frame 9 is not there yet: {}", refused.err);
    assert_eq!(fs::read(scene.path("all.0002.exr")).unwrap(), whole);
    // By another name of the file, and together with other faults.
    let named = [&z[..], &["--out", "../{output}/all.####.exr"]].concat();
    let folder = scene.path("").canonicalize().unwrap().file_name().unwrap().to_str().unwrap().to_owned();
    let named: Vec<String> = named.iter().map(|part| part.replace("{output}", &folder)).collect();
    let named: Vec<&str> = named.iter().map(String::as_str).collect();
    scene.run(&named).fails(2, &["found the outputs beauty, w in it", "give --out another name"]);
    fs::write(scene.path("r.json"), "theirs").unwrap();
    scene.run(&[&z[..], &["--report", "r.json"]].concat()).fails(2, &["r.json", "beauty, w in it"]);
    // The commands that the remedies suggest.
    scene.run(&["render", "a.json", "--output", "z", "--output", "beauty", "--output", "w"]).code(0);
    scene.run(&[&z[..], &["--out", "z.####.exr"]].concat()).code(0);
    scene.run(&[&z[..], &["--overwrite"]].concat()).code(0);
    // A file that contains nothing else has nothing to lose.
    scene.run(&z).code(0);
    scene.run(&[&z[..], &["--resume"]].concat()).code(0).says(&["up to date"]);
    scene.run(&["render", "a.json", "--output", "z", "--output", "w"]).code(0);
    scene.run(&["render", "a.json", "--output", "beauty"]).fails(2, &["found the outputs z, w in it"]);
}

#[test]
fn extensions_are_checked_before_anything_is_written() {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    let before = fs::read(scene.path("out/mask.0002.png")).unwrap();
    let refused = |command: &[&str], words: &[&str]| scene.run(command).fails(2, words);
    refused(&["graph", "a.json", "-o", "g"], &["--out g: found no extension; expected .svg", "name it g.svg"]);
    refused(&["graph", "a.json", "-o", "out/mask.0002.png"], &["found the extension .png; expected .svg"]);
    refused(&["render", "a.json", "--report", "r.exr"], &["--report r.exr: found the extension .exr; expected .json"]);
    let plan = ["plan", "a.json", "--tolerance", "1/8", "-o"];
    refused(&[&plan[..], &["dusk.png"]].concat(), &["found the extension .png; expected .json", "name it dusk.json"]);
    assert_eq!(fs::read(scene.path("out/mask.0002.png")).unwrap(), before);
    #[cfg(unix)]
    scene.run(&["graph", "a.json", "-o", "/dev/null"]).code(0);
}

#[test]
fn our_files_of_another_kind_are_not_replaced_unasked() {
    let scene = Scene::new(SCENE);
    let frame = ["render", "a.json", "--frames", "1", "--output", "beauty", "--out"];
    scene.run(&[&frame[..], &["x.exr", "--certificate", "c.json", "--report", "r.json"]].concat()).code(0);
    scene.run(&["plan", "a.json", "--tolerance", "1/8", "-o", "p.json"]).code(0);
    let plan =
        |out: &str, more: &[&str]| scene.run(&[&["plan", "a.json", "--tolerance", "1/8", "-o", out], more].concat());
    for name in ["c.json", "r.json"] {
        plan(name, &[]).fails(2, &[name, "of another kind", "--overwrite"]);
    }
    let report = |name: &str| scene.run(&["render", "a.json", "--frames", "1", "--report", name]);
    for name in ["x.exr", "c.json", "p.json"] {
        report(name).fails(2, &[name, "of another kind", "--overwrite"]);
    }
    plan("c.json", &["--overwrite"]).code(0);
    plan("c.json", &[]).code(0);
    report("r.json").code(0);
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_two_pictures_into_one_file() {
    use std::os::unix::fs::symlink;
    let outputs = r#""outputs": { "a": { "color": "mix", "file": "a.####.png" }, "b": { "weights": "across", "file": "b.####.png" } } }"#;
    let scene = Scene::new(&format!("{}{outputs}", SCENE.split("\"outputs\"").next().unwrap()));
    let one = ["render", "a.json", "--frames", "1"];
    // Links to an existing file, and to a file that does not exist yet.
    for there in [true, false] {
        if there {
            scene.run(&["render", "a.json", "--frames", "1", "--output", "a"]).code(0);
        }
        symlink("a.0001.png", scene.path("b.0001.png")).unwrap();
        scene.run(&one).fails(2, &["output \"b\", file", "is the file of several outputs, of \"a\" as well"]);
        scene.run(&[&one[..], &["--out", "{output}.####.png"]].concat()).fails(2, &["of \"a\" as well"]);
        fs::remove_file(scene.path("b.0001.png")).unwrap();
        let _ = fs::remove_file(scene.path("a.0001.png"));
    }
    // Another frame of the same output, and companions of pictures.
    symlink("a.0001.png", scene.path("a.0002.png")).unwrap();
    let both = ["render", "a.json", "--frames", "1-2", "--output", "a"];
    scene.run(&both).fails(2, &["a.0002.png: is the same file as ", "a.0001.png", "remove the link"]);
    fs::remove_file(scene.path("a.0002.png")).unwrap();
    symlink("e.2.exr", scene.path("e.1.exr")).unwrap();
    scene
        .run(&[&both[..], &["--error", "e.#.exr"]].concat())
        .fails(2, &["e.2.exr: is a file of the document or of the run"]);
    assert!(!scene.path("a.0001.png").exists(), "nothing was rendered");
    // Hard links are two files again once one is written.
    scene.run(&one).code(0);
    fs::remove_file(scene.path("b.0001.png")).unwrap();
    fs::hard_link(scene.path("a.0001.png"), scene.path("b.0001.png")).unwrap();
    scene.run(&one).code(0);
    assert_ne!(fs::read(scene.path("a.0001.png")).unwrap(), fs::read(scene.path("b.0001.png")).unwrap());
}

#[cfg(unix)]
#[test]
fn links_to_missing_files_are_followed() {
    use std::os::unix::fs::symlink;
    let scene = Scene::new(SCENE);
    let one = ["render", "a.json", "--frames", "1", "--output"];
    fs::create_dir(scene.path("out")).unwrap();
    symlink("../store/deep/b.exr", scene.path("out/beauty.0001.exr")).unwrap();
    symlink("../store/m.png", scene.path("out/mask.0001.png")).unwrap();
    scene.run(&[&one[..], &["beauty"]].concat()).code(0);
    scene.run(&[&one[..], &["mask"]].concat()).code(0);
    for (link, file) in [("out/beauty.0001.exr", "store/deep/b.exr"), ("out/mask.0001.png", "store/m.png")] {
        assert!(scene.path(link).is_symlink() && scene.path(file).is_file() && !scene.path(file).is_symlink());
    }
    symlink("store/new/g.svg", scene.path("g.svg")).unwrap();
    scene.run(&["graph", "a.json", "-o", "g.svg"]).code(0);
    assert!(scene.path("g.svg").is_symlink() && scene.path("store/new/g.svg").is_file());
    symlink("loop.svg", scene.path("loop.svg")).unwrap();
    scene.run(&["graph", "a.json", "-o", "loop.svg"]).fails(1, &["loop.svg", "a link that leads to itself"]);
    // The document must be allowed to write where the link leads.
    let elsewhere = Scene::new("");
    symlink(elsewhere.path("new/x.exr"), scene.path("out/beauty.0002.exr")).unwrap();
    let two = ["render", "a.json", "--frames", "2", "--output", "beauty"];
    let folder = elsewhere.path("").canonicalize().unwrap();
    scene.run(&two).fails(2, &["output \"beauty\", file", &format!("--allow {}", folder.join("new").display())]);
    scene.run(&[&two[..], &["--allow", folder.join("new").to_str().unwrap()]].concat()).code(0);
    assert!(scene.path("out/beauty.0002.exr").is_symlink() && folder.join("new/x.exr").is_file());
}

#[test]
fn two_frame_patterns_in_a_name_are_refused() {
    let scene = Scene::new(SCENE);
    let out = |pattern: &str| scene.run(&["render", "a.json", "--frames", "1", "--output", "beauty", "--out", pattern]);
    for (pattern, remedy) in [
        ("dir#/x.%04d.png", r#""dir\\#/x.%04d.png" in a shell"#),
        ("%04d_####.png", r#""\\%04d_####.png" in a shell"#),
        ("##_##.png", r#""\\#\\#_##.png" in a shell"#),
    ] {
        out(pattern).fails(2, &["--out", "found two frame patterns in", "expected one", remedy]);
    }
    scene.has_no_files();
    out(r"dir\#/x.%04d.png").code(0);
    assert_eq!(scene.files(), ["dir#/x.0001.png"]);
    let named = Scene::new(&SCENE.replace("out/mask.####.png", "take#1/mask.####.png"));
    let words = [
        r#"a.json:6:"#,
        "output \"mask\", file: found two frame patterns",
        r#""take\\#1/mask.####.png" in a document"#,
    ];
    named.run(&["render", "a.json"]).fails(2, &words);
    named.run(&["check", "a.json"]).fails(2, &words);
}

#[test]
fn impossible_names_are_refused_with_their_place_and_a_remedy() {
    let still = SCENE.replace("out/mask.####.png", "dusk.png");
    Scene::new(&still).run(&["render", "a.json"]).fails(
        2,
        &[
            "a.json:6:55: output \"mask\", file: \"dusk.png\" gives all frames one name\n  remedy: add #### or %04d to it, such \
             as \"dusk.####.png\"",
        ],
    );
    let layers = SCENE
        .replace("out/mask.####.png", "all.##.exr\", \"layer\": \"beauty")
        .replace("out/beauty.####.exr", "all.##.exr");
    let words = ["a.json:6:", "output \"mask\", layer: two outputs are the layer \"beauty\" of ", "another \"layer\""];
    Scene::new(&layers).run(&["check", "a.json"]).fails(2, &words);
    let one = ["render", "a.json", "--frames", "1"];
    Scene::new(SCENE).run(&[&one[..], &["--out", "{output}.tif"]].concat()).fails(
        2,
        &["--out '{output}.tif': \"{output}.tif\" has an extension that cannot be written\n  remedy: let the name end with .exr"],
    );
    Scene::new(SCENE).run(&[&one[..], &["--out", "x.exr"]].concat()).fails(
        2,
        &["--out x.exr: the pattern \"x.exr\" gives 2 outputs one name\n  remedy: add {output} to it, or choose one output"],
    );
}

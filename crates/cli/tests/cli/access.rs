//! The files that a document may read and write.

use crate::scene::{READS, Run, SCENE, Scene};
use std::fs;
use std::path::Path;

/// Creates a folder with `shot/a.json`, which reads `../shared/in.exr`, and with that file.
fn beside() -> Scene {
    let scene = Scene::new("");
    for folder in ["shot", "shared", "other"] {
        fs::create_dir(scene.path(folder)).unwrap();
    }
    fs::write(scene.path("shot/a.json"), READS.replace("in.exr", "../shared/in.exr")).unwrap();
    scene.write_picture("shared/in.exr", 0.5);
    scene
}

/// Runs a command in a folder of the scene.
fn run_in(scene: &Scene, folder: &str, arguments: &[&str]) -> Run {
    Run::of(scene.command(arguments).current_dir(scene.path(folder)))
}

const REFUSED: [&str; 4] = [
    "a.json:2:46: node \"in\", file: found the file",
    "shared/in.exr",
    "expected a file that the document may reach, beneath",
    "remedy: ",
];

#[test]
fn a_document_reads_beneath_its_folder_and_the_current_one() {
    let scene = beside();
    scene.run(&["render", "shot/a.json"]).code(0);
    assert!(scene.path("shot/out.exr").exists());
    fs::remove_file(scene.path("shot/out.exr")).unwrap();
    // A document that is reached by `..` does not lie under the current folder.
    for folder in ["shot", "other"] {
        let document = if folder == "shot" { "a.json" } else { "../shot/a.json" };
        run_in(&scene, folder, &["render", document]).fails(2, &REFUSED);
        let remedy = format!("--allow {}", scene.path("shared").canonicalize().unwrap().display());
        run_in(&scene, folder, &["render", document]).fails(2, &[&remedy]);
        assert!(!scene.path("shot/out.exr").exists(), "nothing is evaluated");
        run_in(&scene, folder, &["render", document, "--allow", "../shared"]).code(0);
        fs::remove_file(scene.path("shot/out.exr")).unwrap();
        run_in(&scene, folder, &["render", document, "--allow", "../shared/in.exr"]).code(0);
        fs::remove_file(scene.path("shot/out.exr")).unwrap();
        run_in(&scene, folder, &["render", document, "--allow", "../shared/other.exr"]).fails(2, &REFUSED);
    }
}

#[test]
fn strict_leaves_a_document_its_own_folder() {
    let scene = beside();
    scene.run(&["render", "shot/a.json", "--strict"]).fails(2, &REFUSED);
    scene.run(&["render", "shot/a.json", "--strict", "--allow", "shared"]).code(0);
    scene.write_picture("shot/in.exr", 0.5);
    fs::write(scene.path("shot/a.json"), READS).unwrap();
    scene.run(&["render", "shot/a.json", "--strict"]).code(0);
}

#[test]
fn what_the_command_line_names_is_allowed() {
    let scene = beside();
    let shared = scene.path("shared/in.exr").display().to_string();
    let set = format!("in.file={shared}");
    let out = scene.path("other/out.exr").display().to_string();
    run_in(&scene, "shot", &["render", "a.json", "--set", &set, "--out", &out, "--report", "../other/r.json"]).code(0);
    assert!(scene.path("other/out.exr").exists() && scene.path("other/r.json").exists());
    // A plan has fewer rights than the command line.
    let plan = format!(
        r#"{{"trochoid_plan": 1, "document_hash": "", "frame": 1, "tolerance": "1/64", "set": {{"in.file": "{shared}"}},
            "predicted_seconds": 1, "certified": {{}}}}"#
    );
    fs::write(scene.path("shot/plan.json"), plan).unwrap();
    fs::write(scene.path("shot/a.json"), READS).unwrap();
    let planned = run_in(&scene, "shot", &["render", "a.json", "--plan", "plan.json"]);
    planned.fails(2, &["plan.json: found an assignment to \"in.file\"; expected accuracy knobs only"]);
}

#[test]
fn outputs_go_where_the_document_may_write() {
    let scene = beside();
    fs::write(scene.path("shot/a.json"), SCENE.replace("out/mask", "../other/new/mask")).unwrap();
    let place = "a.json:6:55: output \"mask\", file: found the file";
    run_in(&scene, "shot", &["render", "a.json"]).fails(2, &[place, "other/new/mask.0001.png", "--allow "]);
    run_in(&scene, "shot", &["check", "a.json"]).fails(2, &[place]);
    assert!(!scene.path("other/new").exists() && !scene.path("shot/out").exists());
    // Outputs that are not written need no permission.
    run_in(&scene, "shot", &["render", "a.json", "--output", "beauty"]).code(0);
    run_in(&scene, "shot", &["preview", "a.json", "-o", "x.webp"]).code(0);
    run_in(&scene, "shot", &["render", "a.json", "--out", "{output}.##.exr"]).code(0);
    run_in(&scene, "shot", &["render", "a.json", "--allow", "../other/new"]).code(0);
    assert!(scene.path("other/new/mask.0003.png").exists());
    scene.run(&["render", "shot/a.json", "--strict"]).fails(2, &["mask"]);
    scene.run(&["render", "shot/a.json"]).code(0);
}

#[test]
fn commands_that_open_files_need_access() {
    let scene = beside();
    run_in(&scene, "shot", &["check", "a.json"]).fails(2, &REFUSED);
    let json = run_in(&scene, "shot", &["check", "a.json", "--json"]).code(2).json();
    assert_eq!((json["valid"].as_bool(), json["diagnostics"][0]["line"].as_u64()), (Some(false), Some(2)));
    for command in [
        &["preview", "a.json", "-o", "x.png"][..],
        &["plan", "a.json", "--tolerance", "exact", "-o", "x.json"],
        &["report", "a.json", "-o", "x", "--size", "0", "--pixels", "1"],
    ] {
        run_in(&scene, "shot", command).fails(2, &REFUSED);
        assert_eq!(fs::read_dir(scene.path("shot")).unwrap().count(), 1, "{command:?}");
        run_in(&scene, "shot", &[command, &["--allow", "../shared"]].concat()).code(0);
        for name in ["x.png", "x.json"] {
            let _ = fs::remove_file(scene.path("shot").join(name));
        }
    }
    run_in(&scene, "shot", &["check", "a.json", "--allow", "../shared", "--explain"]).code(0);
    // These commands open none of the document's files.
    run_in(&scene, "shot", &["graph", "a.json", "-o", "-"]).code(0);
    run_in(&scene, "shot", &["stability", "a.json"]).code(0);
}

#[test]
fn the_document_in_a_certificate_has_no_more_access_than_others() {
    let scene = beside();
    scene.run(&["render", "shot/a.json", "--out", "other/a.exr", "--certificate", "other/c.json"]).code(0);
    scene.run(&["verify", "other/c.json", "other/a.exr"]).code(0);
    let verify = |more: &[&str]| run_in(&scene, "other", &[&["verify", "c.json", "a.exr"], more].concat());
    verify(&[]).fails(2, &["c.json: document", "node \"in\", file: found the file", "shared/in.exr", "--allow "]);
    verify(&["--allow", "../shared"]).code(0);
    verify(&["--document", "../shot/a.json"]).fails(2, &["shared/in.exr"]);
    scene.run(&["verify", "other/c.json", "other/a.exr", "--strict"]).fails(2, &["shared/in.exr"]);
}

#[test]
fn a_file_that_only_a_late_frame_reads_is_refused_before_the_first() {
    let scene = beside();
    let document = READS
        .replace("in.exr", "####/in.exr")
        .replace("\"nodes\"", "\"frames\": { \"first\": 1, \"last\": 3 }, \"nodes\"");
    fs::write(scene.path("shot/a.json"), document.replace("out.exr", "out.#.exr")).unwrap();
    for frame in 1..3 {
        fs::create_dir(scene.path(&format!("shot/000{frame}"))).unwrap();
        scene.write_picture(&format!("shot/000{frame}/in.exr"), 0.5);
    }
    link(&scene.path("shared"), &scene.path("shot/0003"));
    run_in(&scene, "shot", &["render", "a.json"]).fails(2, &["0003/in.exr, which leads to ", "shared/in.exr"]);
    assert!(!scene.path("shot/out.1.exr").exists());
    run_in(&scene, "shot", &["render", "a.json", "--frames", "1-2"]).code(0);
}

#[cfg(unix)]
fn link(target: &Path, link: &Path) {
    std::os::unix::fs::symlink(target, link).unwrap();
}

#[cfg(windows)]
fn link(target: &Path, link: &Path) {
    std::os::windows::fs::symlink_dir(target, link).unwrap();
}

#[test]
fn links_count_by_where_they_lead() {
    let scene = beside();
    link(&scene.path("shared"), &scene.path("shot/within"));
    fs::write(scene.path("shot/a.json"), READS.replace("in.exr", "within/in.exr")).unwrap();
    run_in(&scene, "shot", &["render", "a.json"]).fails(2, &["within/in.exr, which leads to ", "shared/in.exr"]);
    fs::write(scene.path("shot/a.json"), SCENE.replace("out/mask", "within/new/mask")).unwrap();
    run_in(&scene, "shot", &["render", "a.json"]).fails(2, &["output \"mask\"", "shared/new/mask"]);
    assert!(!scene.path("shared/new").exists());
    // A folder that is reached through a link is still the document's own.
    link(&scene.path("shot"), &scene.path("alias"));
    fs::write(scene.path("shot/a.json"), SCENE).unwrap();
    run_in(&scene, "other", &["render", "../alias/a.json"]).code(0);
}

#[cfg(unix)]
#[test]
fn a_link_does_not_lead_writing_elsewhere() {
    let scene = Scene::new("");
    fs::create_dir_all(scene.path("shot/in/deep")).unwrap();
    std::os::unix::fs::symlink("in/deep", scene.path("shot/link")).unwrap();
    for (file, inside) in [("link/../../../made.exr", None), ("link/../made.exr", Some("shot/in/made.exr"))] {
        let document = SCENE.replace("out/beauty.####.exr", file).replace("\"mask\":", "\"m\":");
        fs::write(scene.path("shot/a.json"), document).unwrap();
        let render = ["render", "shot/a.json", "--output", "beauty", "--frames", "1", "--strict"];
        match inside {
            Some(written) => {
                scene.run(&render).code(0);
                assert!(scene.path(written).exists(), "{written}");
            }
            None => {
                scene.run(&["check", "shot/a.json", "--strict"]).code(2);
                scene.run(&render).fails(2, &["file", "remedy: "]);
            }
        }
        assert!(!scene.path("made.exr").exists() && !scene.path("shot/made.exr").exists());
    }
}

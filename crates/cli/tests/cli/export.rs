//! `trochoid export`.

use crate::scene::{SCENE, Scene};
use crate::told::Told;
use std::fs;

#[test]
fn shaders_go_to_stdout_or_into_files() {
    let scene = Scene::new(SCENE);
    let export = |more: &[&str]| scene.run(&[&["export", "a.json", "--bind", "across"], more].concat());
    let glsl = export(&["--to", "glsl"]).code(0).says(&["// Trochoid ", "vec3 beauty(float across)\n"]);
    assert_eq!(glsl.err, "");
    export(&["--to", "osl"]).code(0).says(&["// Trochoid ", "shader beauty(\n", "output color result"]);
    export(&["--to", "materialx"]).code(0).says(&["<!-- Trochoid ", "<nodegraph name=\"NG_beauty\"", "lin_rec709"]);
    scene.has_no_files();
    export(&["--to", "glsl", "-o", "out/x.glsl"]).code(0).says(&["beauty as glsl → out/x.glsl\n"]);
    assert_eq!(fs::read_to_string(scene.path("out/x.glsl")).unwrap(), glsl.out);
    export(&["--to", "osl", "--output", "mask"]).code(0).says(&["The mask \"mask\" of a.json", "output float result"]);
}

#[test]
fn knobs_are_those_of_the_frame_and_of_the_command_line() {
    let scene =
        Scene::new(&SCENE.replace("\"b\": \"#fff\"", r#""b": { "keys": [[1, [0.25, 0.5, 1]], [3, [0.75, 1, 0]]] }"#));
    let export = |more: &[&str]| {
        scene.run(&[&["export", "a.json", "--to", "glsl", "--bind", "across"], more].concat()).code(0).out
    };
    for (more, color) in [
        (&[][..], "vec3(0.25, 0.5, 1.0)"),
        (&["--frame", "2"], "vec3(0.5, 0.75, 0.5)"),
        (&["--frame", "2", "--set", "mix.b=[0,0,0.125]"], "vec3(0.0, 0.0, 0.125)"),
    ] {
        let text = export(more);
        assert!(text.contains(color), "{text}");
    }
}

#[test]
fn exports_that_are_refused_write_nothing() {
    let (scene, mut told) = (Scene::new(SCENE), Told::new("export"));
    let cases: [(&str, &[&str]); 7] = [
        ("unbound", &["--to", "glsl", "-o", "x.glsl"]),
        ("unknown_node", &["--to", "glsl", "--bind", "acros", "-o", "x.glsl"]),
        ("constants", &["--to", "glsl", "--bind", "palette.deep", "--bind", "knobs.storm"]),
        ("unknown_output", &["--to", "osl", "--bind", "across", "--output", "beaty", "-o", "x.osl"]),
        ("unknown_language", &["--to", "hlsl", "--bind", "across"]),
        ("unknown_ending", &["--to", "materialx", "--bind", "across", "-o", "x.xml"]),
        ("over_the_document", &["--to", "glsl", "--bind", "across", "-o", "a.json"]),
    ];
    for (name, arguments) in cases {
        told.is(name, 2, &scene, &[&["export", "a.json"], arguments].concat());
    }
    told.ends();
    scene.has_no_files();
    // What is not read is told, and does not stop the export.
    let scene = Scene::new(&crate::scene::with_unused());
    let run = scene.run(&["export", "a.json", "--to", "glsl", "--bind", "across", "--bind", "lost"]).code(0);
    assert!(run.out.contains("vec3 beauty(float across, float lost)"), "{}", run.out);
    assert!(run.err.contains("warning: --bind lost: the output does not depend on it"), "{}", run.err);
}

#[test]
fn documents_need_no_size_and_may_read_what_they_are_allowed() {
    let sized = Scene::new(SCENE).run(&["export", "a.json", "--to", "glsl", "--bind", "across"]).code(0).out;
    let scene = Scene::new(&SCENE.replace("\"format\": { \"width\": 16, \"height\": 8 }, ", ""));
    assert_eq!(scene.run(&["export", "a.json", "--to", "glsl", "--bind", "across"]).code(0).out, sized);
    let elsewhere = tempfile::tempdir().unwrap();
    let palette = elsewhere.path().join("palette.json");
    fs::write(&palette, r##"{ "deep": "#204060" }"##).unwrap();
    let path = palette.display().to_string();
    let named = format!("\"trochoid\": 1, \"palette\": {},", serde_json::json!(path));
    let scene = Scene::new(&SCENE.replace("\"trochoid\": 1,", &named).replace("\"#000\"", "\"palette.deep\""));
    let export = ["export", "a.json", "--to", "glsl", "--bind", "across"];
    let refused = scene.run(&export).code(2).err;
    assert!(refused.contains("--allow"), "{refused}");
    let allowed = scene.run(&[&export[..], &["--allow", &path]].concat()).code(0).out;
    assert!(allowed.contains("vec3(0.014443844, 0.051269457, 0.116970666)"), "{allowed}");
}

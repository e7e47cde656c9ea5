#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::*;
use crate::{Buffers, Cache, Plan, Settings, Silent, parse, write_output};

fn graph(outputs: &str) -> CheckedGraph {
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }},
          "nodes": {{ "camera": {{ "type": "Camera" }}, "sea": {{ "type": "GerstnerSea", "count": 0 }},
                      "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
                      "depth": {{ "type": "Depth", "view": "view" }}, "x": {{ "type": "ScreenX" }},
                      "mix": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" }} }},
          "outputs": {{ {outputs} }} }}"##
    );
    parse("a.json", &text, Path::new("scenes/../scenes"), &[]).unwrap().graph
}

#[test]
fn two_spellings_of_a_file_are_one_file() {
    let graph = graph(r#""a": { "color": "mix", "file": "./k.exr" }, "b": { "weights": "x", "file": "sub/../k.exr" }"#);
    let files = output_files(&graph, &[0, 1], 1, false, None).unwrap();
    assert_eq!(files, [OutputFile { path: "scenes/k.exr".into(), outputs: vec![0, 1] }]);
    assert_eq!(normalized(Path::new("../../a/./b/../c")), Path::new("../../a/c"));
}

#[cfg(unix)]
#[test]
fn what_stands_behind_a_link_is_not_crossed_out() {
    let held = tempfile::tempdir().unwrap();
    let folder = held.path().canonicalize().unwrap();
    std::fs::create_dir_all(folder.join("own/in/deep")).unwrap();
    std::os::unix::fs::symlink("in/deep", folder.join("own/link")).unwrap();
    let inner = folder.join("own/link/../k.exr");
    assert_eq!(normalized(&inner), inner);
    assert_eq!(normalized(&folder.join("own/in/../k.exr")), folder.join("own/k.exr"));
    // The path that is checked is the path that is written, whatever it looks like.
    let text = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "nodes": { "x": { "type": "ScreenX" } },
        "outputs": { "a": { "weights": "x", "file": "FILE" } } }"##;
    for (file, written) in [
        ("link/../k.exr", Some("own/in/k.exr")),
        ("link/../../k.exr", Some("own/k.exr")),
        ("link/../../../k.exr", None),
        ("link/../../../own/k.exr", Some("own/k.exr")),
        ("in/../../k.exr", None),
    ] {
        let graph = parse("a.json", &text.replace("FILE", file), &folder.join("own"), &[]).unwrap().graph;
        let graph = graph.with_access(crate::Access::beneath(&folder.join("own")));
        let named = output_files(&graph, &[0], 1, false, None);
        let place = named.as_ref().ok().map(|files| resolved(&files[0].path));
        assert_eq!(place, written.map(|written| folder.join(written)), "{file}");
    }
}

#[test]
fn unknown_placeholders_are_refused() {
    let graph = graph(r#""a": { "color": "mix" }"#);
    let refused = output_files(&graph, &[0], 1, false, Some("{outputs}.####.exr")).unwrap_err().to_string();
    assert!(refused.contains("unknown placeholder {outputs}"), "{refused}");
}

#[test]
fn the_main_layer_and_depth_have_the_names_that_others_look_for() {
    let graph =
        graph(r#""a": { "color": "mix", "file": "k.exr", "layer": "" }, "d": { "field": "depth", "file": "k.exr" }"#);
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap();
    let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let file = OutputFile { path: folder.path().join("k.exr"), outputs: vec![0, 1] };
    write_output(&graph, &frame, &file, &[]).unwrap();
    let info = trochoid_io::info(&file.path, &trochoid_io::Limits::default()).unwrap();
    let channels: Vec<String> = info.parts[0]
        .channels
        .iter()
        .map(|channel| format!("{} {:?}", channel.full_name, channel.sample_type))
        .collect();
    assert_eq!(channels, ["B Half", "G Half", "R Half", "d.Z Float"]);
}

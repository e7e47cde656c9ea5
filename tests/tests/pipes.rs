//! Paths that are not regular files: a pipe without a writer is an error wherever it is read, and never blocks.

#![cfg(unix)]

use crate::support::graph_in;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc::channel;
use std::time::Duration;
use trochoid::accuracy::PlanFile;
use trochoid::certificate::Certificate;
use trochoid::{Buffers, Cache, Plan, Settings, Silent, load};

/// Returns the result of a function on a thread of its own; panics if the function blocks.
fn within(what: &str, ask: impl FnOnce() -> String + Send + 'static) -> String {
    let (send, receive) = channel();
    std::thread::spawn(move || send.send(ask()));
    receive.recv_timeout(Duration::from_secs(60)).unwrap_or_else(|_| panic!("{what}: blocks"))
}

/// Returns why a graph with this node as the view's surface or as a picture cannot be evaluated.
fn refused(folder: &Path, nodes: &str, output: &str) -> String {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }}, "nodes": {{
            "camera": {{ "type": "Camera", "position": [0, 10, 0], "target": [0, 0, 0] }}, {nodes} }},
            "outputs": {{ "out": {{ {output} }} }} }}"#
    );
    let graph = graph_in(folder, &text);
    let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap();
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap_err().to_string()
}

#[test]
fn a_pipe_is_refused_wherever_a_file_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let view = |surface: &str| {
        let nodes = format!(
            r#""s": {{ {surface} }}, "view": {{ "type": "Render", "camera": "camera", "surfaces": ["s"] }},
               "z": {{ "type": "Height", "view": "view" }}"#
        );
        (nodes, r#""field": "z""#)
    };
    let picture = |node: &str| (format!(r#""z": {{ {node} }}"#), r#""color": "z""#);
    for (what, (nodes, output)) in [
        ("a mesh", view(r#""type": "Mesh", "file": "pipe""#)),
        ("a model", view(r#""type": "BezierModel", "model": "pipe""#)),
        ("a picture", picture(r#""type": "Read", "as": "color", "file": "pipe""#)),
        ("a texture", picture(r#""type": "Texture", "as": "color", "file": "pipe", "u": 0, "v": 0"#)),
        (
            "passes",
            (
                r#""v": { "type": "ViewFromPasses", "file": "pipe", "depth": "Z" }, "z": { "type": "Depth", "view": "v" }"#
                    .into(),
                r#""field": "z""#,
            ),
        ),
    ] {
        let place = folder.path().to_path_buf();
        let message = within(what, move || refused(&place, &nodes, output));
        assert!(message.contains("found a pipe, expected a file"), "{what}: {message}");
    }
    type Ask = fn(&Path) -> String;
    let files: [(&str, Ask); 4] = [
        ("a document", |path| load(path, &[]).unwrap_err().to_string()),
        ("a plan", |path| PlanFile::read(path).unwrap_err().to_string()),
        ("a certificate", |path| Certificate::read(path).unwrap_err().to_string()),
        ("a picture's header", |path| trochoid::io::info(path, &Default::default()).unwrap_err().to_string()),
    ];
    for (what, ask) in files {
        let path = pipe.clone();
        let message = within(what, move || ask(&path));
        assert!(message.contains("found a pipe, expected a file"), "{what}: {message}");
    }
}

#[test]
fn names_with_signs_that_stand_for_frames_can_be_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let name = "take #3, 50%.png";
    let image = trochoid::io::PngImage::new(4, 2, trochoid::io::Samples::rgb(&[[0.5; 3]; 8]));
    trochoid::io::write_png8(folder.path().join(name), &image).unwrap();
    let node = |file: &str| format!(r#""z": {{ "type": "Read", "as": "color", "file": {file:?} }}"#);
    let message = refused(folder.path(), &node(name), r#""color": "z""#);
    let written = r#""take \\#3, 50%.png" in a document"#;
    assert!(message.contains(written), "{message}");
    let text = |file: &str| {
        format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }}, "nodes": {{ {} }},
                "outputs": {{ "out": {{ "color": "z" }} }} }}"#,
            node(file)
        )
    };
    let missing = trochoid::missing_files(&graph_in(folder.path(), &text(name)));
    assert!(missing[0].remedy.contains(written), "{missing:?}");
    let escaped = graph_in(folder.path(), &text(r"take \#3, 50\%.png"));
    assert!(trochoid::missing_files(&escaped).is_empty());
    let plan = Plan::new(&escaped, &[], 1, &[], &Settings::default()).unwrap();
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
}

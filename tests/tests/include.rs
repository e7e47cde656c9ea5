//! Included documents: their groups are used as if they were written in the document, with paths of their own.

use crate::support::{all_bits, evaluate};
use std::fs;
use std::path::Path;
use trochoid::{Access, Buffers, CheckedGraph, LoadError, Settings, load_within, parse};

/// A document that uses the group "Slab" of an included one.
const SCENE: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 16 }, "include": ["lib/slabs.json"],
    "nodes": { "ground": { "type": "Constant", "color": "#204060" },
               "slab": { "type": "Slab", "under": "ground" },
               "twice": { "type": "Slab", "under": "slab", "model": "lib/more/low.obj", "far": 9 } },
    "outputs": { "o": { "color": "twice" } } }"##;

/// Groups that use groups of a third document, and a model beside them.
const SLABS: &str = r##"{ "trochoid": 1, "include": ["more/seen.json"], "notes": "Slabs.", "groups": { "Slab": {
    "inputs": { "under": "Color" }, "knobs": { "model": "high.obj", "far": { "default": 8, "min": 1 } },
    "nodes": { "model": { "type": "Mesh", "file": "= knobs.model" },
               "seen": { "type": "Seen", "surface": "model", "far": "= knobs.far" },
               "over": { "type": "Mix", "a": "under", "b": "#e0c080", "weight": "seen" } },
    "outputs": { "color": "over" } } } }"##;

const SEEN: &str = r##"{ "trochoid": 1, "include": ["../slabs.json"], "groups": { "Seen": {
    "inputs": { "surface": "Surface" }, "knobs": { "far": 8 },
    "nodes": { "camera": { "type": "Camera", "position": [0, 3, "= knobs.far"], "target": [0, 0, 0], "fov": 60 },
               "other": { "type": "Mesh", "file": "low.obj" },
               "view": { "type": "Render", "camera": "camera", "surfaces": ["surface", "other"] } },
    "outputs": { "mask": "view.coverage" } } } }"##;

/// The same, written out.
const BY_HAND: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 16 },
    "nodes": { "ground": { "type": "Constant", "color": "#204060" },
               "high": { "type": "Mesh", "file": "lib/high.obj" },
               "low": { "type": "Mesh", "file": "lib/more/low.obj" },
               "near": { "type": "Camera", "position": [0, 3, 8], "target": [0, 0, 0], "fov": 60 },
               "far": { "type": "Camera", "position": [0, 3, 9], "target": [0, 0, 0], "fov": 60 },
               "a": { "type": "Render", "camera": "near", "surfaces": ["high", "low"] },
               "again": { "type": "Mesh", "file": "lib/more/low.obj" },
               "b": { "type": "Render", "camera": "far", "surfaces": ["again", "low"] },
               "slab": { "type": "Mix", "a": "ground", "b": "#e0c080", "weight": "a.coverage" },
               "twice": { "type": "Mix", "a": "slab", "b": "#e0c080", "weight": "b.coverage" } },
    "outputs": { "o": { "color": "twice" } } }"##;

const DOCUMENTS: [(&str, &str); 3] = [("scene.json", SCENE), ("lib/slabs.json", SLABS), ("lib/more/seen.json", SEEN)];

fn slab(height: f64) -> String {
    format!("v -2 {height} -1\nv 2 {height} -1\nv 2 {height} 1\nv -2 {height} 1\nf 4 3 2 1\n")
}

/// Writes the documents and models to a folder.
fn write(at: &Path) {
    fs::create_dir_all(at.join("lib/more")).unwrap();
    for (name, text) in DOCUMENTS {
        fs::write(at.join(name), text).unwrap();
    }
    fs::write(at.join("by_hand.json"), BY_HAND).unwrap();
    fs::write(at.join("lib/high.obj"), slab(1.0)).unwrap();
    fs::write(at.join("lib/more/low.obj"), slab(-0.5)).unwrap();
}

fn graph(at: &Path) -> CheckedGraph {
    let access = Access::beneath(at.parent().unwrap());
    load_within(at, &[], access).unwrap_or_else(|error| panic!("{error}")).graph
}

fn bits(graph: &CheckedGraph) -> Vec<Vec<Vec<u32>>> {
    all_bits(&evaluate(graph, 1, &Buffers::new(), &Settings::default()))
}

#[test]
fn groups_of_other_documents_are_used_with_paths_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder);
    let (scene, by_hand) = (graph(&folder.join("scene.json")), graph(&folder.join("by_hand.json")));
    assert_eq!(bits(&scene), bits(&by_hand));
    let files: Vec<_> = scene.document_files().iter().map(|path| path.strip_prefix(folder).unwrap()).collect();
    assert_eq!(files, [Path::new("lib/slabs.json"), Path::new("lib/more/seen.json")], "each is read once");
    let place = scene.place_of(scene.find("slab/seen/other").unwrap(), Some("file"));
    assert!(place.document.ends_with("lib/more/seen.json") && place.line == 4, "{place}");
    // The canonical text needs none of them.
    fs::remove_file(folder.join("lib/slabs.json")).unwrap();
    let alone = parse("canonical", scene.canonical(), folder, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(bits(&alone.graph), bits(&scene));
    assert_eq!(alone.graph.canonical(), scene.canonical());
}

/// Each fault has a message of its own, in the file where it is.
#[test]
fn faults_of_included_documents_are_told_with_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let cases: [(&str, &str, &[&str]); 14] = [
        ("scene.json", "\"lib/slabs.json\"", &["scene.json:1:", "include", "7; expected the path of a document"]),
        ("scene.json", "[\"lib/slabs.json\"]", &["scene.json:1:", "a list of documents with groups"]),
        (
            "scene.json",
            "lib/slabs.json",
            &["scene.json:1:", "include", "no file", "relative to the document that names it"],
        ),
        ("lib/slabs.json", "more/seen.json", &["slabs.json:1:", "no file", "seen.jsonx"]),
        (
            "lib/more/seen.json",
            "\"include\": [\"../slabs.json\"], \"groups\"",
            &["seen.json:1:1", "a document without groups"],
        ),
        ("lib/more/seen.json", "\"groups\": {", &["seen.json:1:", "7; expected an object of groups by name"]),
        ("lib/more/seen.json", "\"trochoid\": 1", &["seen.json:1:", "2", "the version of the document format"]),
        ("lib/more/seen.json", "\"trochoid\": 1,", &["seen.json:1:1", "no \"trochoid\""]),
        ("lib/more/seen.json", "\"Seen\"", &["seen.json:1:", "a second \"Slab\"", "rename or remove one of them"]),
        (
            "lib/more/seen.json",
            "\"Camera\"",
            &["seen.json:3:", "unknown node type \"Camerq\"", "in the group Seen as used at", "slabs.json:4:"],
        ),
        ("lib/more/seen.json", "= knobs.far", &["seen.json:3:", "\"knobs.fat\", which the group Seen does not have"]),
        ("lib/more/seen.json", "{ \"trochoid\"", &["seen.json:1:", "JSON"]),
        ("scene.json", "\"far\": 9", &["scene.json:4:", "far: 0.5; expected a number of at least 1"]),
        (
            "scene.json",
            "\"Slab\", \"under\": \"slab\"",
            &["scene.json:4:", "unknown node type \"Slap\"", "did you mean \"Slab\"?"],
        ),
    ];
    let instead = [
        "7",
        "{}",
        "lib/slabs.jsonx",
        "more/seen.jsonx",
        "\"knobs\"",
        "\"groups\": 7, \"notes\": {",
        "\"trochoid\": 2",
        "",
        "\"Slab\"",
        "\"Camerq\"",
        "= knobs.fat",
        "{ \"trochoid\"; ",
        "\"far\": 0.5",
        "\"Slap\", \"under\": \"slab\"",
    ];
    for ((file, from, said), to) in cases.into_iter().zip(instead) {
        write(folder);
        let (_, text) = DOCUMENTS.iter().find(|(name, _)| *name == file).unwrap();
        assert!(text.contains(from), "{from}");
        fs::write(folder.join(file), text.replacen(from, to, 1)).unwrap();
        let path = folder.join("scene.json");
        let found = match load_within(&path, &[], Access::beneath(folder)) {
            Err(LoadError::Invalid(faults)) => faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
            other => panic!("{from} → {to}: {other:?}"),
        };
        for words in said {
            assert!(found.contains(words), "{from} → {to}: \"{words}\" in {found}");
        }
        assert!(found.contains("remedy"), "{found}");
    }
}

#[test]
fn included_documents_are_read_only_where_the_document_may_read() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder);
    fs::create_dir_all(folder.join("inner")).unwrap();
    let text = SCENE.replace("lib/", "../lib/");
    fs::write(folder.join("inner/scene.json"), &text).unwrap();
    let path = folder.join("inner/scene.json");
    let only = |at: &Path| Access::beneath(at);
    match load_within(&path, &[], only(&folder.join("inner"))) {
        Err(LoadError::Invalid(faults)) => {
            let found = faults[0].to_string();
            assert!(found.contains("include") && found.contains("slabs.json"), "{found}");
            assert!(found.contains("expected a file that the document may reach"), "{found}");
        }
        other => panic!("{other:?}"),
    }
    let loaded = load_within(&path, &[], only(folder)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(bits(&loaded.graph), bits(&graph(&folder.join("by_hand.json"))));
}

//! No node opens a file that the document may not access.

use crate::support::{folder, graph_in, root};
use std::path::Path;
use trochoid::{
    Access, Buffers, Cache, EvalError, Item, KnobType, Plan, ReferenceError, ReferenceFrame, RefusedFile, Settings,
    Silent, refused_files, registry,
};

/// Golden cases in which a node names a file, each with the node's type.
fn cases() -> Vec<(String, String)> {
    let names_file = |item: &Item| matches!(item, Item::Knob(knob) if matches!(knob.takes, KnobType::Path));
    let types = registry().iter().filter(|ty| ty.declaration().items.iter().any(names_file));
    let case =
        |name: &str| (name.into(), std::fs::read_to_string(root().join(format!("tests/nodes/{name}.json"))).unwrap());
    types.map(|ty| case(ty.declaration().name)).collect()
}

#[test]
fn nodes_read_only_files_that_the_document_may_access() {
    let folder = folder();
    let mut asked = 0;
    for (name, text) in cases() {
        let graph = graph_in(folder.path(), &text);
        if !text.contains(&format!("\"type\": \"{name}\", \"file\"")) {
            continue;
        }
        asked += 1;
        let outputs: Vec<usize> = (0..graph.outputs().len()).collect();
        let elsewhere = graph.clone().with_access(Access::beneath(Path::new("/nowhere")));
        let frame = graph.frames().0;
        let evaluate = |graph: &trochoid::CheckedGraph| {
            let plan = Plan::new(graph, &[], frame, &[], &Settings::default()).unwrap();
            plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).map(drop)
        };
        assert_eq!(refused_files(&graph, &outputs, &[frame]), [], "{name}");
        assert_eq!(evaluate(&graph), Ok(()), "{name}: the golden case itself");
        let refused = refused_files(&elsewhere, &outputs, &[frame]);
        assert!(refused.iter().any(|refused| refused.item.is_some() && refused.place[0] > 0), "{name}: {refused:?}");
        let is_refusal = |error: &EvalError| {
            let EvalError::Node { error, .. } = error else { return false };
            error.source().is_some_and(|source| source.is::<RefusedFile>())
        };
        assert!(evaluate(&elsewhere).is_err_and(|error| is_refusal(&error)), "{name}");
        let output = &graph.outputs()[0].name;
        let reference = ReferenceFrame::new(&elsewhere, output, frame).map(drop);
        assert!(reference.is_err_and(|e| matches!(e, ReferenceError::Eval(e) if is_refusal(&e))), "{name}");
        // Prepared data of another graph are not reused.
        let mut cache = Cache::new();
        let run = |graph: &trochoid::CheckedGraph, cache: &mut Cache| {
            let plan = Plan::new(graph, &[], frame, &[], &Settings::default()).unwrap();
            plan.evaluate(&Buffers::new(), cache, &Silent).map(drop)
        };
        assert_eq!(run(&graph, &mut cache), Ok(()));
        assert!(run(&elsewhere, &mut cache).is_err(), "{name}");
    }
    assert!(asked >= 4, "{asked} types of node name files in their golden cases");
}

/// Collects the sources of a folder without tests.
fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if name.contains("test") {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if name.ends_with(".rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            found.push((name, text.split("#[cfg(test)]").next().unwrap().to_owned()));
        }
    }
}

#[test]
fn names_of_files_become_paths_in_one_place() {
    let mut found = Vec::new();
    sources(&root().join("crates/nodes/src"), &mut found);
    assert!(found.len() >= trochoid::registry().iter().count(), "{} files, and each node has one", found.len());
    // A path made elsewhere would not come from a knob for paths, and its access would not be checked.
    for (name, text) in found {
        for word in ["expand_frame", ".folder", "Path::new(", "PathBuf::from("] {
            assert!(!text.contains(word), "{name}: {word}: FrameContext::path makes paths of what a document says");
        }
    }
}

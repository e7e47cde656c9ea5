//! Documents of the book: every node type has one, and none has a fault or a warning.

use crate::support::root;
use std::collections::BTreeSet;
use trochoid::{Loaded, load, parse, registry};

/// Returns the names of the documents in `docs/nodes`, without extension.
fn shown() -> BTreeSet<String> {
    let entries = std::fs::read_dir(root().join("docs/nodes")).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().to_str().unwrap().strip_suffix(".json").unwrap().to_owned())
        .collect()
}

#[test]
fn every_node_has_a_document_that_shows_it() {
    let (types, shown): (BTreeSet<String>, _) = (registry().names().map(str::to_owned).collect(), shown());
    let missing: Vec<_> = types.difference(&shown).map(|ty| format!("docs/nodes/{ty}.json")).collect();
    assert!(missing.is_empty(), "add {}, which shows the node on its page of the manual", missing.join(", "));
    let strays: Vec<_> = shown.difference(&types).collect();
    assert!(strays.is_empty(), "docs/nodes: {strays:?} are no node types");
}

#[test]
fn documents_of_nodes_have_no_fault_and_use_their_node() {
    for name in shown() {
        let path = root().join(format!("docs/nodes/{name}.json"));
        let loaded = load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        has_no_warning(&loaded);
        let (first, outputs) = (loaded.graph.frames().0, loaded.graph.outputs());
        assert_eq!(outputs.len(), 1, "{name}: one picture");
        let reached = loaded.graph.dependencies(outputs.iter().map(|output| output.node), first);
        let used = loaded
            .graph
            .nodes()
            .iter()
            .zip(reached)
            .any(|(node, reached)| reached && !node.disabled && node.ty.declaration().name == name);
        assert!(used, "{name}: its picture does not depend on such a node");
    }
}

fn has_no_warning(loaded: &Loaded) {
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.is_empty(), "{}", warnings.join("\n"));
}

#[test]
fn documents_of_chapters_and_of_the_readme_have_no_fault() {
    let chapters = std::fs::read_dir(root().join("docs/src")).unwrap().map(|entry| entry.unwrap().path());
    let pages = chapters.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    let mut found = 0;
    for page in pages.chain([root().join("README.md")]) {
        let text = std::fs::read_to_string(&page).unwrap();
        for block in text.split("\n```json ").skip(1) {
            let (name, rest) = block.split_once('\n').unwrap();
            let document = rest.split("\n```").next().unwrap();
            let loaded =
                parse(name, document, &root(), &[]).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
            has_no_warning(&loaded);
            found += 1;
        }
    }
    assert!(found >= 8, "only {found} documents");
}

//! Finds the node files, so that adding a node is adding a file.
//!
//! Every file `src/<folder>/<node>.rs` that is no `mod.rs` becomes a module and must have
//! `pub(crate) static NODE: &dyn NodeType`. Folders named like a feature are taken where the feature is on.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

/// Folders of node files; those with a feature's name need the feature.
const FOLDERS: [(&str, Option<&str>); 5] =
    [("back", None), ("front", None), ("io", Some("IO")), ("scene", Some("SCENE")), ("sea", Some("SEA"))];

fn main() {
    let root = env::var("CARGO_MANIFEST_DIR").expect("set by cargo");
    let out = env::var("OUT_DIR").expect("set by cargo");
    let mut modules = String::new();
    let mut nodes = String::new();
    for (folder, feature) in FOLDERS {
        let path = Path::new(&root).join("src").join(folder);
        println!("cargo::rerun-if-changed={}", path.display());
        if feature.is_some_and(|feature| env::var(format!("CARGO_FEATURE_{feature}")).is_err()) {
            continue;
        }
        let mut files: Vec<_> = fs::read_dir(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
            .map(|entry| entry.expect("a readable folder").path())
            .filter(|file| file.extension().is_some_and(|ending| ending == "rs"))
            .collect();
        files.sort();
        for file in files {
            let name = file.file_stem().and_then(|stem| stem.to_str()).expect("a file name in ASCII").to_owned();
            writeln!(modules, "#[path = {:?}]\nmod {folder}_{name};", file.display().to_string()).expect("text");
            writeln!(nodes, "    {folder}_{name}::NODE,").expect("text");
        }
    }
    let text = format!("{modules}\nstatic NODES: &[&dyn trochoid_graph::NodeType] = &[\n{nodes}];\n");
    fs::write(Path::new(&out).join("nodes.rs"), text).expect("a writable build folder");
}

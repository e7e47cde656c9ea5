//! The architecture: allowed dependencies between crates, and the single place where files are opened.

use crate::support::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Packages of the workspace that each package may depend on.
const ALLOWED: &[(&str, &[&str])] = &[
    ("trochoid-memory", &[]),
    ("trochoid-key", &[]),
    ("trochoid-image", &["trochoid-key", "trochoid-memory"]),
    ("trochoid-jit", &["trochoid-memory"]),
    ("trochoid-weights", &["trochoid-image", "trochoid-memory"]),
    ("trochoid-palette", &["trochoid-image", "trochoid-memory", "trochoid-weights"]),
    ("trochoid-io", &["trochoid-image", "trochoid-memory"]),
    ("trochoid-sea", &["trochoid-key"]),
    ("trochoid-scene", &["trochoid-image", "trochoid-key", "trochoid-memory", "trochoid-sea"]),
    ("trochoid-derive", &[]),
    ("trochoid-graph", &["trochoid-derive", "trochoid-image", "trochoid-key", "trochoid-memory", "trochoid-weights"]),
    ("trochoid-field", &["trochoid-graph", "trochoid-memory"]),
    (
        "trochoid-nodes",
        &[
            "trochoid-field",
            "trochoid-graph",
            "trochoid-weights",
            "trochoid-image",
            "trochoid-memory",
            "trochoid-scene",
            "trochoid-sea",
            "trochoid-io",
            "trochoid-palette",
        ],
    ),
    ("trochoid-kernel", &["trochoid-graph", "trochoid-jit", "trochoid-memory", "trochoid-weights"]),
    (
        "trochoid-engine",
        &["trochoid-graph", "trochoid-image", "trochoid-kernel", "trochoid-key", "trochoid-memory", "trochoid-weights"],
    ),
    (
        "trochoid",
        &["trochoid-image", "trochoid-graph", "trochoid-engine", "trochoid-nodes", "trochoid-io", "trochoid-memory"],
    ),
    ("trochoid-terminal", &["trochoid"]),
    ("trochoid-book", &["trochoid"]),
    ("trochoid-editor", &["trochoid", "trochoid-diagram", "trochoid-terminal"]),
    ("trochoid-diagram", &["trochoid-graph", "trochoid-image"]),
    ("trochoid-export", &["trochoid-engine", "trochoid-graph", "trochoid-image", "trochoid-weights"]),
    ("trochoid-cli", &["trochoid", "trochoid-diagram", "trochoid-export", "trochoid-palette", "trochoid-terminal"]),
    ("trochoid-tests", &["trochoid", "trochoid-diagram"]),
    ("trochoid-bench", &["trochoid", "trochoid-image", "trochoid-scene", "trochoid-sea"]),
    ("trochoid-foreign", &["trochoid"]),
    ("trochoid-capi", &["trochoid", "trochoid-foreign"]),
    ("trochoid-own-node", &["trochoid", "trochoid-graph"]),
    ("trochoid-files-tests", &["trochoid-image", "trochoid-io"]),
];

/// Returns the packages of the workspace, as Cargo describes them.
fn packages() -> Vec<serde_json::Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn arrows() -> BTreeMap<String, BTreeSet<String>> {
    let packages = packages();
    let name = |value: &serde_json::Value| value["name"].as_str().unwrap().to_string();
    let members: BTreeSet<String> = packages.iter().map(name).collect();
    packages
        .iter()
        .map(|package| {
            let tests = name(package).ends_with("-tests");
            let dependencies = package["dependencies"].as_array().unwrap().iter();
            // Tests have nothing but dev-dependencies.
            let counted = dependencies.filter(|dependency| tests || dependency["kind"] != "dev");
            (name(package), counted.map(name).filter(|name| members.contains(name)).collect())
        })
        .collect()
}

#[test]
fn crates_depend_as_the_design_says() {
    let allowed: BTreeMap<&str, &[&str]> = ALLOWED.iter().copied().collect();
    let arrows = arrows();
    let mut faults = Vec::new();
    for (package, dependencies) in &arrows {
        match allowed.get(package.as_str()) {
            None => faults.push(format!("{package} is not in the table")),
            Some(allowed) => faults.extend(
                dependencies
                    .iter()
                    .filter(|dependency| !allowed.contains(&dependency.as_str()))
                    .map(|dependency| format!("{package} must not depend on {dependency}")),
            ),
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for required in ["trochoid-engine", "trochoid-nodes", "trochoid"] {
        assert!(arrows.contains_key(required), "{required} is missing");
    }
}

/// Some libraries are not compiled for tests: tests within them would never run.
#[test]
fn libraries_that_are_not_tested_hold_no_tests() {
    let mut outside = BTreeSet::new();
    for package in packages() {
        let library = package["targets"].as_array().unwrap().iter().find(|target| target["kind"][0] == "lib");
        let Some(library) = library.filter(|library| library["test"] == false) else { continue };
        let source = Path::new(library["src_path"].as_str().unwrap()).parent().unwrap();
        assert!(source.parent().unwrap().join("tests").is_dir(), "{} has no tests", source.display());
        outside.insert(package["name"].as_str().unwrap().to_owned());
        for file in files(source) {
            let text = std::fs::read_to_string(&file).unwrap();
            assert!(!text.contains("cfg(test)") && !text.contains("#[test]"), "{} has tests", file.display());
        }
    }
    let expected = ["trochoid-engine", "trochoid-nodes", "trochoid-scene", "trochoid-sea", "trochoid-weights"];
    assert!(outside.iter().eq(expected), "{outside:?}");
}

/// Returns all files of a folder.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Functions that open a file by name.
const OPENINGS: &[&str] = &[
    "File::open",
    "File::options",
    "OpenOptions",
    "fs::read(",
    "fs::read_to_string",
    "image::open",
    "gltf::import",
    "Gltf::open",
    "load_obj(",
    "from_file(",
];

/// Places that open files other than by `trochoid-io`, with the reasons.
const OPENED: &[(&str, &str, &str)] = &[
    ("crates/io/src/open.rs", "OpenOptions", "the function by which all files are opened"),
    ("crates/io/src/partial.rs", "OpenOptions", "a temporary file of our own, of which only the lock is used"),
    ("crates/io/src/claim.rs", "OpenOptions", "a file of our own that is made and locked, and read by `open_file`"),
    ("crates/io/src/atomic.rs", "File::open", "a folder, so that its new entry is on disk"),
    ("crates/editor/src/document/keep.rs", "File::open", "a lock of the editor's own, which is not read"),
    ("crates/trochoid/src/report.rs", "fs::read_to_string", "what the system reports about this process"),
];

/// Collects the sources of a folder, without tests.
pub(crate) fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            if name != "tests" {
                sources(&path, found);
            }
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            // Tests stand at a file's end.
            let end = text.match_indices("#[cfg(test)]\nmod ").map(|(at, _)| at);
            let end = end.filter(|at| text[*at..].lines().nth(1).is_some_and(|line| line.ends_with('{'))).min();
            let place = path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
            found.push((place, text[..end.unwrap_or(text.len())].to_owned()));
        }
    }
}

#[test]
fn files_are_opened_in_one_place() {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        sources(&entry.unwrap().path().join("src"), &mut files);
    }
    let found: BTreeSet<(&str, &str)> = files
        .iter()
        .flat_map(|(place, text)| OPENINGS.iter().filter(|word| text.contains(**word)).map(|word| (&**place, *word)))
        .collect();
    let allowed: BTreeSet<(&str, &str)> = OPENED.iter().map(|(place, word, _)| (*place, *word)).collect();
    let others: Vec<_> = found.difference(&allowed).collect();
    assert!(others.is_empty(), "these open files themselves instead of by trochoid_io::open_file: {others:?}");
    let gone: Vec<_> = allowed.difference(&found).collect();
    assert!(gone.is_empty(), "these no longer open files, and need no exception: {gone:?}");
}

/// The evaluator of the manuals judges what it computes itself: only `manual/mod.rs`, which compares, uses Trochoid or
/// other modules of the tests.
#[test]
fn the_evaluator_of_the_manuals_shares_no_code() {
    let mut files = Vec::new();
    sources(&root().join("tests/tests/manual"), &mut files);
    assert!(files.len() > 10, "{} files", files.len());
    for (place, text) in files.iter().filter(|(place, _)| !place.ends_with("/mod.rs")) {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in code {
            let foreign =
                ["trochoid_", "trochoid::", "crate::", "include!", "extern"].iter().find(|word| line.contains(**word));
            assert!(foreign.is_none(), "{place} uses {foreign:?}: {line}");
            let used = line.trim_start().strip_prefix("use ").map(|used| used.split("::").next().unwrap());
            let allowed = ["super", "std", "rand", "rand_pcg", "serde_json"];
            assert!(used.is_none_or(|used| allowed.contains(&used)), "{place} uses {used:?}");
        }
    }
}

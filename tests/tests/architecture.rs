//! The house: which crate may depend on which.

use crate::support::root;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// What each package of the workspace may depend on, and nothing else of the workspace.
const ALLOWED: &[(&str, &[&str])] = &[
    ("trochoid-memory", &[]),
    ("trochoid-image", &["trochoid-memory"]),
    ("trochoid-jit", &["trochoid-memory"]),
    ("trochoid-weights", &["trochoid-image"]),
    ("trochoid-io", &["trochoid-image", "trochoid-memory"]),
    ("trochoid-sea", &[]),
    ("trochoid-scene", &["trochoid-image", "trochoid-sea"]),
    ("trochoid-graph", &["trochoid-image", "trochoid-weights"]),
    (
        "trochoid-nodes",
        &["trochoid-graph", "trochoid-weights", "trochoid-image", "trochoid-scene", "trochoid-sea", "trochoid-io"],
    ),
    ("trochoid-engine", &["trochoid-graph", "trochoid-image", "trochoid-jit", "trochoid-memory", "trochoid-weights"]),
    (
        "trochoid",
        &["trochoid-image", "trochoid-graph", "trochoid-engine", "trochoid-nodes", "trochoid-io", "trochoid-memory"],
    ),
    ("trochoid-editor", &["trochoid", "trochoid-diagram"]),
    ("trochoid-diagram", &["trochoid-graph", "trochoid-image"]),
    ("trochoid-cli", &["trochoid", "trochoid-diagram", "trochoid-editor"]),
    ("trochoid-tests", &["trochoid", "trochoid-diagram"]),
];

fn arrows() -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let name = |value: &serde_json::Value| value["name"].as_str().unwrap().to_string();
    let members: BTreeSet<String> = packages.iter().map(name).collect();
    packages
        .iter()
        .map(|package| {
            let tests = name(package) == "trochoid-tests";
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
            None => faults.push(format!("{package} has no place in the house")),
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

//! Faulty documents with their whole messages: place, what was found, what was expected, and a remedy.
//!
//! `refusals/TOPIC/NAME.json` is the document, and `NAME.txt` beside it the message, which `TROCHOID_UPDATE=1` stores
//! as it is found. If there is a `NAME.set`, the document itself is sound, and each line of that file is an assignment
//! that is refused. Documents that are too large for a file are made here. Documents in `warnings` are valid but do
//! nothing, or less than their author thinks; among them are some without a fault, which get no warning.

use crate::support::{large, root};
use crate::{stored, trial};
use libtest_mimic::Trial;
use std::path::{Path, PathBuf};
use trochoid::{Diagnostic, LoadError, Loaded, Severity, load, parse};

fn folder(kind: &str) -> PathBuf {
    root().join("tests").join(kind)
}

/// Returns what is wrong with the form of a message: each has a place and a remedy, and is readable.
fn form(fault: &Diagnostic) -> Option<String> {
    let text = fault.to_string();
    let short = text.chars().count() <= 1000 && !text.chars().any(|c| c.is_control() && c != '\n');
    if fault.severity != Severity::Error || (short && !fault.file.is_empty() && !fault.remedy.is_empty()) {
        return None;
    }
    Some(format!("expected a place, a remedy, at most 1000 characters and no control characters in: {text}"))
}

/// Returns the whole message of a document that must be refused.
fn refusal(loaded: Result<Loaded, LoadError>) -> Result<String, String> {
    match loaded {
        Ok(_) => Err("found a valid document; expected one that is refused".into()),
        Err(error) => match &error {
            LoadError::Invalid(faults) => faults.iter().find_map(form).map_or(Ok(error.to_string()), Err),
            LoadError::Io(_) => Ok(error.to_string()),
        },
    }
}

/// Returns all warnings of a document that must be valid.
fn warnings(loaded: Result<Loaded, LoadError>) -> Result<String, String> {
    let warnings = loaded.map_err(|error| format!("expected a valid document: {error}"))?.warnings;
    Ok(warnings.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n"))
}

/// Returns the messages of a document that is refused with each of these assignments, one per line.
fn refusals(document: &Path, assignments: &str) -> Result<String, String> {
    let one = |line: &str| Ok(format!("--set {line}\n{}\n", refusal(load(document, &[line.into()]))?));
    Ok(assignments.lines().map(one).collect::<Result<Vec<String>, String>>()?.join("\n"))
}

fn holds(kind: &str, document: &Path) -> Result<(), String> {
    let said = match std::fs::read_to_string(document.with_extension("set")) {
        Ok(assignments) => refusals(document, &assignments)?,
        Err(_) if kind == "warnings" => warnings(load(document, &[]))?,
        Err(_) => refusal(load(document, &[]))?,
    };
    stored::holds_said(&document.with_extension("txt"), &said, document.parent().unwrap())
}

/// Function that makes a document.
type Made = fn() -> String;

/// Documents that are too large for a file, by name.
const LARGE: [(&str, Made); 6] = [
    ("levels", || format!("{{ \"trochoid\": 1, \"notes\": {}{} }}", "[".repeat(100_000), "]".repeat(100_000))),
    ("open_brackets", || "[".repeat(100_000)),
    ("bytes", || " ".repeat((64 << 20) + 1)),
    ("values", || format!("{{ \"notes\": [{}0] }}", "0,".repeat(4_000_001))),
    ("nodes", || {
        let nodes: Vec<String> = (0..100_001).map(|i| format!(r#""n{i}": {{}}"#)).collect();
        large::document((4, 4), &nodes.join(","), "")
    }),
    ("loop", || {
        let links: Vec<String> =
            (0..500).map(|i| format!(r#""n{i}": {{ "type": "Invert", "weight": "n{}" }}"#, (i + 499) % 500)).collect();
        large::document((4, 4), &links.join(",\n"), r#""out": { "weights": "n0" }"#)
    }),
];

fn holds_large(name: &str, text: &str) -> Result<(), String> {
    let said = refusal(parse(&format!("{name}.json"), text, Path::new("."), &[]))?;
    let folder = folder("refusals/large");
    stored::holds_said(&folder.join(format!("{name}.txt")), &said, &folder)
}

/// Returns all files of a kind, with their topics.
fn files(kind: &str) -> Vec<(String, PathBuf)> {
    let mut files = Vec::new();
    for topic in std::fs::read_dir(folder(kind)).unwrap() {
        let topic = topic.unwrap();
        for entry in std::fs::read_dir(topic.path()).unwrap() {
            files.push((topic.file_name().into_string().unwrap(), entry.unwrap().path()));
        }
    }
    files.sort();
    files
}

/// Checks that every message belongs to a document.
fn strays(kind: &str) -> Result<(), String> {
    for (topic, path) in files(kind) {
        let large =
            topic == "large" && LARGE.iter().any(|(name, _)| path.file_stem().is_some_and(|stem| stem == *name));
        if !large && !path.with_extension("json").exists() {
            return Err(format!("{} belongs to no document", path.display()));
        }
    }
    Ok(())
}

pub(crate) fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for kind in ["refusals", "warnings"] {
        for (topic, path) in files(kind) {
            if path.extension().is_some_and(|ending| ending == "json") {
                let name = format!("{topic}/{}", path.file_stem().unwrap().display());
                trials.push(trial(kind, &name, move || holds(kind, &path)));
            }
        }
        trials.push(trial(kind, "every_message_belongs_to_a_document", || strays(kind)));
    }
    trials.extend(LARGE.map(|(name, text)| trial("refusals/large", name, move || holds_large(name, &text()))));
    trials
}

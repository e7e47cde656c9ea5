//! Which folders of the engine may use which others, judged by the paths in their files.

use crate::architecture::sources;
use crate::support::root;
use std::collections::BTreeMap;

/// Folders of the engine, with the other folders that each may use.
const FOLDERS: &[(&str, &[&str])] = &[
    ("settings", &[]),
    ("rules", &[]),
    ("judge", &["settings"]),
    ("planning", &["judge", "rules", "settings"]),
    ("running", &["judge", "planning", "rules", "settings"]),
    ("look", &["planning", "running", "settings"]),
];

/// Returns source text without comments and string contents.
fn code(text: &str) -> String {
    let mut code = String::new();
    for line in text.lines() {
        let mut quoted = false;
        let mut characters = line.chars().peekable();
        while let Some(character) = characters.next() {
            match character {
                '\\' if quoted => drop(characters.next()),
                '"' => quoted = !quoted,
                '/' if !quoted && characters.peek() == Some(&'/') => break,
                _ if !quoted => code.push(character),
                _ => {}
            }
        }
        code.push('\n');
    }
    code
}

/// Returns the paths of the tree at the start of a text, such as `a::b` and `a::c` of `a::{b, c}`, and the text after
/// it.
fn tree(mut text: &str) -> (Vec<Vec<&str>>, &str) {
    let mut path = Vec::new();
    loop {
        text = text.trim_start();
        if let Some(mut rest) = text.strip_prefix('{') {
            let mut paths = Vec::new();
            loop {
                rest = rest.trim_start();
                if rest.is_empty() {
                    return (paths, rest);
                }
                if let Some(rest) = rest.strip_prefix('}') {
                    return (paths, rest);
                }
                let (branches, after) = tree(rest);
                paths.extend(branches.into_iter().map(|branch| [&path[..], &branch].concat()));
                let next = after.find([',', '}']).unwrap_or(after.len());
                rest = after[next..].trim_start_matches(',');
            }
        }
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
        path.push(&text[..end]);
        match text[end..].trim_start().strip_prefix("::") {
            Some(rest) => text = rest,
            None => return (vec![path], &text[end..]),
        }
    }
}

/// Returns the paths in a text that begin with a word.
fn paths<'t>(code: &'t str, word: &str) -> Vec<Vec<&'t str>> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$';
    let starts = code.match_indices(word).map(|(at, _)| at);
    starts.filter(|at| !code[..*at].ends_with(is_part)).flat_map(|at| tree(&code[at..]).0).collect()
}

/// Returns the path of a file's module within its crate.
fn module(file: &str) -> Vec<&str> {
    let (_, file) = file.split_once("/src/").unwrap();
    let mut path: Vec<&str> = file.trim_end_matches(".rs").split('/').collect();
    path.pop_if(|name| matches!(*name, "mod" | "lib"));
    path
}

/// Returns the names that the crate's root exports, each with its folder.
fn exported(root: &str) -> BTreeMap<String, String> {
    let code = code(root);
    let uses = code.match_indices("use ").flat_map(|(at, word)| tree(&code[at + word.len()..]).0);
    uses.map(|path| (path[path.len() - 1].to_owned(), path[0].to_owned())).collect()
}

/// Returns the uses of other folders that the table does not allow.
fn faults(files: &[(String, String)], exported: &BTreeMap<String, String>) -> Vec<String> {
    let folders: BTreeMap<&str, &[&str]> = FOLDERS.iter().copied().collect();
    let mut faults = Vec::new();
    for (file, text) in files {
        let module = module(file);
        let Some(own) = module.first() else { continue };
        let Some(allowed) = folders.get(own) else {
            faults.push(format!("{file} is in no folder of the table"));
            continue;
        };
        let code = code(text);
        for path in paths(&code, "crate::").into_iter().chain(paths(&code, "super::")) {
            let above = path.iter().take_while(|name| **name == "super").count();
            let from = if above > 0 { &module[..module.len().saturating_sub(above)] } else { &[] };
            let absolute = [from, &path[above.max(1)..]].concat();
            let Some(name) = absolute.first() else { continue };
            let folder = exported.get(*name).map_or(*name, String::as_str);
            if folder != *own && !allowed.contains(&folder) {
                faults.push(format!("{file} uses {folder}, by {}", path.join("::")));
            }
        }
    }
    faults
}

fn engine() -> (Vec<(String, String)>, BTreeMap<String, String>) {
    let source = root().join("crates/engine/src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    (files, exported(&std::fs::read_to_string(source.join("lib.rs")).unwrap()))
}

#[test]
fn folders_use_only_those_that_the_table_allows() {
    let (files, exported) = engine();
    for (folder, _) in FOLDERS {
        assert!(files.iter().any(|(file, _)| module(file).first() == Some(folder)), "{folder} has no files");
    }
    for (name, folder) in [("Plan", "planning"), ("EvalError", "running"), ("Settings", "settings")] {
        assert_eq!(exported[name], folder);
    }
    let faults = faults(&files, &exported);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_planted_import_is_found() {
    let (_, exported) = engine();
    let found = |file: &str, text: &str| {
        !faults(&[(format!("crates/engine/src/{file}"), text.to_owned())], &exported).is_empty()
    };
    for planted in [
        "use crate::running::run::programs;",
        "use crate::{\n    Plan,\n    EvalError,\n};",
        "use crate::{planning::{plan::Plan, lower::lower}, running::*};",
        "use super::super::running::memory::MemoryConsumer;",
        "fn f(error: &crate::running::frame::EvalError) {}",
        "const _: &str = \"\\\"\"; use crate::Frame as Picture;",
        "use crate::elsewhere::Thing;",
    ] {
        assert!(found("planning/plan.rs", planted), "not found: {planted}");
    }
    assert!(found("planning/deep/file.rs", "use super::super::super::running::tile::Worker;"));
    assert!(found("rules/error.rs", "use crate::planning::plan::Pass;"));
    assert!(found("elsewhere.rs", ""));
    for sound in [
        "use super::plan::Pass;\nuse crate::rules::{error, interval};\nuse crate::{Settings, Plan};",
        "//! As [`EvalError`](crate::EvalError).\n/// crate::running::run\npub(super) fn f() {} // crate::running",
        "const _: &str = \"crate::running::run\";",
    ] {
        assert!(!found("planning/plan.rs", sound), "found: {sound}");
    }
    assert!(!found("running/run.rs", "use crate::planning::plan::Pass;\nuse crate::EvalError;"));
}

//! Bad documents, each with what its diagnostic must say: place, what was found, what was expected, and a remedy.
//!
//! Every document has exactly the faults listed, one fragment list each: a fault must not drag others after it.

mod forms;
mod graphs;
mod kinds;
mod outputs;
mod refusals;
mod slips;
mod syntax;
mod top;
mod values;

use std::path::Path;
use trochoid::{Diagnostic, LoadError, Severity, load, parse};

/// A bad document and the fragments of each of its errors, in the order of the text.
struct Bad {
    name: &'static str,
    text: String,
    faults: &'static [&'static [&'static str]],
}

/// A whole document.
fn whole(name: &'static str, text: impl Into<String>, faults: &'static [&'static [&'static str]]) -> Bad {
    Bad { name, text: text.into(), faults }
}

/// A document that is sound but for some nodes, which stand in line 6.
fn nodes(name: &'static str, nodes: &str, faults: &'static [&'static [&'static str]]) -> Bad {
    with(name, nodes, r#""beauty": { "color": "x" }"#, faults)
}

/// A document that is sound but for its outputs, which stand in line 7.
fn outputs(name: &'static str, outputs: &str, faults: &'static [&'static [&'static str]]) -> Bad {
    with(name, r##""y": { "type": "Constant", "color": "#000" }"##, outputs, faults)
}

fn with(name: &'static str, nodes: &str, outputs: &str, faults: &'static [&'static [&'static str]]) -> Bad {
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{
"x": {{ "type": "Constant", "color": "#fff" }}, "t": {{ "type": "ScreenX" }}, "three": {{ "type": "Stack", "weights": [0.2, 0.5] }},
"camera": {{ "type": "Camera", "position": [0, 6, 30], "target": [0, 2, 0] }}, "sun": {{ "type": "Light", "direction": [0, 1, 0] }},
"sea": {{ "type": "GerstnerSea" }}, "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
"depth": {{ "type": "Depth", "view": "view" }}, "normal": {{ "type": "Normal", "view": "view" }},
{nodes} }}, "outputs": {{
{outputs} }} }}"##
    );
    Bad { name, text, faults }
}

/// A document with this in the place of `format`, `frames` and the like, in line 1.
fn top(name: &'static str, top: &str, faults: &'static [&'static [&'static str]]) -> Bad {
    let rest =
        r##""nodes": { "x": { "type": "Constant", "color": "#fff" } }, "outputs": { "beauty": { "color": "x" } } }"##;
    whole(name, format!("{{ {top}, {rest}"), faults)
}

const SOUND: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 },
  "nodes": { "x": { "type": "Constant", "color": "#fff" } }, "outputs": { "beauty": { "color": "x" } } }"##;

fn chain(count: usize, first: &str) -> String {
    let links = (1..count).map(|i| format!(r#""n{i}": {{ "type": "Invert", "weight": "n{}" }}"#, i - 1));
    let all: Vec<String> =
        std::iter::once(format!(r#""n0": {{ "type": "Invert", "weight": "{first}" }}"#)).chain(links).collect();
    all.join(", ")
}

/// The errors of a document; warnings are beside the point.
fn errors(text: &str) -> Vec<Diagnostic> {
    match parse("bad.json", text, Path::new("."), &[]) {
        Ok(_) => Vec::new(),
        Err(LoadError::Invalid(all)) => all.into_iter().filter(|one| one.severity == Severity::Error).collect(),
        Err(error) => panic!("{error}"),
    }
}

fn complaints(bad: &Bad) -> Vec<String> {
    let found: Vec<String> = errors(&bad.text).iter().map(Diagnostic::to_string).collect();
    let mut complaints = Vec::new();
    if found.len() != bad.faults.len() {
        complaints.push(format!("{} faults instead of {}", found.len(), bad.faults.len()));
    }
    for (text, fragments) in found.iter().zip(bad.faults) {
        if !text.starts_with("error: bad.json") || !text.contains("\n  remedy: ") {
            complaints.push("no place or no remedy".into());
        }
        if text.chars().count() > 1000 || text.chars().any(|c| c.is_control() && c != '\n') {
            complaints.push("too long, or control characters".into());
        }
        let missing = fragments.iter().filter(|fragment| !text.contains(*fragment));
        complaints.extend(missing.map(|fragment| format!("no \"{fragment}\"")));
    }
    if complaints.is_empty() {
        return complaints;
    }
    vec![format!("{}: {}\n{}", bad.name, complaints.join(", "), found.join("\n"))]
}

fn table() -> Vec<Bad> {
    [
        syntax::table(),
        top::table(),
        forms::table(),
        kinds::table(),
        values::table(),
        graphs::table(),
        refusals::table(),
        slips::table(),
        outputs::table(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[test]
fn every_bad_document_is_told_what_is_wrong_with_it() {
    let table = table();
    assert!(table.len() >= 60, "only {} documents", table.len());
    let complaints: Vec<String> = table.iter().flat_map(complaints).collect();
    assert!(complaints.is_empty(), "{} of {}:\n\n{}", complaints.len(), table.len(), complaints.join("\n\n"));
}

#[test]
fn what_the_table_builds_on_is_sound() {
    assert_eq!(errors(SOUND), []);
    assert_eq!(errors(&nodes("", r#""a": { "type": "ScreenY" }"#, &[]).text), []);
    assert_eq!(errors(&nodes("", &chain(500, "t"), &[]).text), []);
    assert_eq!(errors(&format!("\u{feff}{SOUND}")), [], "a byte order mark is no fault");
    assert_eq!(errors(&SOUND.replace('\n', "\r\n")), []);
}

#[test]
fn all_faults_are_told_at_once_in_the_order_of_the_text() {
    let text = r##"{ "trochoid": 2, "format": { "width": 0, "height": 4 }, "hello": 1,
      "nodes": { "a": { "type": "Plus" }, "b": { "type": "Mix", "a": "c", "weight": 3 } },
      "outputs": { "beauty": { "color": "zzz" } } }"##;
    let found = errors(text);
    let places: Vec<(usize, usize)> = found.iter().map(|fault| (fault.line, fault.column)).collect();
    assert_eq!(found.len(), 8, "{found:#?}");
    assert!(places.is_sorted());
}

#[test]
fn a_document_full_of_faults_is_not_listed_to_the_end() {
    let nodes: Vec<String> = (0..20_000).map(|i| format!(r#""n{i}": {{ "type": "Nonsense" }}"#)).collect();
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{ {} }}, "outputs": {{}} }}"#,
        nodes.join(",")
    );
    assert_eq!(errors(&text).len(), 1000);
}

#[test]
fn every_prefix_and_every_flipped_byte_is_refused_or_valid_but_never_a_panic() {
    let text = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 }, "frames": { "last": 9 }, "nodes": {
        "t": { "type": "ScreenX" }, "n": { "type": "Multiply", "weights": ["t", { "keys": [[1, 0], [5, 1e0]] }] },
        "r": { "type": "Ramp", "weight": "n.mask", "stops": [{ "at": 0.5, "color": "#fff" }] } },
        "outputs": { "beauty": { "color": "r", "file": "a.exr", "require": { "guarantee": "hull" } } } }"##;
    assert_eq!(errors(text), []);
    for end in 0..text.len() {
        errors(&text[..end]);
    }
    for at in 0..text.len() {
        for with in [b'"', b'{', b']', b'9', b'#', b' '] {
            let mut bytes = text.as_bytes().to_vec();
            bytes[at] = with;
            errors(&String::from_utf8(bytes).expect("ASCII"));
        }
    }
}

#[test]
fn files_that_are_no_documents_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let fault = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        load(&path, &[]).expect_err(name).to_string()
    };
    let text = fault("latin.json", b"{ \"notes\":\n \"caf\xe9\" }");
    assert!(
        text.contains("latin.json:2:6: found the byte 0xe9") && text.contains("save the document as UTF-8"),
        "{text}"
    );
    let text = fault("utf16.json", b"\xff\xfe{\0}\0");
    assert!(text.contains("utf16.json:1:1: found the byte 0xff"), "{text}");
    assert!(fault("nul.json", &[0; 100]).contains("nul.json:1:1"));
    assert!(fault("empty.json", b"").contains("an empty file"));
    let large = folder.path().join("large.json");
    std::fs::File::create(&large).and_then(|file| file.set_len(1 << 40)).expect("sparse");
    assert!(load(&large, &[]).expect_err("large").to_string().contains("at most 67108864 bytes"));
    assert!(matches!(load(folder.path(), &[]), Err(LoadError::Io { .. })));
    assert!(matches!(load(&folder.path().join("none.json"), &[]), Err(LoadError::Io { .. })));
}

#[test]
fn faults_of_set_name_the_option() {
    let set = |assignment: &str| match parse("good.json", SOUND, Path::new("."), &[assignment.into()]) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert_eq!(set("x.color=#123"), "");
    assert_eq!(set("x.color=[0.1, 0.2, 0.3]"), "");
    for (assignment, fragments) in [
        ("x", ["--set x", "NODE.KNOB=VALUE"]),
        ("x.color", ["--set x.color", "NODE.KNOB=VALUE"]),
        ("y.color=#123", ["node \"y\"", "a node of the document"]),
        ("x.colr=#123", ["unknown key \"colr\"", "did you mean \"color\"?"]),
        ("x.color=#12", ["--set x.color=#12", "#rrggbb"]),
        ("x.color=[1, 2", ["--set x.color=[1, 2", "EOF"]),
        ("x.color=[1, 2, -3]", ["found -3", "--set x.color=[1, 2, -3]"]),
        ("x.stops[0].at=1", ["which reaches into \"stops[0]\"", "--set 'x.stops=[{ … }]'"]),
        ("x.stops.0.at=1", ["which reaches into \"stops\"", "--set 'x.stops=[{ … }]'"]),
        ("format.width=7", ["\"format\", which is no node", "change \"format\" in the document itself"]),
        ("x.type=Plus", ["the operation Plus", "--set x.type=Plus"]),
    ] {
        let text = set(assignment);
        for fragment in fragments {
            assert!(text.contains(fragment), "{assignment}: no \"{fragment}\" in {text}");
        }
    }
}

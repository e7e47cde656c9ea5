//! Bad documents in bulk. The messages of single documents are stored in `tests/refusals`, and tested by the binary
//! `cases`.

use std::path::Path;
use trochoid::{Diagnostic, LoadError, Severity, load, parse};

const SOUND: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 },
  "nodes": { "x": { "type": "Constant", "color": "#fff" } }, "outputs": { "beauty": { "color": "x" } } }"##;

/// Returns the errors of a document, without warnings.
fn errors(text: &str) -> Vec<Diagnostic> {
    match parse("bad.json", text, Path::new("."), &[]) {
        Ok(_) => Vec::new(),
        Err(LoadError::Invalid(all)) => all.into_iter().filter(|one| one.severity == Severity::Error).collect(),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn byte_order_marks_and_line_endings_are_no_faults() {
    assert_eq!(errors(SOUND), []);
    assert_eq!(errors(&format!("\u{feff}{SOUND}")), [], "a byte order mark is no fault");
    assert_eq!(errors(&SOUND.replace('\n', "\r\n")), []);
}

#[test]
fn all_faults_are_reported_at_once_in_the_order_of_the_text() {
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
    let nodes: Vec<String> = (0..3_000).map(|i| format!(r#""n{i}": {{ "type": "Nonsense" }}"#)).collect();
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{ {} }}, "outputs": {{}} }}"#,
        nodes.join(",")
    );
    assert_eq!(errors(&text).len(), 1000);
}

#[test]
fn no_prefix_and_no_replaced_byte_of_a_document_causes_a_panic() {
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
fn large_files_folders_and_missing_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let large = folder.path().join("large.json");
    std::fs::File::create(&large).and_then(|file| file.set_len(1 << 40)).expect("sparse");
    assert!(load(&large, &[]).expect_err("large").to_string().contains("at most 67108864 bytes"));
    assert!(matches!(load(folder.path(), &[]), Err(LoadError::Io(_))));
    assert!(matches!(load(&folder.path().join("none.json"), &[]), Err(LoadError::Io(_))));
}

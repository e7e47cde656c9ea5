//! Code knows nodes only by their declarations: none asks for a node by its name, and no node asks for an item by its
//! key. Only the command line knows its options.

use crate::architecture::sources;
use crate::support::root;
use std::collections::BTreeSet;
use std::sync::LazyLock;

static NAMES: LazyLock<BTreeSet<&str>> = LazyLock::new(|| trochoid::registry().names().collect());

/// Words that are names of nodes and of something else too: kinds of value, operations of other programs, a label, a step of a
/// job.
const HOMONYMS: &[(&str, &[&str])] = &[
    ("crates/graph/src/kind.rs", &["Camera", "Light"]),
    ("crates/graph/src/refusal.rs", &["Multiply", "Screen"]),
    ("crates/editor/src/properties/mod.rs", &["Height"]),
    ("crates/cli/src/job/openjd.rs", &["Render"]),
];

/// Words in the files of other programs that look like names of nodes.
const FOREIGN: &[(&str, &[&str])] =
    &[("crates/nodes/src/files/cryptomatte.rs", &["CryptoObject00", "CryptoObject01", "MurmurHash3"])];

/// Calls that look values up by their keys; nodes have fields instead.
const LOOK_UPS: &[&str] =
    &["source(\"", "sources(\"", "number(\"", "numbers(\"", "choice(\"", "text(\"", "flag(\"", "color(\"", "is_set(\""];

/// Returns the string literals of a line of code; none for a comment.
fn literals(line: &str) -> Vec<&str> {
    if line.trim_start().starts_with("//") {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut rest = line;
    while let Some((_, behind)) = rest.split_once('"') {
        let mut escaped = false;
        let end = behind.find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        let Some(end) = end else { break };
        found.push(&behind[..end]);
        rest = &behind[end + 1..];
    }
    found
}

/// Returns the name by which a line asks for a node, unless it writes the node into a document.
fn names_a_node(line: &str) -> Option<&str> {
    let asked = |literal: &&str| NAMES.contains(*literal) && !line.contains(&format!("\"type\": \"{literal}\""));
    literals(line).into_iter().find(asked)
}

/// Returns the words of a text that look like names of nodes of two words.
fn compounds(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    words.filter(|word| {
        let humps = word.chars().filter(char::is_ascii_uppercase).count();
        let single = word.as_bytes().windows(2).all(|pair| !pair.iter().all(u8::is_ascii_uppercase));
        word.starts_with(|c: char| c.is_ascii_uppercase()) && humps >= 2 && single && word.len() > 3
    })
}

fn all_sources() -> Vec<(String, String)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        sources(&entry.unwrap().path().join("src"), &mut files);
    }
    assert!(files.len() > 500, "only {} sources", files.len());
    files
}

#[test]
fn no_code_asks_for_a_node_by_its_name() {
    let mut faults = Vec::new();
    for (place, text) in all_sources() {
        let other = HOMONYMS.iter().find(|(file, _)| *file == place).map_or(&[][..], |(_, words)| words);
        for (index, line) in text.lines().enumerate() {
            let name = names_a_node(line).filter(|name| !other.contains(name));
            faults.extend(name.map(|name| format!("{place}:{}: \"{name}\"", index + 1)));
        }
    }
    assert!(faults.is_empty(), "declare a role or an offer instead:\n{}", faults.join("\n"));
}

#[test]
fn no_node_looks_an_item_up_by_its_key() {
    let mut faults = Vec::new();
    for (place, text) in all_sources().into_iter().filter(|(place, _)| place.starts_with("crates/nodes/")) {
        for (index, line) in text.lines().enumerate() {
            let called = |look_up: &&&str| line.contains(&format!(".{look_up}"));
            faults.extend(LOOK_UPS.iter().find(called).map(|found| format!("{place}:{}: {found}…", index + 1)));
        }
    }
    assert!(faults.is_empty(), "name the field of the node's struct:\n{}", faults.join("\n"));
}

#[test]
fn messages_name_nodes_that_exist() {
    let mut faults = Vec::new();
    for (place, text) in all_sources().into_iter().filter(|(place, _)| place.starts_with("crates/nodes/")) {
        let foreign = FOREIGN.iter().find(|(file, _)| *file == place).map_or(&[][..], |(_, words)| words);
        // Attributes have words of other programs.
        let mut in_aliases = false;
        for (index, line) in text.lines().enumerate() {
            in_aliases |= line.starts_with("#[also_called");
            if !in_aliases {
                let unknown = literals(line)
                    .into_iter()
                    .flat_map(compounds)
                    .find(|word| !NAMES.contains(word) && !foreign.contains(word));
                faults.extend(unknown.map(|word| format!("{place}:{}: {word}", index + 1)));
            }
            in_aliases &= !line.ends_with(")]");
        }
    }
    assert!(faults.is_empty(), "no nodes of these names:\n{}", faults.join("\n"));
}

/// Crates that may name options of command lines.
const COMMAND_LINES: &[&str] = &["bench", "book", "cli", "terminal"];

/// Returns the first option that a line of code names. A whole command in backticks is allowed,
/// because it refers to the manual.
fn names_an_option(line: &str) -> Option<&str> {
    if line.trim_start().starts_with("//") {
        return None;
    }
    // Every other part is between backticks.
    let mut parts = line.split('`').enumerate();
    parts.find_map(|(index, part)| {
        let command = index % 2 == 1 && part.starts_with("trochoid ");
        let mut options = part.match_indices("--").filter(|(at, _)| {
            let starts = |c: char| c.is_ascii_lowercase();
            part[at + 2..].starts_with(starts) && !part[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '-')
        });
        options.next().filter(|_| !command).map(|(at, _)| &part[at..])
    })
}

#[test]
fn no_message_below_the_command_line_names_an_option() {
    let mut faults = Vec::new();
    for (place, text) in all_sources() {
        if COMMAND_LINES.iter().any(|name| place.starts_with(&format!("crates/{name}/"))) {
            continue;
        }
        for (index, line) in text.lines().enumerate() {
            faults.extend(names_an_option(line).map(|option| format!("{place}:{}: {option}", index + 1)));
        }
    }
    assert!(faults.is_empty(), "carry the remedy as data, and let the command line name it:\n{}", faults.join("\n"));
}

#[test]
fn the_searches_find_what_they_should() {
    assert_eq!(names_an_option(r#"    or allow more (--memory)""#), Some("--memory)\""));
    assert_eq!(names_an_option(r#"format!("--set {text}")"#), Some(r#"--set {text}")"#));
    for line in ["/// As `--set` does.", "`trochoid plan --out` writes it", "a -- b", "--1.0"] {
        assert_eq!(names_an_option(line), None, "{line}");
    }
    assert_eq!(names_a_node(r#"if node.ty == "Mix" {"#), Some("Mix"));
    assert_eq!(names_a_node(r#"write("say \"a\"", "Mix")"#), Some("Mix"));
    for line in [r#"// "Mix""#, r#"{ "type": "Mix" }"#, r#""Mix of both""#] {
        assert_eq!(names_a_node(line), None, "{line}");
    }
    let words: Vec<&str> = compounds("connect a GerstnerSea or a ToonSee, by OBJ, Render or NaN").collect();
    assert_eq!(words, ["GerstnerSea", "ToonSee"]);
}

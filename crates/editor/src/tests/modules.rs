//! Which modules of the editor may know which others.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Modules of the panels.
const PANELS: [&str; 9] =
    ["canvas", "help", "palette", "properties", "report", "text_panel", "timeline", "viewer", "waves"];

/// Modules above the panels, which combine them.
const ABOVE: [&str; 2] = ["editor", "window"];

/// Returns the source files of a module with their texts; paths start at the folder of the sources.
fn sources(module: &str) -> Vec<(PathBuf, String)> {
    fn files(place: PathBuf, found: &mut Vec<PathBuf>) {
        if place.is_dir() {
            std::fs::read_dir(place).unwrap().for_each(|entry| files(entry.unwrap().path(), found));
        } else if place.extension().is_some_and(|ending| ending == "rs") {
            found.push(place);
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut own = Vec::new();
    for place in [root.join(module), root.join(format!("{module}.rs"))] {
        if place.exists() {
            files(place, &mut own);
        }
    }
    assert!(!own.is_empty(), "{module} has no files");
    let read = |file: PathBuf| (file.strip_prefix(&root).unwrap().into(), std::fs::read_to_string(&file).unwrap());
    own.into_iter().map(read).collect()
}

/// Returns the path of the module that a source file holds.
fn module_of(file: &Path) -> Vec<String> {
    let file = file.with_extension("");
    let parts = file.iter().map(|part| part.to_str().unwrap().to_string());
    parts.filter(|part| part != "mod").collect()
}

/// A path from the crate's root; the empty one is the root itself, which knows everything.
type Place = Vec<String>;

/// Returns all paths into this crate in the code of a module: in imports, in other code, and in macros.
fn named(module: &[String], text: &str) -> BTreeSet<Place> {
    let mut found = BTreeSet::new();
    collect(&text.parse::<TokenStream>().unwrap(), module, &mut found);
    found
}

fn is_punct(token: Option<&TokenTree>, character: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == character)
}

fn ident(token: Option<&TokenTree>) -> Option<String> {
    let Some(TokenTree::Ident(ident)) = token else { return None };
    Some(ident.to_string())
}

/// Returns whether `::` begins here.
fn is_separator(tokens: &[TokenTree]) -> bool {
    is_punct(tokens.first(), ':') && is_punct(tokens.get(1), ':')
}

fn collect(tokens: &TokenStream, module: &[String], found: &mut BTreeSet<Place>) {
    let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
    let mut inner = module.to_vec();
    for (at, token) in tokens.iter().enumerate() {
        let before = at.checked_sub(1).map(|at| &tokens[at]);
        let continues = at >= 2 && is_separator(&tokens[at - 2..]);
        match token {
            TokenTree::Group(group) if !continues => {
                let declared = ident(before).filter(|_| at >= 2 && ident(tokens.get(at - 2)).as_deref() == Some("mod"));
                inner.extend(declared.clone());
                collect(&group.stream(), &inner, found);
                inner.truncate(module.len());
            }
            TokenTree::Ident(word) if !continues => {
                let rest = &tokens[at + 1..];
                let renamed = ident(rest.first()).is_some_and(|word| word == "as");
                let start: &[String] = match word.to_string().as_str() {
                    "crate" => &[],
                    "self" => module,
                    "super" => &module[..module.len().saturating_sub(1)],
                    _ => continue,
                };
                if is_separator(rest) {
                    follow(start.to_vec(), &rest[2..], found);
                } else if renamed {
                    // `use crate as name`, or a conversion of a value.
                    found.extend((word != "self").then(|| start.to_vec()));
                }
            }
            _ => {}
        }
    }
}

/// Collects the paths that continue another one, after its `::`.
fn follow(mut place: Place, tokens: &[TokenTree], found: &mut BTreeSet<Place>) {
    match tokens.first() {
        Some(TokenTree::Ident(word)) => {
            match word.to_string().as_str() {
                "super" => drop(place.pop()),
                "self" => {}
                name => place.push(name.into()),
            }
            match is_separator(&tokens[1..]) {
                true => follow(place, &tokens[3..], found),
                false => drop(found.insert(place)),
            }
        }
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
            let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
            for part in tokens.split(|token| is_punct(Some(token), ',')).filter(|part| !part.is_empty()) {
                follow(place.clone(), part, found);
            }
        }
        // `*`, or the types of a generic item.
        _ => drop(found.insert(place)),
    }
}

/// Asserts that none of the files of a module names anything in other modules.
fn knows_none(module: &str, others: &[&str]) {
    for (file, text) in sources(module) {
        for place in named(&module_of(&file), &text) {
            let allowed = place.first().is_some_and(|first| !others.contains(&first.as_str()));
            assert!(allowed, "{} names crate::{}", file.display(), place.join("::"));
        }
    }
}

#[test]
fn no_panel_knows_another() {
    for panel in PANELS {
        let others: Vec<&str> = PANELS.into_iter().filter(|other| *other != panel).chain(ABOVE).collect();
        knows_none(panel, &others);
    }
    // Panels communicate by actions, which must depend neither on panels nor on what draws them.
    let drawing = ["commands", "field", "layout", "prompts", "state"];
    knows_none("actions", &[&PANELS[..], &ABOVE, &drawing].concat());
}

#[test]
fn paths_are_found_in_every_form() {
    let cases: [(&str, &[&str]); 14] = [
        ("use crate::canvas::Canvas;", &["canvas::Canvas"]),
        ("use crate::canvas;", &["canvas"]),
        ("use crate::canvas as other;", &["canvas"]),
        (
            "pub(crate) use crate::{state::State, canvas::{self, place::*}};",
            &["canvas", "canvas::place", "state::State"],
        ),
        ("use {std::fmt, crate::canvas};", &["canvas"]),
        ("use super::super::canvas;", &["canvas"]),
        ("use super::{super::canvas, hull};", &["canvas", "viewer::hull"]),
        ("use self::marks::Mark;", &["viewer::near::marks::Mark"]),
        ("mod tests { use super::super::super::canvas; } use super::hull;", &["canvas", "viewer::hull"]),
        ("fn f(a: &crate::canvas::Canvas<u8>) { a.self_test() }", &["canvas::Canvas"]),
        (
            "fn f() { assert!(crate::canvas::is_open(), \"crate::waves::closed\"); } // crate::waves",
            &["canvas::is_open"],
        ),
        ("fn f() { super::super::super::canvas::f::<u8>() }", &["canvas::f"]),
        ("use crate as root;", &[""]),
        ("use super::super::*;", &[""]),
    ];
    let module = ["viewer".to_string(), "near".into()];
    for (text, expected) in cases {
        let found: Vec<String> = named(&module, text).iter().map(|place| place.join("::")).collect();
        assert_eq!(found, expected, "{text}");
    }
    assert_eq!(module_of(Path::new("viewer/near.rs")), module);
    assert_eq!(module_of(Path::new("viewer/mod.rs")), ["viewer"]);
}

#[test]
fn only_gestures_ask_for_edits_of_values() {
    // Widgets that change a value in place, and actions that edit without a gesture; only `field` may use them.
    let forbidden =
        ["DragValue", "Slider::", ".checkbox(", "color_edit_button", ".changed()", "Action::Edit(", "Action::Rewire("];
    for panel in ["palette", "properties", "timeline", "waves", "viewer"] {
        for (file, text) in sources(panel).into_iter().filter(|(file, _)| !file.ends_with("tests.rs")) {
            for word in forbidden {
                assert!(!text.contains(word), "{} has {word}", file.display());
            }
        }
    }
}

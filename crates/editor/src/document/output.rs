//! Edits of a document's outputs.

use super::change::Edit;
use super::json::{Op, Path, quoted};
use super::sheet::{Output, Sheet};
use serde_json::{Value, json};
use trochoid::Kind;

/// Keys under which an output may name its source.
pub const KEYS: [&str; 4] = ["color", "weights", "field", "recipe"];

/// Returns the path of an output in the document.
pub fn path(name: &str) -> Path {
    Path::default().to("outputs").to(name)
}

/// Returns the key under which an output names a source of this kind; `None` if no file can hold it.
fn key(kind: Option<Kind>) -> Option<&'static str> {
    match kind? {
        Kind::Color | Kind::Layers(_) | Kind::ANY => Some("color"),
        Kind::Weights(_) => Some("weights"),
        Kind::Field(_) => Some("field"),
        Kind::Surface | Kind::Camera | Kind::Light | Kind::View => None,
    }
}

/// Returns whether a file can hold a node's result.
pub fn is_renderable(sheet: &Sheet, from: (usize, usize)) -> bool {
    sheet.nodes[from.0].makes.get(from.1).is_some_and(|(_, kind)| key(*kind).is_some())
}

/// Returns the first result of a node that can be rendered.
pub fn renderable(sheet: &Sheet, node: usize) -> Option<usize> {
    sheet.nodes[node].makes.iter().position(|(_, kind)| key(*kind).is_some())
}

/// Returns the output with this name.
pub fn find<'s>(sheet: &'s Sheet, name: &str) -> Option<&'s Output> {
    sheet.outputs.iter().find(|output| output.name == name)
}

/// Returns the new name of an output that was renamed since the earlier sheet.
pub fn now(sheet: &Sheet, before: &Sheet, name: &str) -> Option<String> {
    let index = before.outputs.iter().position(|output| output.name == name)?;
    let now = sheet.outputs.get(index).filter(|_| sheet.outputs.len() == before.outputs.len())?;
    find(before, &now.name).is_none().then(|| now.name.clone())
}

/// Adds an output that renders a node's result, with a free name and a file in the folder of the first output's file.
/// Returns `None` if no file can hold the result.
pub fn made(sheet: &Sheet, from: (usize, usize)) -> Option<(Edit, String)> {
    let kind = sheet.nodes[from.0].makes.get(from.1)?.1;
    let key = key(kind)?;
    let source = sheet.reference(from.0, from.1);
    let name = free(sheet, &source.replace('.', "_"));
    let first = sheet.outputs.iter().find_map(|output| sheet.get(&path(&output.name).to("file"))?.as_str());
    let folder = first.and_then(|file| file.rfind(['/', '\\']).map(|end| &file[..=end])).unwrap_or_default();
    let png = kind == Some(Kind::Color) && first.is_some_and(|file| file.to_lowercase().ends_with(".png"));
    let file = format!("{folder}{name}.####.{}", if png { "png" } else { "exr" });
    let body = super::change::style(&json!({ key: source, "file": file }));
    Some((Edit::new(format!("Add output {name}"), vec![Op::Set(path(&name), body)]), name))
}

fn free(sheet: &Sheet, wanted: &str) -> String {
    let names = std::iter::once(wanted.to_string()).chain((2..).map(|n: usize| format!("{wanted}{n}")));
    names.into_iter().find(|name| find(sheet, name).is_none()).unwrap_or_default()
}

/// Redirects an output to another source. Returns `None` if no file can hold the result.
pub fn redirected(sheet: &Sheet, name: &str, from: (usize, usize)) -> Option<Edit> {
    let kind = sheet.nodes[from.0].makes.get(from.1)?.1;
    let new = key(kind)?;
    let source = sheet.reference(from.0, from.1);
    let path = path(name);
    let body = sheet.get(&path)?;
    let old = KEYS.into_iter().find(|key| body.get(key).is_some());
    let mut ops = Vec::new();
    // A recipe of another color stays a recipe.
    let new = if old == Some("recipe") && new == "color" { "recipe" } else { new };
    if let Some(old) = old.filter(|old| *old != new) {
        ops.push(Op::Rename(path.to(old), new.into()));
        // Only color outputs have a palette guarantee.
        if new != "color" && body.get("require").is_some() {
            ops.push(Op::Remove(path.to("require")));
        }
    }
    ops.push(Op::Set(path.to(new), quoted(&source)));
    // A PNG holds a color or a mask.
    let png = body.get("file").and_then(Value::as_str).and_then(|file| file.strip_suffix(".png"));
    if let Some(stem) = png.filter(|_| !matches!(kind, Some(Kind::Color | Kind::MASK))) {
        ops.push(Op::Set(path.to("file"), quoted(&format!("{stem}.exr"))));
        if body.get("precision").is_some() {
            ops.push(Op::Remove(path.to("precision")));
        }
    }
    Some(Edit::new(format!("Connect {source} to output {name}"), ops))
}

/// Returns the message why a node's result cannot be rendered.
pub fn unfit(sheet: &Sheet, from: (usize, usize)) -> String {
    let node = &sheet.nodes[from.0];
    match node.makes.get(from.1).and_then(|(_, kind)| *kind) {
        Some(kind) => {
            format!(
                "{} outputs a {kind}, which no file can hold; an output needs a color, weights, or a field",
                node.name
            )
        }
        None => format!("the output kind of {} is unknown: correct the node's type first", node.name),
    }
}

/// Renames an output.
pub fn renamed(from: &str, to: &str) -> Edit {
    Edit::new(format!("Rename output {from} to {to}"), vec![Op::Rename(path(from), to.into())])
}

/// Removes an output; its node stays.
pub fn removed(name: &str) -> Edit {
    Edit::new(format!("Remove output {name}"), vec![Op::Remove(path(name))])
}

/// Sets an optional setting of an output, or resets it to its default.
pub fn set(sheet: &Sheet, name: &str, key: &str, value: Option<Value>) -> Option<Edit> {
    let path = path(name).to(key);
    match value {
        Some(value) => Some(Edit::set(path.clone(), &value).merging(path.to_string())),
        None => sheet.get(&path).is_some().then(|| Edit::reset(path)),
    }
}

/// Reason that an output cannot have a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongName {
    /// The name has illegal characters.
    #[error("found the output name \"{0}\"; expected a–z, A–Z, 0–9, _ and -: choose another name")]
    Illegal(String),
    /// Another output has the name.
    #[error("an output \"{0}\" already exists: choose another name")]
    Taken(String),
}

/// Returns the reason that an output cannot have this name.
pub fn wrong_name(sheet: &Sheet, name: &str) -> Option<WrongName> {
    let legal = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if !legal {
        return Some(WrongName::Illegal(name.into()));
    }
    find(sheet, name).map(|_| WrongName::Taken(name.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;

    const TEXT: &str = r##"{
  "trochoid": 1,
  "format": { "width": 64, "height": 36 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [ { "at": 0, "color": "#2d3f52" }, { "at": 1, "color": "#f0cf8e" } ] },
    "twice": { "type": "FieldMath", "expression": "2*a", "a": "down" },
    "camera": { "type": "Camera" }
  },
  "outputs": { "beauty": { "color": "sky", "file": "out/beauty.####.png", "require": { "guarantee": "hull" } } }
}
"##;

    #[test]
    fn outputs_are_made_of_what_files_hold_and_can_be_taken_back() {
        let mut session = Session::new(TEXT.into(), None);
        for (node, name, body) in [
            ("sky", "sky", r#"{ "color": "sky", "file": "out/sky.####.png" }"#),
            ("sky", "sky2", r#"{ "color": "sky", "file": "out/sky2.####.png" }"#),
            ("down", "down", r#"{ "weights": "down", "file": "out/down.####.exr" }"#),
        ] {
            let sheet = session.sheet().clone();
            let from = sheet.find(node).unwrap();
            let (edit, made) = made(&sheet, (from, 0)).unwrap();
            assert_eq!(made, name);
            session.edit(edit).unwrap();
            let sheet = session.sheet();
            assert_eq!(sheet.get(&path(name)).map(super::super::change::style).unwrap(), body);
            assert_eq!(session.meaning().errors().count(), 0, "{:?}", session.meaning().diagnostics);
        }
        let sheet = session.sheet().clone();
        assert!(made(&sheet, (sheet.find("camera").unwrap(), 0)).is_none(), "no file holds a camera");
        session.edit(removed("down")).unwrap();
        for _ in 0..4 {
            session.undo();
        }
        assert_eq!(session.text(), TEXT);
    }

    #[test]
    fn an_output_that_shows_something_else_says_of_what_kind_it_is() {
        let mut session = Session::new(TEXT.into(), None);
        let sheet = session.sheet().clone();
        let [twice, sky] = ["twice", "sky"].map(|name| (sheet.find(name).unwrap(), 0));
        session.edit(redirected(&sheet, "beauty", twice).unwrap()).unwrap();
        let body = |session: &Session| session.sheet().get(&path("beauty")).map(super::super::change::style).unwrap();
        assert_eq!(body(&session), r#"{ "field": "twice", "file": "out/beauty.####.exr" }"#);
        let sheet = session.sheet().clone();
        session.edit(redirected(&sheet, "beauty", sky).unwrap()).unwrap();
        assert_eq!(body(&session), r#"{ "color": "sky", "file": "out/beauty.####.exr" }"#);
        session.edit(renamed("beauty", "final")).unwrap();
        assert!(find(session.sheet(), "final").is_some() && find(session.sheet(), "beauty").is_none());
        assert!(wrong_name(session.sheet(), "final").unwrap().to_string().contains("already"));
        assert!(wrong_name(session.sheet(), "a b").unwrap().to_string().contains("a–z"));
        assert_eq!(wrong_name(session.sheet(), "b-2"), None);
    }
}

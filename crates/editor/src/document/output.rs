//! What a document renders: changes of its outputs.

use super::change::Edit;
use super::json::{Op, Path, quoted};
use super::sheet::{Output, Sheet};
use serde_json::{Value, json};
use trochoid::Kind;

/// Under which of these an output names its node.
pub const KEYS: [&str; 3] = ["color", "weights", "field"];

/// Where an output stands in the document.
pub fn path(name: &str) -> Path {
    Path::default().to("outputs").to(name)
}

/// Under which key an output names what is of a kind; `None` where no file holds such.
fn key(kind: Option<Kind>) -> Option<&'static str> {
    match kind? {
        Kind::Color | Kind::ANY => Some("color"),
        Kind::Weights(_) => Some("weights"),
        Kind::Field(_) => Some("field"),
        Kind::Surface | Kind::Camera | Kind::Light | Kind::View => None,
    }
}

/// Whether a file can hold what a node makes.
pub fn is_renderable(sheet: &Sheet, from: (usize, usize)) -> bool {
    sheet.nodes[from.0].makes.get(from.1).is_some_and(|(_, kind)| key(*kind).is_some())
}

/// The first result of a node that can be rendered.
pub fn renderable(sheet: &Sheet, node: usize) -> Option<usize> {
    sheet.nodes[node].makes.iter().position(|(_, kind)| key(*kind).is_some())
}

/// The output of that name.
pub fn find<'s>(sheet: &'s Sheet, name: &str) -> Option<&'s Output> {
    sheet.outputs.iter().find(|output| output.name == name)
}

/// The name that an output of a sheet before has now, where it has another.
pub fn now(sheet: &Sheet, before: &Sheet, name: &str) -> Option<String> {
    let index = before.outputs.iter().position(|output| output.name == name)?;
    let now = sheet.outputs.get(index).filter(|_| sheet.outputs.len() == before.outputs.len())?;
    find(before, &now.name).is_none().then(|| now.name.clone())
}

/// Renders what a node makes: a new output with a name that is free, and its file beside that of the first. `None` where
/// no file holds such.
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
    Some((Edit::new(format!("Make the output {name}"), vec![Op::Set(path(&name), body)]), name))
}

fn free(sheet: &Sheet, wanted: &str) -> String {
    let names = std::iter::once(wanted.to_string()).chain((2..).map(|n: usize| format!("{wanted}{n}")));
    names.into_iter().find(|name| find(sheet, name).is_none()).unwrap_or_default()
}

/// Lets an output show something else. `None` where no file holds such.
pub fn redirected(sheet: &Sheet, name: &str, from: (usize, usize)) -> Option<Edit> {
    let kind = sheet.nodes[from.0].makes.get(from.1)?.1;
    let new = key(kind)?;
    let source = sheet.reference(from.0, from.1);
    let path = path(name);
    let body = sheet.get(&path)?;
    let old = KEYS.into_iter().find(|key| body.get(key).is_some());
    let mut ops = Vec::new();
    if let Some(old) = old.filter(|old| *old != new) {
        ops.push(Op::Rename(path.to(old), new.into()));
        // Only colors have a palette to keep to.
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
    Some(Edit::new(format!("Lead {source} to the output {name}"), ops))
}

/// Why what a node makes cannot be rendered.
pub fn unfit(sheet: &Sheet, from: (usize, usize)) -> String {
    let node = &sheet.nodes[from.0];
    match node.makes.get(from.1).and_then(|(_, kind)| *kind) {
        Some(kind) => {
            format!("{} makes a {kind}, which no file holds; an output needs a color, weights or a field", node.name)
        }
        None => format!("nothing is known of what {} makes: correct its type first", node.name),
    }
}

/// Gives an output another name.
pub fn renamed(from: &str, to: &str) -> Edit {
    Edit::new(format!("Rename the output {from} to {to}"), vec![Op::Rename(path(from), to.into())])
}

/// Takes an output away; its node stays.
pub fn removed(name: &str) -> Edit {
    Edit::new(format!("Remove the output {name}"), vec![Op::Remove(path(name))])
}

/// Sets one of an output's further settings, or takes it back to its default.
pub fn set(sheet: &Sheet, name: &str, key: &str, value: Option<Value>) -> Option<Edit> {
    let path = path(name).to(key);
    match value {
        Some(value) => Some(Edit::set(path.clone(), &value).merging(path.to_string())),
        None => sheet.get(&path).is_some().then(|| Edit::reset(path)),
    }
}

/// A name that an output cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongName {
    /// It has other characters.
    #[error("found the output name \"{0}\"; expected a–z, A–Z, 0–9, _ and -: choose another name")]
    Illegal(String),
    /// Another output has it.
    #[error("there is an output \"{0}\" already: choose another name")]
    Taken(String),
}

/// Why an output cannot have this name.
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

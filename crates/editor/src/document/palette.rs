//! Edits of a document's palette, each one step of undo.

use super::change::{Edit, style};
use super::color::hex;
use super::edit::count;
use super::json::{Op, Path, Step, quoted};
use super::sheet::Sheet;
use super::swatches::{Swatch, SwatchKey, entry, file, shown, space};
use serde_json::{Value, json};
use std::collections::HashSet;
use trochoid::nearest;

/// Reason that a change to the palette is refused: what is expected instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// The name is not one of the format.
    #[error("a name of a–z, A–Z, 0–9 and _ that does not start with a digit")]
    Illegal,
    /// Another color has the name.
    #[error("another name: a color with this name already exists; to make one color of both, merge them")]
    Taken,
    /// The palette is in a file.
    #[error("colors in the document, and these are in {0}: bring the palette into the document first")]
    Filed(String),
    /// Groups of an included file use the name.
    #[error("\"{name}\" to stay, because groups of {file} use it; the file is another document: change it there")]
    Included {
        /// The name.
        name: String,
        /// The file.
        file: String,
    },
    /// A palette names only colors that the document does not.
    #[error("names of the document's palette, and it has no {names}{}", .near.as_ref().map_or(String::new(), |near| format!("; did you mean {near}?")))]
    Unknown {
        /// The names.
        names: String,
        /// Name of the document that the only one was probably meant to be.
        near: Option<String>,
    },
}

/// Returns the name in the form in which a document has it, if a new color may have it.
///
/// # Errors
/// It is illegal or taken.
pub fn free(name: &str, all: &[Swatch]) -> Result<String, Refused> {
    let name = name.trim();
    let legal = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !legal {
        return Err(Refused::Illegal);
    }
    if all.iter().any(|own| own.key == SwatchKey::Named(name.into())) {
        return Err(Refused::Taken);
    }
    Ok(name.into())
}

/// Refuses changes to a palette that is in a file.
///
/// # Errors
/// It is.
pub fn within(sheet: &Sheet) -> Result<(), Refused> {
    file(sheet).map_or(Ok(()), |file| Err(Refused::Filed(file.into())))
}

fn reference(name: &str) -> String {
    quoted(&format!("palette.{name}"))
}

fn renaming(uses: &[Path], name: &str) -> Vec<Op> {
    uses.iter().map(|place| Op::Set(place.clone(), reference(name))).collect()
}

/// Renames a color; all its uses follow.
pub fn renamed(swatch: &Swatch, to: &str) -> Edit {
    let mut ops = renaming(&swatch.uses, to);
    let from = swatch.called();
    ops.push(Op::Rename(entry(&from), to.into()));
    Edit { around: renaming(&swatch.elsewhere, to), ..Edit::new(format!("Rename {from} to {to}"), ops) }
}

/// Lets all uses of a color be those of another one, a name of the palette, and removes it from the palette.
pub fn merged(swatch: &Swatch, into: &str) -> Edit {
    let mut ops = renaming(&swatch.uses, into);
    if let SwatchKey::Named(name) = &swatch.key {
        ops.push(Op::Remove(entry(name)));
    }
    let label = format!("Merge {} into {into}", swatch.called());
    Edit { around: renaming(&swatch.elsewhere, into), ..Edit::new(label, ops) }
}

/// Refuses to give up a name that groups of included files use.
///
/// # Errors
/// They do.
pub fn given_up(swatch: &Swatch) -> Result<(), Refused> {
    match swatch.included.first() {
        Some(file) => Err(Refused::Included { name: swatch.called(), file: file.clone() }),
        None => Ok(()),
    }
}

/// Removes a color that nothing uses.
pub fn removed(name: &str) -> Edit {
    Edit::new(format!("Delete {name}"), vec![Op::Remove(entry(name))])
}

/// Adds a color, with a name like `color`, `color_2`; also returns the name.
pub fn added(sheet: &Sheet, color: [f32; 3], all: &[Swatch]) -> (Edit, String) {
    let name = numbered("color", &|name| free(name, all).is_ok());
    let ops = with_entries(sheet, &[(name.clone(), json!(hex(color)))]);
    (Edit::new(format!("Add {name}"), ops), name)
}

/// Gives a color without a name one: its places then have the name.
pub fn named(sheet: &Sheet, swatch: &Swatch, name: &str) -> Edit {
    let entries = swatch.value.iter().map(|value| (name.to_string(), value.clone())).collect::<Vec<_>>();
    let mut ops = with_entries(sheet, &entries);
    ops.extend(renaming(&swatch.uses, name));
    Edit::new(format!("Name {name}"), ops)
}

/// Gives names to all colors without one, after the places where they are first used; `None` if all have names.
pub fn named_all(sheet: &Sheet, all: &[Swatch]) -> Option<Edit> {
    let literals = || all.iter().filter(|own| matches!(own.key, SwatchKey::Literal(_)));
    let mut taken = HashSet::new();
    let mut entries = Vec::new();
    let mut ops = Vec::new();
    for swatch in literals() {
        let wanted = swatch.uses.first().map_or_else(|| "color".into(), proposed);
        let name = numbered(&wanted, &|name| free(name, all).is_ok() && !taken.contains(name));
        taken.insert(name.clone());
        ops.extend(renaming(&swatch.uses, &name));
        entries.extend(swatch.value.iter().map(|value| (name.clone(), value.clone())));
    }
    let count = count(entries.len(), "color");
    let ops: Vec<Op> = with_entries(sheet, &entries).into_iter().chain(ops).collect();
    (!entries.is_empty()).then(|| Edit::new(format!("Name {count}"), ops))
}

/// Returns a name for a color by its place: of its node, and of the port, knob or record in it. What only says that it is
/// a color is left out: `sky.stops[1].color` becomes `sky_stops_1`.
pub fn proposed(place: &Path) -> String {
    let steps = place.0.get(1..).unwrap_or_default();
    let steps = match steps {
        [first, rest @ .., Step::Key(last)] if last == "color" => [std::slice::from_ref(first), rest].concat(),
        _ => steps.to_vec(),
    };
    let word = |step: &Step| match step {
        Step::Key(key) => key.clone(),
        Step::Index(index) => index.to_string(),
    };
    steps.iter().map(word).collect::<Vec<_>>().join("_")
}

/// Returns the first free name of `name`, `name_2`, `name_3`.
pub(super) fn numbered(wanted: &str, is_free: &dyn Fn(&str) -> bool) -> String {
    let others = (2..).map(|n: usize| format!("{wanted}_{n}"));
    std::iter::once(wanted.to_string()).chain(others).find(|name| is_free(name)).unwrap_or_default()
}

/// Adds entries to the palette. A palette that is not there yet gets a line for each.
fn with_entries(sheet: &Sheet, entries: &[(String, Value)]) -> Vec<Op> {
    if sheet.value.get("palette").is_some() {
        return entries.iter().map(|(name, value)| Op::Set(entry(name), style(value))).collect();
    }
    vec![Op::Set(Path::default().to("palette"), block(entries))]
}

/// Returns the text of a palette, with a line for each color.
pub fn block(entries: &[(String, Value)]) -> String {
    let lines = entries.iter().map(|(name, value)| format!("    {}: {}", quoted(name), style(value)));
    format!("{{\n{}\n  }}", lines.collect::<Vec<_>>().join(",\n"))
}

/// Replaces colors by those of the same names in another palette. Colors that it lacks stay as they are. Also returns
/// a list of the names that the document has not, whose colors are not taken: `None` if it has all.
///
/// # Errors
/// The palette is in a file, or the document has none of the names.
pub fn replaced(sheet: &Sheet, all: &[Swatch], by: &[(String, Value)]) -> Result<(Edit, Option<String>), Refused> {
    within(sheet)?;
    let own: Vec<&str> = names(all).collect();
    let strange: Vec<&str> = by.iter().map(|(name, _)| name.as_str()).filter(|name| !own.contains(name)).collect();
    if let [first, ..] = strange[..]
        && strange.len() == by.len()
    {
        let near = if strange.len() == 1 { nearest(first, own.iter().copied()).map(String::from) } else { None };
        return Err(Refused::Unknown { names: listed(&strange), near });
    }
    let known = |name: &str| all.iter().find(|own| own.key == SwatchKey::Named(name.into()));
    let changed = by.iter().filter(|(name, value)| known(name).is_some_and(|own| own.value.as_ref() != Some(value)));
    let ops: Vec<Op> = changed.map(|(name, value)| Op::Set(entry(name), style(value))).collect();
    let edit = Edit::new(format!("Replace {}", count(ops.len(), "color")), ops);
    Ok((edit, (!strange.is_empty()).then(|| listed(&strange))))
}

/// Takes all colors of another palette: those of the same names are replaced, the others added.
///
/// # Errors
/// The palette is in a file.
pub fn joined(sheet: &Sheet, by: &[(String, Value)]) -> Result<Edit, Refused> {
    within(sheet)?;
    Ok(Edit::new(format!("Take {}", count(by.len(), "color")), with_entries(sheet, by)))
}

/// Returns the names in the palette.
pub fn names(all: &[Swatch]) -> impl Iterator<Item = &str> {
    all.iter().filter_map(|own| match &own.key {
        SwatchKey::Named(name) => Some(name.as_str()),
        SwatchKey::Literal(_) => None,
    })
}

/// Lists names, the first ones of many.
fn listed(names: &[&str]) -> String {
    match names.split_at_checked(8) {
        Some((first, rest)) if !rest.is_empty() => format!("{} and {} more", first.join(", "), rest.len()),
        _ => names.join(", "),
    }
}

/// Writes the palette that a file has into the document.
pub fn brought(colors: &[(String, Value)]) -> Edit {
    Edit::new("Bring the palette into the document", vec![Op::Set(Path::default().to("palette"), block(colors))])
}

/// Sets the color of a swatch at a frame, wherever it is written: of keyed colors, the key at the frame. What looks
/// the same already stays as it is written.
///
/// # Errors
/// The palette is in a file.
pub fn colored(sheet: &Sheet, swatch: &Swatch, color: [f32; 3], frame: i64) -> Result<Edit, Refused> {
    if matches!(swatch.key, SwatchKey::Named(_)) {
        within(sheet)?;
    }
    let (text, space) = (hex(color), space(sheet));
    let op = |place: Path| -> Option<Op> {
        let old = sheet.get(&place)?;
        if shown(old, space, frame as f64).map(hex).as_ref() == Some(&text) {
            return None;
        }
        let Some(Value::Array(keys)) = old.get("keys") else { return Some(Op::Set(place, quoted(&text))) };
        let mut frames = keys.iter().map(|key| key.get(0).and_then(Value::as_f64).unwrap_or(f64::NAN));
        let at = frames.position(|own| own >= frame as f64).unwrap_or(keys.len());
        let has_key = keys.get(at).and_then(|key| key.get(0)?.as_f64()) == Some(frame as f64);
        let place = place.to("keys").to(at);
        Some(match has_key {
            true => Op::Set(place.to(1), quoted(&text)),
            false => Op::Insert(place, style(&json!([frame, text]))),
        })
    };
    let ops = swatch.places().into_iter().filter_map(op).collect();
    // Drags of a color merge into one step, whatever it looks like on the way.
    let (SwatchKey::Named(name) | SwatchKey::Literal(name)) = &swatch.key;
    Ok(Edit::new(format!("Set {name}"), ops).merging(format!("color {name}")))
}

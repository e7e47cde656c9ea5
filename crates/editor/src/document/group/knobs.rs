//! Knobs and inputs of groups, and their names.

use super::NoGroup;
use super::link;
use super::local::uses;
use super::make::free;
use crate::document::change::{Edit, style};
use crate::document::edit::default_value;
use crate::document::json::{Op, Path, Step, quoted};
use crate::document::sheet::Sheet;
use serde_json::{Map, Value};
use trochoid::{Item, Knob};

/// Returns node, item and value of a knob that can become one of what is around its node.
///
/// # Errors
/// The place is no knob of a node, or its value is a link.
pub(super) fn unlinked<'p>(
    sheet: &Sheet,
    place: &'p Path,
    declared: Option<&Knob>,
) -> Result<(&'p str, &'p str, Value), NoGroup> {
    let [Step::Key(nodes), Step::Key(node), rest @ ..] = place.0.as_slice() else { return Err(NoGroup::NoKnob) };
    let (true, Some(Step::Key(item))) = (nodes == "nodes", rest.last()) else { return Err(NoGroup::NoKnob) };
    let value = sheet.get(place).cloned().or_else(|| declared.map(default_value)).ok_or(NoGroup::NoKnob)?;
    let mut is_linked = false;
    link::each(&value, &mut |_| is_linked = true);
    if is_linked {
        return Err(NoGroup::Linked(format!("{node}.{item}")));
    }
    Ok((node, item, value))
}

/// Makes the value of a knob of a node within a group a knob of the group, which is linked there. `place` is its path in
/// the sheet of the group, and `declared` its declaration. Returns the edit and the name of the knob.
///
/// # Errors
/// The place is no knob of a node in a group, or it is a link.
pub fn promoted(sheet: &Sheet, place: &Path, declared: Option<&Knob>) -> Result<(Edit, String), NoGroup> {
    let within = sheet.within.as_ref().ok_or(NoGroup::NoKnob)?;
    let group = sheet.library.group(within.group()).ok_or(NoGroup::NoKnob)?;
    let (node, item, value) = unlinked(sheet, place, declared)?;
    let is_taken = |name: &str| group.has("knobs", name) || group.has("inputs", name);
    let wanted = if is_taken(item) { format!("{node}_{item}") } else { item.into() };
    let name = free(&wanted, is_taken);
    let mut definition = Map::new();
    definition.insert("default".into(), value.clone());
    if let Some(knob) = declared {
        for (key, text) in [("unit", knob.unit), ("help", knob.help)] {
            if !text.is_empty() {
                definition.insert(key.into(), text.into());
            }
        }
    }
    let ops = vec![
        Op::Set(within.definition().to("knobs").to(&name), style(&Value::Object(definition))),
        Op::Set(place.clone(), quoted(&format!("= knobs.{name}"))),
    ];
    Ok((Edit::new(format!("Promote {node}.{item}"), ops), name))
}

/// Returns the paths of the nodes that use a group, and how many uses that makes in the whole document, as far as it is
/// written there.
pub fn groups_using(root: &Sheet, name: &str) -> (Vec<Path>, usize) {
    let places = uses(root, name);
    let count = places.len();
    (places, count)
}

/// Renames a group and the type of all its uses.
pub fn renamed_group(root: &Sheet, from: &str, to: &str) -> Edit {
    let mut ops: Vec<Op> = uses(root, from).into_iter().map(|place| Op::Set(place.to("type"), quoted(to))).collect();
    ops.push(Op::Rename(Path::default().to("groups").to(from), to.into()));
    Edit::new(format!("Rename group {from} to {to}"), ops)
}

/// Renames what uses of a group set, in all its uses: an input or a knob.
pub fn renamed_input(root: &Sheet, group: &str, from: &str, to: &str) -> Vec<Op> {
    let places = uses(root, group).into_iter().filter(|place| root.get(&place.to(from)).is_some());
    places.map(|place| Op::Rename(place.to(from), to.into())).collect()
}

/// Returns the operations that follow the renaming of an output of a group: references to it have its new name.
pub fn renamed_output(root: &Sheet, group: &str, from: &str, to: &str) -> Vec<Op> {
    let mut ops = Vec::new();
    for place in uses(root, group) {
        let [scope @ .., _, Step::Key(name)] = place.0.as_slice() else { continue };
        let (scope, old) = (Path(scope.to_vec()), format!("{name}.{from}"));
        for key in ["nodes", "outputs"] {
            let mut new = |text: &str| (text == old).then(|| format!("{name}.{to}"));
            reworded(scope.to(key).find(&root.value), &scope.to(key), &mut new, &mut ops);
        }
    }
    ops
}

/// Renames a knob of a group, in its uses and in the links to it.
pub fn renamed_knob(root: &Sheet, group: &str, from: &str, to: &str) -> Edit {
    let own = Path::default().to("groups").to(group);
    // Links name it within the group, and where nodes beside a use are linked to the use.
    let mut scopes = vec![(own.clone(), "knobs".to_string())];
    for place in uses(root, group) {
        if let [scope @ .., _, Step::Key(name)] = place.0.as_slice() {
            scopes.push((Path(scope.to_vec()), name.clone()));
        }
    }
    let mut ops = Vec::new();
    for (scope, name) in scopes {
        for key in ["nodes", "knobs"] {
            relinked(root, &scope.to(key), (&name, Some(from)), (&name, to), &mut ops);
        }
    }
    ops.extend(renamed_input(root, group, from, to));
    ops.push(Op::Rename(own.to("knobs").to(from), to.into()));
    Edit::new(format!("Rename knob {from} to {to}"), ops)
}

/// Returns the operations that follow the renaming of a node: links lead to it by its new name.
pub fn relinked_to(sheet: &Sheet, from: &str, to: &str) -> Vec<Op> {
    let mut ops = Vec::new();
    let keys: &[&str] = if sheet.within.is_none() { &["nodes", "knobs"] } else { &["nodes"] };
    for key in keys {
        relinked(sheet, &Path::default().to(*key), (from, None), (to, ""), &mut ops);
    }
    ops
}

/// Rewrites links to a knob of a node, or to all of its knobs, below a path.
pub(super) fn relinked(sheet: &Sheet, at: &Path, from: (&str, Option<&str>), to: (&str, &str), ops: &mut Vec<Op>) {
    let mut new = |text: &str| {
        let linked = link::replaced::<()>(text, |node, knob| {
            let is_it = node == from.0 && from.1.is_none_or(|known| known == knob);
            Ok(is_it.then(|| format!("{}.{}", to.0, if from.1.is_some() { to.1 } else { knob })))
        });
        linked.ok().filter(|new| link::is_link(text) && new != text)
    };
    reworded(sheet.get(at), at, &mut new, ops);
}

/// Replaces texts below a path for which there is a new one.
fn reworded(value: Option<&Value>, at: &Path, new: &mut dyn FnMut(&str) -> Option<String>, ops: &mut Vec<Op>) {
    match value {
        Some(Value::String(text)) => ops.extend(new(text).map(|new| Op::Set(at.clone(), quoted(&new)))),
        Some(Value::Array(items)) => {
            items.iter().enumerate().for_each(|(index, item)| reworded(Some(item), &at.to(index), new, ops));
        }
        Some(Value::Object(entries)) => {
            let all = entries.iter().filter(|(key, _)| !link::is_remark(key));
            all.for_each(|(key, value)| reworded(Some(value), &at.to(key), new, ops));
        }
        _ => {}
    }
}

/// Returns the declaration of the knob at a path in a node.
pub fn declared_at(items: &'static [Item], steps: &[Step]) -> Option<&'static Knob> {
    let [Step::Key(name), rest @ ..] = steps else { return None };
    items.iter().find(|item| item.name() == name).and_then(|item| match (item, rest) {
        (Item::Knob(knob), []) => Some(knob),
        (Item::List(list), [Step::Index(_), rest @ ..]) => declared_at(list.items, rest),
        _ => None,
    })
}

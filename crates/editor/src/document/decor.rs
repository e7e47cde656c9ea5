//! Edits of the `ui` entries other than node positions: backdrops, and dots on wires.

use super::change::{Edit, style};
use super::json::{Op, Path, Step};
use super::sheet::{Backdrop, Point, Sheet, point};
use serde_json::{Value, json};

fn wires() -> Path {
    Path::default().to("ui").to("wires")
}

fn backdrop(name: &str) -> Path {
    Path::default().to("ui").to("backdrops").to(name)
}

fn rounded(at: Point) -> Value {
    json!([f64::from(at[0]).round(), f64::from(at[1]).round()])
}

/// Returns the key under which the dots of the wire to a pin are stored: `sky.weight`, `view.surfaces[1]`.
pub fn key(sheet: &Sheet, to: (usize, usize)) -> String {
    let node = &sheet.nodes[to.0];
    Path(std::iter::once(Step::from(&node.name)).chain(node.pins[to.1].steps.iter().cloned()).collect()).to_string()
}

/// Returns the dots of the wire to a pin, in order from its source.
pub fn dots(sheet: &Sheet, to: (usize, usize)) -> Vec<Point> {
    // Most documents have no dots; computing keys is skipped for them.
    let Some(all) = wires().find(&sheet.value) else { return Vec::new() };
    let points = all.get(key(sheet, to)).and_then(Value::as_array);
    points.into_iter().flatten().filter_map(|at| point(Some(at))).collect()
}

/// Sets the dots of the wire to a pin; an empty list removes them.
pub fn dotted(sheet: &Sheet, to: (usize, usize), points: &[Point]) -> Edit {
    let key = key(sheet, to);
    let path = wires().to(&key);
    let ops = match points {
        [] if sheet.get(&path).is_none() => Vec::new(),
        [] => vec![Op::Remove(path)],
        points => vec![Op::Set(path, style(&points.iter().copied().map(rounded).collect()))],
    };
    Edit::new(format!("Route the wire to {key}"), ops)
}

/// Removes the dots of wires to a deleted node.
pub fn undotted(sheet: &Sheet, name: &str) -> Vec<Op> {
    keys_of(sheet, name).map(|key| Op::Remove(wires().to(key))).collect()
}

/// Renames the dots of wires to a renamed node.
pub fn redotted(sheet: &Sheet, from: &str, to: &str) -> Vec<Op> {
    let renamed = keys_of(sheet, from).map(|key| Op::Rename(wires().to(key), format!("{to}{}", &key[from.len()..])));
    renamed.collect()
}

fn keys_of<'s>(sheet: &'s Sheet, name: &'s str) -> impl Iterator<Item = &'s String> {
    let all = wires().find(&sheet.value).and_then(Value::as_object);
    let of = move |key: &str| key.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
    all.into_iter().flat_map(|all| all.keys()).filter(move |key| of(key))
}

/// Extends an edit to keep dots with their wires: if list elements are removed or inserted, the dots of later elements
/// move along.
pub fn following(sheet: &Sheet, edit: Edit) -> Edit {
    let all = wires().find(&sheet.value).and_then(Value::as_object);
    let mut keys: Vec<String> = all.into_iter().flat_map(|all| all.keys().cloned()).collect();
    if keys.is_empty() {
        return edit;
    }
    let mut ops = Vec::new();
    for op in edit.ops {
        let own = |path: &Path| match path.0.split_last() {
            Some((Step::Key(key), above)) if *above == *wires().0 => Some(key.clone()),
            _ => None,
        };
        let mut entailed = Vec::new();
        match &op {
            Op::Remove(path) => {
                keys.retain(|key| Some(key) != own(path).as_ref());
                entailed = shifted(&mut keys, path, false);
            }
            Op::Insert(path, _) => entailed = shifted(&mut keys, path, true),
            Op::Rename(path, new) if own(path).is_some() => {
                keys.retain(|key| Some(key) != own(path).as_ref());
                keys.push(new.clone());
            }
            Op::Rename(..) | Op::Set(..) => {}
        }
        ops.push(op);
        ops.extend(entailed);
    }
    Edit { ops, ..edit }
}

/// Returns the operations that move dots after an element of a node's list is removed or inserted.
fn shifted(keys: &mut Vec<String>, place: &Path, comes: bool) -> Vec<Op> {
    let [Step::Key(top), list @ .., Step::Index(at)] = place.0.as_slice() else { return Vec::new() };
    if top != "nodes" {
        return Vec::new();
    }
    let list = format!("{}[", Path(list.to_vec()));
    let read = |key: &str| {
        let (index, rest) = key.strip_prefix(&list)?.split_once(']')?;
        Some((index.parse::<usize>().ok()?, rest.to_string()))
    };
    let mut behind: Vec<(usize, String)> =
        keys.iter().filter_map(|key| read(key)).filter(|(index, _)| index >= at).collect();
    behind.sort();
    if comes {
        // Starts at the end, so that no two entries share a key.
        behind.reverse();
    }
    let mut ops = Vec::new();
    for (index, rest) in behind {
        let old = format!("{list}{index}]{rest}");
        keys.retain(|key| *key != old);
        if !comes && index == *at {
            ops.push(Op::Remove(wires().to(&old)));
            continue;
        }
        let new = format!("{list}{}]{rest}", if comes { index + 1 } else { index - 1 });
        ops.push(Op::Rename(wires().to(&old), new.clone()));
        keys.push(new);
    }
    ops
}

/// Changes only those entries of a backdrop that differ, and leaves the rest of its text untouched.
pub fn reframed(label: &str, sheet: &Sheet, name: &str, body: &Backdrop) -> Edit {
    let Some(old) = sheet.backdrops.get(name) else { return Edit::new(label, Vec::new()) };
    let entries = [
        ("at", old.at != body.at, rounded(body.at)),
        ("size", old.size != body.size, rounded(body.size)),
        ("text", old.text != body.text, json!(body.text)),
        ("tint", old.tint != body.tint, json!(body.tint)),
    ];
    let changed = entries.into_iter().filter(|(_, differs, _)| *differs);
    Edit::new(label, changed.map(|(key, _, value)| Op::Set(backdrop(name).to(key), style(&value))).collect())
}

/// Adds a backdrop.
pub fn framed(label: &str, name: &str, body: &Backdrop) -> Edit {
    let value = json!({
        "at": rounded(body.at), "size": rounded(body.size), "text": body.text, "tint": body.tint,
    });
    Edit::new(label, vec![Op::Set(backdrop(name), style(&value))])
}

/// Removes a backdrop; the nodes on it stay.
pub fn unframed(name: &str) -> Edit {
    Edit::new("Delete a backdrop", vec![Op::Remove(backdrop(name))])
}

/// Returns an unused backdrop name.
pub fn free_backdrop(sheet: &Sheet) -> String {
    let names = (1..).map(|n: usize| format!("backdrop{n}"));
    names.into_iter().find(|name| !sheet.backdrops.contains_key(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;
    use crate::document::edit::{deleted, renamed};
    use crate::testing::RAMP;

    fn new() -> Session {
        Session::new(RAMP.into(), None)
    }

    fn pin(sheet: &Sheet) -> (usize, usize) {
        sheet.wires[0].to
    }

    #[test]
    fn dots_are_kept_with_the_wire_and_follow_its_node() {
        let mut session = new();
        let sheet = session.sheet().clone();
        assert_eq!(key(&sheet, pin(&sheet)), "sky.weight");
        assert_eq!(dotted(&sheet, pin(&sheet), &[]).ops, []);
        session.edit(dotted(&sheet, pin(&sheet), &[[10.4, 20.0], [30.0, 40.0]])).unwrap();
        let sheet = session.sheet().clone();
        assert_eq!(dots(&sheet, pin(&sheet)), [[10.0, 20.0], [30.0, 40.0]]);
        session.edit(renamed(&sheet, "sky", "air")).unwrap();
        let sheet = session.sheet().clone();
        assert_eq!(key(&sheet, pin(&sheet)), "air.weight");
        assert_eq!(dots(&sheet, pin(&sheet)).len(), 2);
        session.edit(deleted(&sheet, &["air".into()])).unwrap();
        assert!(!session.text().contains("air.weight"));
        session.undo();
        session.undo();
        session.undo();
        assert_eq!(session.text(), RAMP);
    }

    #[test]
    fn a_node_does_not_take_the_dots_of_one_whose_name_begins_as_its_own() {
        let mut session = new();
        let sheet = session.sheet().clone();
        session.edit(dotted(&sheet, pin(&sheet), &[[1.0, 2.0]])).unwrap();
        assert_eq!(undotted(session.sheet(), "sk"), []);
        assert_eq!(undotted(session.sheet(), "sky").len(), 1);
    }

    #[test]
    fn dots_stay_with_the_elements_of_a_list() {
        let text =
            RAMP.replace("\"down\": {", "\"all\": { \"type\": \"Stack\", \"layers\": [0, 1, 2, 3] },\n    \"down\": {");
        let text = text.replacen(
            '{',
            "{ \"ui\": { \"wires\": { \"all.layers[0]\": [[0, 0]], \"all.layers[1]\": [[1, 1]], \
            \"all.layers[3].over\": [[3, 3]], \"all.layers[2]\": [[2, 2]], \"allx.layers[3]\": [[9, 9]] } },",
            1,
        );
        let mut session = Session::new(text.clone(), None);
        let list = Path::node("all").to("layers");
        let wires = |session: &Session| style(&session.sheet().value["ui"]["wires"]);
        session.edit(Edit::new("Remove", vec![Op::Remove(list.to(1))])).unwrap();
        assert_eq!(
            wires(&session),
            "{ \"all.layers[0]\": [[0, 0]], \"all.layers[2].over\": [[3, 3]], \"all.layers[1]\": [[2, 2]], \
             \"allx.layers[3]\": [[9, 9]] }"
        );
        session.undo();
        assert_eq!(session.text(), text);
        // Two removals in one edit, as when two nodes are deleted.
        session.edit(Edit::new("Remove", vec![Op::Remove(list.to(2)), Op::Remove(list.to(0))])).unwrap();
        assert_eq!(
            wires(&session),
            "{ \"all.layers[0]\": [[1, 1]], \"all.layers[1].over\": [[3, 3]], \"allx.layers[3]\": [[9, 9]] }"
        );
        session.undo();
        session.edit(Edit::new("Insert", vec![Op::Insert(list.to(1), "7".into())])).unwrap();
        assert_eq!(
            wires(&session),
            "{ \"all.layers[0]\": [[0, 0]], \"all.layers[2]\": [[1, 1]], \"all.layers[4].over\": [[3, 3]], \
             \"all.layers[3]\": [[2, 2]], \"allx.layers[3]\": [[9, 9]] }"
        );
        session.undo();
        assert_eq!(session.text(), text);
    }

    #[test]
    fn backdrops_are_read_as_they_were_written() {
        let mut session = new();
        let body = Backdrop { at: [-20.0, 5.0], size: [300.0, 200.0], text: "sky\nand air".into(), tint: 3 };
        let name = free_backdrop(session.sheet());
        session.edit(framed("Add a backdrop", &name, &body)).unwrap();
        assert_eq!(session.sheet().backdrops[&name], body);
        assert_ne!(free_backdrop(session.sheet()), name);
        // What is not changed stays as it is written.
        let by_hand = session.text().replace("\"at\": [-20, 5]", "\"at\": [ -20.25, 5.0 ], \"mine\": true");
        session.replace(&by_hand, "Edit the text");
        let body = Backdrop { text: "air".into(), ..session.sheet().backdrops[&name].clone() };
        session.edit(reframed("Write", session.sheet(), &name, &body)).unwrap();
        assert_eq!(session.text(), by_hand.replace("sky\\nand air", "air"));
        session.undo();
        assert_eq!(reframed("Write", session.sheet(), &name, &session.sheet().backdrops[&name]).ops, []);
        session.edit(unframed(&name)).unwrap();
        assert!(session.sheet().backdrops.is_empty());
    }
}

//! Edits of nodes and wires, each one step of undo.

use super::change::{Edit, style};
use super::clip;
use super::decor;
use super::group;
use super::json::{Op, Path, quoted};
use super::link;
use super::sheet::{Node, Point, Sheet, Wire};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, HashMap, HashSet};
use trochoid::{Accepts, Declaration, Item, Kind, Knob, KnobDefault, smallest_node, smallest_record, stand_in};

/// Formats a count: `2 nodes`, `1 node`.
pub fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

fn position(at: Point) -> Value {
    let round = |x: f32| f64::from(x).round();
    json!([round(at[0]), round(at[1])])
}

fn placed(name: &str) -> Path {
    Path::default().to("ui").to("positions").to(name)
}

/// Moves nodes to new places.
pub fn moved(places: &[(String, Point)]) -> Edit {
    let ops = places.iter().map(|(name, at)| Op::Set(placed(name), style(&position(*at)))).collect();
    Edit::new(format!("Move {}", count(places.len(), "node")), ops)
}

/// Sets the places of many nodes at once.
pub fn laid_out(sheet: &Sheet, places: &[(String, Point)]) -> Edit {
    let mut all: Map<String, Value> =
        sheet.nodes.iter().filter(|node| node.placed).map(|node| (node.name.clone(), position(node.at))).collect();
    all.extend(places.iter().map(|(name, at)| (name.clone(), position(*at))));
    let lines: Vec<String> = all.iter().map(|(name, at)| format!("{}: {}", quoted(name), style(at))).collect();
    let text = format!("{{\n      {}\n    }}", lines.join(",\n      "));
    Edit::new("Arrange nodes", vec![Op::Set(Path::default().to("ui").to("positions"), text)])
}

/// Adds a node, with a value for every required item that can be a constant; also returns its name.
pub fn added(sheet: &Sheet, declaration: &'static Declaration, at: Point) -> (Edit, String) {
    let name = sheet.free_name(&snake(declaration.name));
    let mut body = smallest_node(declaration, &|_| None);
    complete_gradient(declaration.items, &mut body);
    let ops = vec![Op::Set(Path::node(&name), style(&body)), Op::Set(placed(&name), style(&position(at)))];
    (Edit::new(format!("Add {}", declaration.name), ops), name)
}

/// Gives a new gradient two stops, from black to white: with one stop, it would be a plain color.
fn complete_gradient(items: &[Item], body: &mut Value) {
    for item in items {
        let Item::List(list) = item else { continue };
        let color = list.items.iter().find(|item| matches!(item, Item::Port(port) if port.accepts.takes_color()));
        let is_gradient = list.min == 1 && list.items.iter().any(|item| item.name() == "at");
        if let Some(color) = color.filter(|_| is_gradient) {
            let stops = ["#000000", "#ffffff"].into_iter().enumerate().map(|(index, ink)| {
                let mut stop = record(list.items, index);
                stop[color.name()] = json!(ink);
                stop
            });
            body[list.name] = stops.collect();
        }
    }
}

/// Converts a type name to the style of node names: `NonSpecular` to `non_specular`.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(c.to_lowercase());
    }
    snake
}

/// Returns a list record with a value for every required item that can be a constant.
pub fn record(items: &[Item], index: usize) -> Value {
    smallest_record(items, index, &|_| None)
}

/// Returns the value of a knob that the document does not set.
pub fn default_value(knob: &Knob) -> Value {
    match knob.default {
        Some(KnobDefault::Number(number)) => json!(number),
        Some(KnobDefault::Bool(value)) => json!(value),
        Some(KnobDefault::Text(text)) => json!(text),
        Some(KnobDefault::Vector(values)) => json!(values),
        Some(KnobDefault::Unset) | None => stand_in(&knob.takes),
    }
}

/// Connects an output to a pin.
pub fn connected(sheet: &Sheet, from: (usize, usize), to: (usize, usize)) -> Edit {
    let (node, pin) = (&sheet.nodes[to.0], &sheet.nodes[to.0].pins[to.1]);
    let source = sheet.reference(from.0, from.1);
    let label = format!("Connect {source} to {}", node.name);
    Edit::new(label, vec![Op::Set(Path::node(&node.name).join(&pin.steps), quoted(&source))])
}

/// Disconnects a pin. A required pin gets a constant if it accepts one.
pub fn disconnected(sheet: &Sheet, to: (usize, usize)) -> Edit {
    let (node, pin) = (&sheet.nodes[to.0], &sheet.nodes[to.0].pins[to.1]);
    let path = Path::node(&node.name).join(&pin.steps);
    let label = format!("Disconnect {}.{}", node.name, pin.label);
    let op = match pin.accepts {
        _ if pin.of_list || !pin.required => Op::Remove(path),
        Accepts::Color | Accepts::Image => Op::Set(path, "\"#808080\"".into()),
        Accepts::Mask => Op::Set(path, "0.5".into()),
        accepts if accepts.takes_number() => Op::Set(path, "0".into()),
        _ => Op::Remove(path),
    };
    Edit::new(label, vec![op])
}

/// Deletes nodes. Whatever used their results is connected to their input of the same kind, if there is one.
pub fn deleted(sheet: &Sheet, names: &[String]) -> Edit {
    let gone: HashSet<usize> = names.iter().filter_map(|name| sheet.find(name)).collect();
    let mut ops = bypass(sheet, &gone);
    for &node in &sorted(&gone) {
        let name = &sheet.nodes[node].name;
        ops.push(Op::Remove(Path::node(name)));
        ops.extend(decor::undotted(sheet, name));
        if sheet.nodes[node].placed {
            ops.push(Op::Remove(placed(name)));
        }
    }
    Edit::new(format!("Delete {}", count(gone.len(), "node")), ops)
}

/// Disconnects nodes from the wires that run through them, and keeps the nodes.
pub fn extracted(sheet: &Sheet, names: &[String]) -> Edit {
    let out: HashSet<usize> = names.iter().filter_map(|name| sheet.find(name)).collect();
    let mut edit = Edit::new(format!("Extract {}", count(out.len(), "node")), bypass(sheet, &out));
    let mut cut: Vec<(usize, usize)> = sheet
        .wires
        .iter()
        .filter(|wire| out.contains(&wire.to.0) && !out.contains(&wire.from.0))
        .map(|wire| wire.to)
        .collect();
    // Elements are removed from the end of a list first, so that the indices of the others stay valid.
    cut.sort_by(|a, b| b.cmp(a));
    for to in cut {
        edit = edit.then(disconnected(sheet, to));
    }
    edit
}

/// Connects everything that uses results of these nodes past them.
fn bypass(sheet: &Sheet, nodes: &HashSet<usize>) -> Vec<Op> {
    let mut ops = Vec::new();
    let mut removed = Vec::new();
    for wire in sheet.wires.iter().filter(|wire| nodes.contains(&wire.from.0) && !nodes.contains(&wire.to.0)) {
        let path = Path::node(&sheet.nodes[wire.to.0].name).join(&sheet.nodes[wire.to.0].pins[wire.to.1].steps);
        match stand_for(sheet, wire.from, nodes) {
            Some(source) => ops.push(Op::Set(path, quoted(&source))),
            None => removed.push(wire.to),
        }
    }
    removed.sort_by(|a, b| b.cmp(a));
    for to in removed {
        ops.extend(disconnected(sheet, to).ops);
    }
    for output in &sheet.outputs {
        let Some(from) = sheet.source(&output.source).filter(|from| nodes.contains(&from.0)) else { continue };
        let path = Path::default().to("outputs").to(&output.name);
        let body = sheet.get(&path);
        let key = ["color", "weights", "field", "recipe"]
            .into_iter()
            .find(|key| body.is_some_and(|body| body.get(key).is_some()));
        match (stand_for(sheet, from, nodes), key) {
            (Some(source), Some(key)) => ops.push(Op::Set(path.to(key), quoted(&source))),
            _ => ops.push(Op::Remove(path)),
        }
    }
    ops
}

/// Returns the reference that replaces a removed node's result: its first input of the same kind.
fn stand_for(sheet: &Sheet, mut from: (usize, usize), gone: &HashSet<usize>) -> Option<String> {
    let kind = sheet.nodes[from.0].makes.get(from.1)?.1?;
    for _ in 0..=gone.len() {
        if !gone.contains(&from.0) {
            return Some(sheet.reference(from.0, from.1));
        }
        let mut inputs = sheet.wires.iter().filter(|wire| wire.to.0 == from.0);
        from = inputs.find(|wire| sheet.kind(wire) == Some(kind))?.from;
    }
    None
}

fn sorted(nodes: &HashSet<usize>) -> Vec<usize> {
    let mut nodes: Vec<usize> = nodes.iter().copied().collect();
    nodes.sort_unstable();
    nodes
}

/// Renames a node and all references to it.
pub fn renamed(sheet: &Sheet, from: &str, to: &str) -> Edit {
    let mut ops = Vec::new();
    let Some(node) = sheet.find(from) else { return Edit::new("Rename", ops) };
    let with_new = |text: &str| match text.split_once('.') {
        Some((_, output)) => format!("{to}.{output}"),
        None => to.to_string(),
    };
    for wire in sheet.wires.iter().filter(|wire| wire.from.0 == node) {
        let pin = &sheet.nodes[wire.to.0].pins[wire.to.1];
        let Some(Value::String(text)) = &pin.value else { continue };
        ops.push(Op::Set(Path::node(&sheet.nodes[wire.to.0].name).join(&pin.steps), quoted(&with_new(text))));
    }
    for output in &sheet.outputs {
        let path = Path::default().to("outputs").to(&output.name);
        for key in ["color", "weights", "field", "recipe"] {
            if output.source.split('.').next() == Some(from) && sheet.get(&path.to(key)).is_some() {
                ops.push(Op::Set(path.to(key), quoted(&with_new(&output.source))));
            }
        }
    }
    if sheet.nodes[node].placed {
        ops.push(Op::Rename(placed(from), to.into()));
    }
    ops.extend(decor::redotted(sheet, from, to));
    ops.extend(group::relinked_to(sheet, from, to));
    ops.push(Op::Rename(Path::node(from), to.into()));
    Edit::new(format!("Rename {from} to {to}"), ops)
}

/// Bypasses nodes, or re-enables them if all are bypassed.
pub fn disabled(sheet: &Sheet, names: &[String]) -> Edit {
    switched(sheet, names, !names.iter().filter_map(|name| sheet.node(name)).any(|node| !node.disabled))
}

/// Re-enables nodes, or bypasses them.
pub fn switched(sheet: &Sheet, names: &[String], on: bool) -> Edit {
    let off = !on;
    let nodes = names.iter().filter_map(|name| sheet.node(name));
    let nodes: Vec<&Node> = nodes.filter(|node| node.side.is_none()).collect();
    let ops = nodes.iter().filter(|node| node.disabled != off).map(|node| {
        let path = Path::node(&node.name).to("disabled");
        if off { Op::Set(path, "true".into()) } else { Op::Remove(path) }
    });
    let what = if off { "Disable" } else { "Enable" };
    Edit::new(format!("{what} {}", count(nodes.len(), "node")), ops.collect())
}

/// Inserts a node into a wire, using its first pin that accepts the wire's kind. Returns `None` if there is no such
/// pin, or if no output of the node fits below.
pub fn inserted(sheet: &Sheet, node: usize, wire: &Wire) -> Option<Edit> {
    let kind = sheet.kind(wire)?;
    let into = &sheet.nodes[node];
    let pin = into.pins.iter().position(|pin| pin.accepts.takes(kind))?;
    let below = &sheet.nodes[wire.to.0].pins[wire.to.1];
    let output = into.makes.iter().position(|(_, made)| {
        made.is_some_and(|made| below.accepts.takes(if made == Kind::ANY { kind } else { made }))
    })?;
    let edit = connected(sheet, wire.from, (node, pin)).then(connected(sheet, (node, output), wire.to));
    Some(Edit { label: format!("Insert {}", into.name), ..edit })
}

/// Changes the type of a node and keeps the entries that both types have.
pub fn retyped(sheet: &Sheet, name: &str, declaration: &'static Declaration) -> Edit {
    let mut body = smallest_node(declaration, &|_| None);
    let path = Path::node(name);
    if let (Value::Object(body), Some(Value::Object(old))) = (&mut body, sheet.get(&path)) {
        let known: HashSet<&str> = declaration.items.iter().map(Item::name).collect();
        for (key, value) in old.iter().filter(|(key, _)| *key != "type") {
            if known.contains(key.as_str()) || matches!(key.as_str(), "disabled" | "notes" | "ui") {
                body.insert(key.clone(), value.clone());
            }
        }
    }
    let ops = vec![Op::Set(path, style(&body))];
    Edit::new(format!("Replace {name} with {}", declaration.name), ops)
}

/// Pastes nodes from clipboard text under free names, which are also returned. Returns `None` if the text holds no
/// nodes.
pub fn pasted(sheet: &Sheet, text: &str, at: Point) -> Option<(Edit, Vec<String>)> {
    let clip = clip::read(text)?;
    let mut names: BTreeMap<&str, String> = BTreeMap::new();
    for name in clip.nodes.keys() {
        let free = sheet.free_name_beside(name, |other| names.values().any(|taken| taken == other));
        names.insert(name, free);
    }
    let corner = clip.corner();
    let mut ops = Vec::new();
    for (index, (name, body)) in clip.nodes.iter().enumerate() {
        let mut body = body.clone();
        let items = sheet.library.declaration(&body).map_or(&[][..], |known| known.items);
        clip::redirect(items, &mut body, &|node| match names.get(node) {
            Some(new) => Some(new.clone()),
            None => sheet.find(node).map(|_| node.to_string()),
        });
        link::redirect(&mut body, &|node| names.get(node).cloned());
        ops.push(Op::Set(Path::node(&names[name.as_str()]), style(&body)));
        let place = clip.positions.get(name).copied().unwrap_or([24.0 * index as f32, 90.0 * index as f32]);
        let place = [at[0] + place[0] - corner[0], at[1] + place[1] - corner[1]];
        ops.push(Op::Set(placed(&names[name.as_str()]), style(&position(place))));
    }
    let names: Vec<String> = clip.nodes.keys().map(|name| names[name.as_str()].clone()).collect();
    Some((Edit::new(format!("Paste {}", count(names.len(), "node")), ops), names))
}

/// Returns nodes and their places as clipboard text.
pub fn copied(sheet: &Sheet, names: &[String]) -> String {
    let nodes: HashMap<&str, &Node> =
        names.iter().filter_map(|name| Some((name.as_str(), sheet.node(name)?))).collect();
    let nodes = nodes.into_iter().filter(|(_, node)| node.side.is_none()).collect();
    clip::write(sheet, &nodes)
}

//! Uses of groups, replaced by the nodes of the group.

use super::NoGroup;
use super::body::{Connected, Rewriter};
use super::library::{Group, joined, object};
use super::link;
use crate::document::change::{Edit, style};
use crate::document::color::is_color;
use crate::document::decor;
use crate::document::json::{Op, Path, quoted};
use crate::document::output;
use crate::document::sheet::{Sheet, Side, point};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use trochoid::{Item, KnobType};

/// A use that is being unpacked.
struct Unpacking<'s> {
    sheet: &'s Sheet,
    group: &'s Group,
    name: &'s str,
    /// What the document says of the use.
    given: &'s Value,
    /// New names of the group's nodes.
    names: BTreeMap<&'s str, String>,
    /// Keyed values that stand in formulas become knobs of the scope: their names and values.
    knobs: BTreeMap<String, Value>,
}

/// Puts the nodes of a use in its place, with all values filled in. Returns the edit and the names of the nodes.
///
/// # Errors
/// The node is no use of a group, or something in the group has no form outside of it.
pub fn unpacked(sheet: &Sheet, name: &str) -> Result<(Edit, BTreeSet<String>), NoGroup> {
    let none = || NoGroup::NoUse(name.into());
    let node = sheet.node(name).ok_or_else(none)?;
    let given = sheet.get(&Path::node(name)).ok_or_else(none)?;
    let (_, group) = sheet.library.used(given).ok_or_else(none)?;
    if node.disabled {
        return Err(NoGroup::Disabled(name.into()));
    }
    let mut names: BTreeMap<&str, String> = BTreeMap::new();
    for (own, _) in group.entries("nodes") {
        // The name of the use is free again.
        let is_taken = |new: &str| names.values().any(|taken| taken == new) || new == name && own != name;
        let free = match own == name && !names.values().any(|taken| taken == name) {
            true => own.clone(),
            false => sheet.free_name_beside(own, is_taken),
        };
        names.insert(own, free);
    }
    let mut work = Unpacking { sheet, group, name, given, names, knobs: BTreeMap::new() };
    let nodes = work.nodes()?;
    let mut ops = vec![Op::Remove(Path::node(name))];
    ops.extend(decor::undotted(sheet, name));
    if node.placed {
        ops.push(Op::Remove(positions().to(name)));
    }
    ops.extend(nodes.iter().map(|(name, body)| Op::Set(Path::node(name), style(body))));
    ops.extend(work.places());
    ops.extend(work.outside()?);
    let scope = sheet.within.as_ref().map_or(Path::default(), |within| within.definition()).to("knobs");
    for (knob, value) in &work.knobs {
        let value = if sheet.within.is_some() { value.clone() } else { json!({ "value": value }) };
        ops.insert(0, Op::Set(scope.to(knob), style(&value)));
    }
    let made = nodes.into_iter().map(|(name, _)| name).collect();
    Ok((Edit::new(format!("Unpack {name}"), ops), made))
}

fn positions() -> Path {
    Path::default().to("ui").to("positions")
}

impl<'s> Unpacking<'s> {
    /// Returns the nodes of the group as they are outside of it.
    fn nodes(&mut self) -> Result<Vec<(String, Value)>, NoGroup> {
        let mut nodes = Vec::new();
        let group = self.group;
        for (own, body) in group.entries("nodes") {
            let mut body = body.clone();
            let items = self.sheet.library.declaration(&body).map_or(&[][..], |known| known.items);
            self.relocate(items, &mut body);
            // Both closures need all of it.
            let this = std::cell::RefCell::new(&mut *self);
            let mut reference = |text: &str| this.borrow_mut().connected(text);
            let mut change = |text: &str| this.borrow_mut().value(text);
            Rewriter { reference: &mut reference, link: &mut change }.items(items, &mut body)?;
            nodes.push((self.names[own.as_str()].clone(), body));
        }
        Ok(nodes)
    }

    /// Makes the paths of an included file relative to the document.
    fn relocate(&self, items: &[Item], body: &mut Value) {
        let Some(folder) = self.group.file.as_deref().map(folder_of) else { return };
        relocated(items, body, folder);
    }

    /// Returns what a reference within the group stands for outside of it.
    fn connected(&mut self, text: &str) -> Result<Connected, NoGroup> {
        let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
        let Some(input) = object(&self.group.body, "inputs").and_then(|inputs| inputs.get(name)) else {
            let new = self.names.get(name).map_or(name, String::as_str);
            return Ok(Connected::To(output.map_or(new.into(), |output| format!("{new}.{output}")).into()));
        };
        let value = self.given.get(name).or_else(|| input.get("default"));
        match (value, output) {
            (None, _) => Ok(Connected::Open),
            (Some(value), None) => Ok(Connected::To(value.clone())),
            (Some(Value::String(node)), Some(output)) if !node.contains('.') && !is_color(node) => {
                Ok(Connected::To(format!("{node}.{output}").into()))
            }
            (Some(_), Some(output)) => Err(NoGroup::Output { input: name.into(), output: output.into() }),
        }
    }

    /// Returns what a link within the group is outside of it.
    fn value(&mut self, text: &str) -> Result<Value, NoGroup> {
        match link::sole(text) {
            Some(("knobs", knob)) => self.knob(knob),
            _ => {
                let new = link::replaced(text, |node, knob| match node {
                    "knobs" => self.in_formula(knob).map(Some),
                    node => Ok(self.names.get(node).map(|new| format!("{new}.{knob}"))),
                })?;
                Ok(new.into())
            }
        }
    }

    /// Returns the value of a knob of the group, as it is written outside.
    fn knob(&mut self, knob: &str) -> Result<Value, NoGroup> {
        if let Some(given) = self.given.get(knob) {
            return Ok(given.clone());
        }
        let known = object(&self.group.body, "knobs").and_then(|knobs| knobs.get(knob));
        let Some(default) = known.and_then(|knob| super::face::whole_default(knob).0) else {
            // The document is faulty; the link stays one.
            return Ok(format!("= knobs.{knob}").into());
        };
        let mut default = default.clone();
        if let (Some(file), Value::String(path)) = (&self.group.file, &default)
            && self.is_path(knob)
            && !link::is_link(path)
        {
            default = joined(folder_of(file), path).into();
        }
        let mut reference = |text: &str| Ok(Connected::To(text.into()));
        let mut change = |text: &str| self.value(text);
        Rewriter { reference: &mut reference, link: &mut change }.links(&mut default)?;
        Ok(default)
    }

    /// Returns whether a knob of the group is the name of a file.
    fn is_path(&self, knob: &str) -> bool {
        let face = self.sheet.library.declaration(self.given).map_or(&[][..], |known| known.items);
        face.iter().any(
            |item| matches!(item, Item::Knob(known) if known.name == knob && matches!(known.takes, KnobType::Path)),
        )
    }

    /// Returns the text of a knob's value in a formula.
    fn in_formula(&mut self, knob: &str) -> Result<String, NoGroup> {
        let whole = format!("{}.{knob}", self.name);
        match self.knob(knob)? {
            Value::Number(number) => Ok(format!("({number})")),
            Value::String(text) if link::is_link(&text) => Ok(format!("({})", text.trim_start_matches('=').trim())),
            Value::Array(items) if items.iter().all(Value::is_number) => Ok(style(&Value::Array(items))),
            // Keys, and lists with links, get a name.
            value @ (Value::Object(_) | Value::Array(_)) => {
                let taken = match &self.sheet.within {
                    Some(within) => self.sheet.library.group(within.group()).map(|group| &group.body),
                    None => Some(&self.sheet.value),
                };
                let knobs = taken.and_then(|scope| object(scope, "knobs"));
                let is_taken = |name: &str| {
                    knobs.is_some_and(|knobs| knobs.contains_key(name))
                        || self.knobs.get(name).is_some_and(|known| *known != value)
                };
                let name = super::make::free(&format!("{}_{knob}", self.name), is_taken);
                self.knobs.insert(name.clone(), value);
                Ok(format!("knobs.{name}"))
            }
            _ => Err(NoGroup::Formula(whole)),
        }
    }

    /// Returns the operations that place the nodes around the place of the use.
    fn places(&self) -> Vec<Op> {
        let Some(node) = self.sheet.node(self.name).filter(|node| node.placed) else { return Vec::new() };
        let ui = object(&self.group.body, "ui");
        let kept = ui.and_then(|ui| ui.get("positions"));
        let at = |own: &str| point(kept.and_then(|kept| kept.get(own)));
        let known: Vec<[f32; 2]> = self.names.keys().filter_map(|own| at(own)).collect();
        if known.is_empty() {
            return Vec::new();
        }
        let mean = |axis: usize| known.iter().map(|at| at[axis]).sum::<f32>() / known.len() as f32;
        let shift = [0, 1].map(|axis| node.at[axis] - mean(axis));
        let places = self.names.iter().filter_map(|(own, new)| {
            let at = at(own)?;
            let at = json!([f64::from(at[0] + shift[0]).round(), f64::from(at[1] + shift[1]).round()]);
            Some(Op::Set(positions().to(new), style(&at)))
        });
        places.collect()
    }

    /// Returns the operations that make what refers to the use refer to its nodes.
    fn outside(&mut self) -> Result<Vec<Op>, NoGroup> {
        let (sheet, name) = (self.sheet, self.name);
        let mut ops = Vec::new();
        for node in sheet.nodes.iter().filter(|node| node.name != name) {
            let path = Path::node(&node.name);
            let Some(old) = sheet.get(&path) else { continue };
            let mut new = old.clone();
            if node.side == Some(Side::Input) {
                continue;
            }
            if node.side == Some(Side::Output) {
                // The box of an output is a reference by itself.
                if let Some(text) = old.as_str() {
                    new = self.shown(text)?;
                }
            } else {
                let items = node.declaration.map_or(&[][..], |known| known.items);
                let this = std::cell::RefCell::new(&mut *self);
                let mut reference = |text: &str| this.borrow_mut().made(text);
                let mut change = |text: &str| this.borrow_mut().of_outside(text);
                Rewriter { reference: &mut reference, link: &mut change }.items(items, &mut new)?;
            }
            if new != *old {
                ops.extend(changed(&path, old, &new));
            }
        }
        if sheet.within.is_some() {
            return Ok(ops);
        }
        for (knob, old) in object(&sheet.value, "knobs").into_iter().flatten() {
            let mut new = old.clone();
            let mut reference = |text: &str| Ok(Connected::To(text.into()));
            let mut change = |text: &str| self.of_outside(text);
            Rewriter { reference: &mut reference, link: &mut change }.links(&mut new)?;
            if new != *old {
                ops.push(Op::Set(Path::default().to("knobs").to(knob), style(&new)));
            }
        }
        for shown in &sheet.outputs {
            let path = output::path(&shown.name);
            let key = output::KEYS.into_iter().find(|key| sheet.get(&path.to(*key)).is_some());
            let new = self.shown(&shown.source)?;
            if let (Some(key), Some(new)) = (key, new.as_str().filter(|new| *new != shown.source)) {
                ops.push(Op::Set(path.to(key), quoted(new)));
            }
        }
        Ok(ops)
    }

    /// Returns the reference that takes the place of one to the use, for places that take no literals.
    fn shown(&mut self, text: &str) -> Result<Value, NoGroup> {
        match self.made(text)? {
            Connected::To(value) if value.as_str().is_some_and(|text| !is_color(text)) => Ok(value),
            Connected::To(value) => Err(NoGroup::Literal(style(&value))),
            Connected::Open => Err(NoGroup::Literal("nothing".into())),
        }
    }

    /// Returns what takes the place of a reference outside of the group.
    fn made(&mut self, text: &str) -> Result<Connected, NoGroup> {
        let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
        if name != self.name {
            return Ok(Connected::To(text.into()));
        }
        let outputs = object(&self.group.body, "outputs");
        let target = outputs.and_then(|outputs| match output {
            None => outputs.values().next(),
            Some(output) => outputs.get(output),
        });
        match target.and_then(Value::as_str) {
            Some(target) => self.connected(target),
            None => Ok(Connected::To(text.into())),
        }
    }

    /// Returns what takes the place of a link outside of the group.
    fn of_outside(&mut self, text: &str) -> Result<Value, NoGroup> {
        match link::sole(text) {
            Some((node, knob)) if node == self.name => self.knob(knob),
            _ => {
                let new = link::replaced(text, |node, knob| match node == self.name {
                    true => self.in_formula(knob).map(Some),
                    false => Ok(None),
                })?;
                Ok(new.into())
            }
        }
    }
}

/// Returns the operations that change only those entries of a node that differ.
fn changed(path: &Path, old: &Value, new: &Value) -> Vec<Op> {
    let (Some(before), Some(after)) = (old.as_object(), new.as_object()) else {
        return vec![Op::Set(path.clone(), style(new))];
    };
    let gone = before.keys().filter(|key| !after.contains_key(*key)).map(|key| Op::Remove(path.to(key)));
    let set = after.iter().filter(|(key, value)| before.get(*key) != Some(value));
    gone.chain(set.map(|(key, value)| Op::Set(path.to(key), style(value)))).collect()
}

/// Returns the folder of a file.
fn folder_of(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Makes paths that are relative to a folder relative to the document.
pub(super) fn relocated(items: &[Item], body: &mut Value, folder: &str) {
    for item in items {
        match (item, body.get_mut(item.name())) {
            (Item::Knob(knob), Some(value)) if matches!(knob.takes, KnobType::Path) => {
                if let Some(path) = value.as_str().filter(|path| !path.is_empty() && !link::is_link(path)) {
                    *value = joined(folder, path).into();
                }
            }
            (Item::List(list), Some(Value::Array(records))) => {
                records.iter_mut().for_each(|record| relocated(list.items, record, folder));
            }
            _ => {}
        }
    }
}

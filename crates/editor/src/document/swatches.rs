//! The colors of a document: those that its palette names, and those that are written where they are used.

use super::change::{spoken, style};
use super::color::{hex, is_name, rgb};
use super::curve::Curve;
use super::group::Within;
use super::json::{Path, Step};
use super::sheet::Sheet;
use serde_json::Value;
use std::collections::HashSet;
use trochoid::{Arity, CheckedGraph, Item, Kind, KnobType, WorkingSpace, srgb_decode};

/// What identifies a color of a document.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SwatchKey {
    /// Name in the palette.
    Named(String),
    /// First place of a color without a name.
    Literal(String),
}

/// A color of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Swatch {
    /// Name or value.
    pub key: SwatchKey,
    /// The color at the viewed frame, as sRGB values from 0 to 1; `None` if it is not known.
    pub color: Option<[f32; 3]>,
    /// The color as the document has it; `None` if a file has it.
    pub value: Option<Value>,
    /// Places that use the color. Of a color without a name they are its only places.
    pub uses: Vec<Path>,
    /// Places of the whole document that use a name and are not in the sheet: in groups, and around an entered one.
    pub elsewhere: Vec<Path>,
    /// The included files whose groups use a name, once for each use.
    pub included: Vec<String>,
}

impl Swatch {
    fn new(key: SwatchKey, color: Option<[f32; 3]>, value: Option<Value>) -> Self {
        Self { key, color, value, uses: Vec::new(), elsewhere: Vec::new(), included: Vec::new() }
    }

    /// Returns the number of places that use the color.
    pub fn count(&self) -> usize {
        self.uses.len() + self.elsewhere.len() + self.included.len()
    }

    /// Returns whether the color is keyed over frames.
    pub fn is_keyed(&self) -> bool {
        self.value.as_ref().is_some_and(|value| value.get("keys").is_some())
    }

    /// Returns the names under which a recipe has the color.
    pub fn controls(&self) -> Vec<String> {
        match &self.key {
            SwatchKey::Named(name) => vec![name.clone()],
            SwatchKey::Literal(_) => self.uses.iter().map(spoken).collect(),
        }
    }

    /// Returns the places where the color itself is written.
    pub fn places(&self) -> Vec<Path> {
        match &self.key {
            SwatchKey::Named(name) => vec![entry(name)],
            SwatchKey::Literal(_) => self.uses.clone(),
        }
    }

    /// Returns the names of the nodes that use the color, each once.
    pub fn nodes(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for place in &self.uses {
            if let Some(Step::Key(name)) = place.0.get(1)
                && !names.contains(name)
            {
                names.push(name.clone());
            }
        }
        names
    }

    /// Returns what uses the name beside the sheet, each once: groups, nodes around an entered one, and included files.
    pub fn around(&self) -> Vec<String> {
        let place = |place: &Path| match place.0.as_slice() {
            [Step::Key(top), Step::Key(name), ..] if top == "groups" => format!("the group {name}"),
            [_, Step::Key(name), ..] => name.clone(),
            _ => place.to_string(),
        };
        let mut names: Vec<String> = self.elsewhere.iter().map(place).chain(self.included.iter().cloned()).collect();
        let mut seen = HashSet::new();
        names.retain(|name| seen.insert(name.clone()));
        names
    }

    /// Returns the color as it is called: by its name, or by its value.
    pub fn called(&self) -> String {
        match (&self.key, self.color) {
            (SwatchKey::Named(name), _) => name.clone(),
            (SwatchKey::Literal(_), Some(color)) => hex(color),
            (SwatchKey::Literal(place), None) => place.clone(),
        }
    }
}

/// Returns the path of a name in the palette.
pub fn entry(name: &str) -> Path {
    Path::default().to("palette").to(name)
}

/// Returns the working space of a document.
pub fn space(sheet: &Sheet) -> WorkingSpace {
    let name = sheet.value.get("working_space").and_then(Value::as_str).unwrap_or_default();
    WorkingSpace::from_name(name).unwrap_or_default()
}

/// Returns the file that the palette is read from, if it is not in the document.
pub fn file(sheet: &Sheet) -> Option<&str> {
    sheet.value.get("palette")?.as_str()
}

/// Returns all colors of a document at a frame: the named ones in the order of the palette, then the others in the order
/// of their first use.
pub fn swatches(sheet: &Sheet, graph: Option<&CheckedGraph>, frame: i64) -> Vec<Swatch> {
    let space = space(sheet);
    let mut all: Vec<Swatch> = Vec::new();
    let shown = |value: &Value| shown(value, space, frame as f64);
    match sheet.value.get("palette") {
        Some(Value::Object(entries)) => {
            all.extend(
                entries.iter().map(|(name, value)| {
                    Swatch::new(SwatchKey::Named(name.clone()), shown(value), Some(value.clone()))
                }),
            );
        }
        _ => {
            let colors = graph.map(CheckedGraph::palette).unwrap_or_default();
            all.extend(colors.iter().map(|named| {
                let [r, g, b] = [0, 1, 2].map(|channel| named.color.at(frame as f64)[channel]);
                let color = space.to_display([r, g, b]).map(|channel| channel.clamp(0.0, 1.0) as f32);
                Swatch::new(SwatchKey::Named(named.name.clone()), Some(color), None)
            }));
        }
    }
    // Values of the colors without names, in one form for all ways to write them.
    let mut literals: Vec<(String, usize)> = Vec::new();
    for place in colors(sheet) {
        let Some(value) = sheet.get(&place) else { continue };
        let named = names_in(value, &place);
        for (name, within) in &named {
            let key = SwatchKey::Named(name.clone());
            if let Some(own) = all.iter_mut().find(|own| own.key == key) {
                own.uses.push(within.clone());
            }
        }
        // A keyed color with names in it is no color of its own.
        if !named.is_empty() {
            continue;
        }
        let form = normal(value);
        match literals.iter().find(|(known, _)| *known == form) {
            Some((_, index)) => all[*index].uses.push(place),
            None => {
                literals.push((form, all.len()));
                let key = SwatchKey::Literal(spoken(&place));
                all.push(Swatch { uses: vec![place], ..Swatch::new(key, shown(value), Some(value.clone())) });
            }
        }
    }
    all
}

/// Adds where names are used beside a sheet of the document: in knobs, in groups, and in the document itself if the sheet
/// is that of a group.
pub fn add_elsewhere(all: &mut [Swatch], sheet: &Sheet, root: &Sheet) {
    let mut add = |place: &Path, value: &Value, file: Option<&String>| {
        for (name, place) in names_in(value, place) {
            let key = SwatchKey::Named(name);
            match (all.iter_mut().find(|own| own.key == key), file) {
                (Some(own), Some(file)) => own.included.push(file.clone()),
                (Some(own), None) => own.elsewhere.push(place),
                (None, _) => {}
            }
        }
    };
    let in_node = |at: &Path, body: &Value| -> Vec<(Path, Value)> {
        let Some(declaration) = root.library.declaration(body) else { return Vec::new() };
        let mut found = Vec::new();
        gather(declaration.items, body, &Path::default(), true, &mut found);
        let own = |place: Path| Some((at.clone().join(&place.0), place.find(body)?.clone()));
        found.into_iter().filter_map(own).collect()
    };
    // A knob of a group has a default, and one of the document a value, by itself or beside what describes it.
    let in_knob = |at: &Path, body: &Value| -> (Path, Value) {
        let inner = ["default", "value"].into_iter().find_map(|key| Some((at.to(key), body.get(key)?.clone())));
        inner.unwrap_or_else(|| (at.clone(), body.clone()))
    };
    let knobs = Path::default().to("knobs");
    for (name, body) in knobs.find(&root.value).and_then(Value::as_object).into_iter().flatten() {
        let (place, value) = in_knob(&knobs.to(name.as_str()), body);
        add(&place, &value, None);
    }
    let entered = sheet.within.as_ref().map(Within::group);
    for name in root.library.names() {
        let Some(group) = root.library.group(name) else { continue };
        let (at, file) = (Path::default().to("groups").to(name.as_str()), group.file.as_ref());
        for (knob, body) in group.entries("knobs") {
            let (place, value) = in_knob(&at.to("knobs").to(knob.as_str()), body);
            add(&place, &value, file);
        }
        // The nodes of the sheet are known.
        for (node, body) in group.entries("nodes").filter(|_| entered != Some(name.as_str())) {
            let found = in_node(&at.to("nodes").to(node.as_str()), body);
            found.iter().for_each(|(place, value)| add(place, value, file));
        }
    }
    for node in root.nodes.iter().filter(|_| entered.is_some()) {
        let path = Path::node(&node.name);
        let found = root.get(&path).map_or_else(Vec::new, |body| in_node(&path, body));
        found.iter().for_each(|(place, value)| add(place, value, None));
    }
}

/// Returns the places of all colors that are written in nodes that make colors, names of the palette among them.
fn colors(sheet: &Sheet) -> Vec<Path> {
    let mut found = Vec::new();
    for node in &sheet.nodes {
        let makes_color = node.makes.iter().any(|(_, kind)| matches!(kind, Some(Kind::Color | Kind::Layers(_))));
        let path = Path::node(&node.name);
        if let (true, Some(declaration), Some(body)) = (makes_color, node.declaration, sheet.get(&path)) {
            // What reads files has colors that are parts of images.
            gather(declaration.items, body, &path, declaration.reads.is_none(), &mut found);
        }
    }
    found
}

fn gather(items: &[Item], body: &Value, at: &Path, takes_knobs: bool, found: &mut Vec<Path>) {
    for item in items {
        let (Some(value), place) = (body.get(item.name()), at.to(item.name())) else { continue };
        match item {
            Item::Knob(knob) if takes_knobs && matches!(knob.takes, KnobType::Color) && !is_linked(value) => {
                found.push(place);
            }
            Item::Port(port) if port.accepts.takes_color() => match port.arity {
                Arity::Many { .. } => {
                    let elements = value.as_array().map_or(&[][..], Vec::as_slice).iter().enumerate();
                    let own = elements.filter(|(_, element)| is_written(element));
                    found.extend(own.map(|(index, _)| place.to(index)));
                }
                _ if is_written(value) => found.push(place),
                _ => {}
            },
            Item::List(list) => {
                for (index, record) in value.as_array().map_or(&[][..], Vec::as_slice).iter().enumerate() {
                    gather(list.items, record, &place.to(index), takes_knobs, found);
                }
            }
            _ => {}
        }
    }
}

/// Returns whether a value is taken from another knob.
fn is_linked(value: &Value) -> bool {
    value.as_str().is_some_and(super::link::is_link)
}

/// Returns whether the value of a port is a color, and no node.
fn is_written(value: &Value) -> bool {
    value.as_str().is_none_or(super::color::is_color)
}

/// Returns the names of the palette in a color, by itself or in its keys, with their places.
fn names_in(value: &Value, place: &Path) -> Vec<(String, Path)> {
    let name = |value: &Value, place: Path| {
        let name = value.as_str().filter(|text| is_name(text))?.strip_prefix("palette.")?;
        Some((name.to_string(), place))
    };
    match value.get("keys").and_then(Value::as_array) {
        Some(keys) => {
            let key = |(index, key): (usize, &Value)| name(key.get(1)?, place.to("keys").to(index).to(1));
            keys.iter().enumerate().filter_map(key).collect()
        }
        None => name(value, place.clone()).into_iter().collect(),
    }
}

/// Returns a color in one form for all ways to write it.
fn normal(value: &Value) -> String {
    match value.as_str().and_then(rgb) {
        Some(color) => hex(color),
        None => style(value),
    }
}

/// Returns a color that is written without names, at a frame, as sRGB values from 0 to 1.
pub fn shown(value: &Value, space: WorkingSpace, frame: f64) -> Option<[f32; 3]> {
    let color = working(value, space, frame)?;
    Some(space.to_display(color).map(|channel| channel.clamp(0.0, 1.0) as f32))
}

/// Returns a color that is written without names, at a frame, in the working space.
pub fn working(value: &Value, space: WorkingSpace, frame: f64) -> Option<[f64; 3]> {
    if value.get("keys").is_none() {
        return constant(value, space);
    }
    let animated = Curve::read(value)?.animated_by(|key| Some(constant(&key.value, space)?.to_vec()))?;
    <[f64; 3]>::try_from(animated.at(frame)).ok()
}

fn constant(value: &Value, space: WorkingSpace) -> Option<[f64; 3]> {
    match value {
        Value::String(text) => {
            let encoded = trochoid::parse_hex(text).ok()?;
            Some(space.from_linear_srgb(encoded.map(srgb_decode)).map(|channel| channel.max(0.0)))
        }
        Value::Array(items) => match items.as_slice() {
            [r, g, b] => Some([r.as_f64()?, g.as_f64()?, b.as_f64()?]),
            _ => None,
        },
        _ => None,
    }
}

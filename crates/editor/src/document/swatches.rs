//! The colors of a document: those that its palette names, and those that are written where they are used.

use super::change::{spoken, style};
use super::color::{hex, is_name, rgb};
use super::curve::Curve;
use super::json::{Path, Step};
use super::sheet::Sheet;
use serde_json::Value;
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
}

impl Swatch {
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
            all.extend(entries.iter().map(|(name, value)| Swatch {
                key: SwatchKey::Named(name.clone()),
                color: shown(value),
                value: Some(value.clone()),
                uses: Vec::new(),
            }));
        }
        _ => {
            let colors = graph.map(CheckedGraph::palette).unwrap_or_default();
            all.extend(colors.iter().map(|named| {
                let [r, g, b] = [0, 1, 2].map(|channel| named.color.at(frame as f64)[channel]);
                let color = space.to_display([r, g, b]).map(|channel| channel.clamp(0.0, 1.0) as f32);
                Swatch { key: SwatchKey::Named(named.name.clone()), color: Some(color), value: None, uses: Vec::new() }
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
                all.push(Swatch { key, color: shown(value), value: Some(value.clone()), uses: vec![place] });
            }
        }
    }
    all
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

//! Faces of groups: declarations by which a use of a group is drawn, wired and set like any node.

use super::library::{Group, Library, object};
use super::link;
use crate::document::color::is_color;
use crate::document::sheet::Sheet;
use serde_json::Value;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use trochoid::{
    Accepts, Arity, Declaration, End, Item, Kind, Knob, KnobDefault, KnobType, NodeOutput, Port, input_accepts,
    registry,
};

/// Deepest chain of references that is followed to find the kind of an output.
const DEPTH: usize = 64;

/// What a knob of a group leads to.
struct Lead {
    /// The knob that takes its value as it is; `None` if it is part of a formula or of a list.
    knob: Option<Knob>,
    /// Whether it may be keyed there.
    animated: bool,
}

/// Makes the face of a group, from the faces of the groups that it uses.
pub(super) fn made(library: &Library, name: &str, group: &Group) -> &'static Declaration {
    let mut items = Vec::new();
    for (name, input) in group.entries("inputs") {
        let kind = input.as_str().or_else(|| input.get("kind")?.as_str()).unwrap_or_default();
        let is_open = input.get("default").is_some() || input.get("optional") == Some(&Value::Bool(true));
        items.push(Item::Port(Port {
            name: kept(name),
            help: kept(input.get("help").and_then(Value::as_str).unwrap_or_default()),
            accepts: input_accepts(kind).unwrap_or(Accepts::Image),
            arity: if is_open { Arity::Optional } else { Arity::One },
            wants: &[],
        }));
    }
    for (name, knob) in group.entries("knobs") {
        items.push(Item::Knob(knob_of(library, group, name, knob)));
    }
    let outputs = group.entries("outputs").map(|(name, target)| NodeOutput {
        name: kept(name),
        kind: kind(library, group, target.as_str().unwrap_or_default(), DEPTH).unwrap_or(Kind::ANY),
        others: &[],
        help: "",
        stored: &[],
    });
    let outputs: Vec<NodeOutput> = outputs.collect();
    let is_front = |output: &NodeOutput| !matches!(output.kind, Kind::Color | Kind::Weights(_));
    let count = group.entries("nodes").count();
    let summary = match group.body.get("notes").and_then(Value::as_str) {
        Some(notes) => notes.into(),
        None => format!("A group of {}.", crate::document::edit::count(count, "node")),
    };
    declared(
        Declaration {
            name: kept(name),
            end: if outputs.iter().any(is_front) { End::Front } else { End::Back },
            summary: kept(&summary),
            source: kept(group.file.as_deref().unwrap_or_default()),
            ..BARE
        },
        items,
        outputs,
    )
}

/// A declaration of which nothing is said.
const BARE: Declaration = Declaration {
    name: "",
    end: End::Back,
    summary: "",
    formula: "",
    edge_cases: "",
    source: "",
    items: &[],
    outputs: &[],
    role: None,
    offers: &[],
    reads: None,
    aliases: &[],
    example: "",
    revision: 0,
};

/// Returns a face in which those inputs take lists that have lists in a use.
pub(super) fn with_lists(face: &'static Declaration, body: &Value) -> &'static Declaration {
    let is_list = |item: &Item| match item {
        // A color may be written as a list of numbers.
        Item::Port(port) => {
            let elements = body.get(port.name).and_then(Value::as_array);
            let is_node = |element: &Value| element.as_str().is_some_and(|text| !link::is_link(text));
            elements.is_some_and(|elements| elements.is_empty() || elements.iter().any(is_node))
        }
        _ => false,
    };
    if !face.items.iter().any(is_list) {
        return face;
    }
    let items = face.items.iter().map(|item| match item {
        Item::Port(port) if is_list(item) => Item::Port(Port { arity: Arity::Many { min: 0, max: 64 }, ..*port }),
        item => *item,
    });
    declared(*face, items.collect(), face.outputs.to_vec())
}

/// Returns the declarations of the knobs of a document, which are like what is linked to them.
pub fn document_knobs(sheet: &Sheet) -> Vec<Item> {
    // The document stands for a group of its nodes, and values for defaults.
    let nodes = sheet.value.get("nodes").cloned().unwrap_or_default();
    let document = Group { body: serde_json::json!({ "nodes": nodes }), file: None };
    let knobs = sheet.value.get("knobs").and_then(Value::as_object).into_iter().flatten();
    let knob = |(name, written): (&String, &Value)| {
        let mut described = written.clone();
        if let Some(entries) = described.as_object_mut()
            && let Some(value) = entries.remove("value")
        {
            entries.insert("default".into(), value);
        }
        // Without a default, it has always a value of its own.
        Item::Knob(Knob { default: None, ..knob_of(&sheet.library, &document, name, &described) })
    };
    knobs.map(knob).collect()
}

/// Keeps declarations as long as the program.
pub fn kept_items(items: Vec<Item>) -> &'static [Item] {
    declared(BARE, items, Vec::new()).items
}

fn knob_of(library: &Library, group: &Group, name: &str, written: &Value) -> Knob {
    let is_described = written.is_object() && written.get("keys").is_none();
    let (default, described) =
        if is_described { (written.get("default"), Some(written)) } else { (Some(written), None) };
    let text = |key: &str| described.and_then(|knob| knob.get(key)?.as_str());
    let number = |key: &str| described.and_then(|knob| knob.get(key)?.as_f64());
    let leads = leads(library, group, name);
    let exact = leads.iter().find_map(|lead| lead.knob);
    let (min, max) = (number("min"), number("max"));
    let ends = |low: f64, high: f64| (min.unwrap_or(low).max(low), max.unwrap_or(high).min(high));
    let (low, high) = ends(f64::NEG_INFINITY, f64::INFINITY);
    // A keyed default is of the type of its values.
    let sample = default.map(|value| value.get("keys").and_then(|keys| keys.get(0)?.get(1)).unwrap_or(value));
    let takes = match (exact.map(|knob| knob.takes), sample) {
        (Some(KnobType::Number { min, max }), _) => {
            let (min, max) = ends(min, max);
            KnobType::Number { min, max }
        }
        (Some(KnobType::Integer { min, max }), _) => {
            let (min, max) = ends(min as f64, max as f64);
            KnobType::Integer { min: min as i64, max: max as i64 }
        }
        (Some(takes), _) => takes,
        (None, Some(Value::Bool(_))) => KnobType::Bool,
        (None, Some(Value::String(text))) if is_color(text) => KnobType::Color,
        (None, Some(Value::String(text))) if !link::is_link(text) => KnobType::Text,
        (None, Some(Value::Array(items))) if items.iter().all(Value::is_number) => KnobType::Vector(items.len()),
        _ => KnobType::Number { min: low, max: high },
    };
    let like = exact.unwrap_or(Knob {
        name: "",
        help: "",
        unit: "",
        takes,
        default: None,
        animated: true,
        hold_keys: false,
        accuracy: false,
        affects_cost: false,
        in_pixels: false,
        picture_height: false,
        places: None,
    });
    Knob {
        name: kept(name),
        help: text("help").map_or(like.help, kept),
        unit: text("unit").map_or(like.unit, kept),
        takes,
        default: default.map(known_default),
        animated: leads.iter().all(|lead| lead.animated),
        ..like
    }
}

/// Returns a default as declarations have it. Keyed ones and links are like values that the nodes inside determine.
fn known_default(value: &Value) -> KnobDefault {
    match value {
        Value::Number(number) => KnobDefault::Number(number.as_f64().unwrap_or_default()),
        Value::Bool(value) => KnobDefault::Bool(*value),
        Value::String(text) if !link::is_link(text) => KnobDefault::Text(kept(text)),
        Value::Array(items) => match items.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>() {
            Some(numbers) => KnobDefault::Vector(kept_numbers(numbers)),
            None => KnobDefault::Unset,
        },
        _ => KnobDefault::Unset,
    }
}

/// Returns the whole default of a knob of a group, and the steps to it from the knob.
pub fn whole_default(knob: &Value) -> (Option<&Value>, bool) {
    let is_described = knob.is_object() && knob.get("keys").is_none();
    if is_described { (knob.get("default"), true) } else { (Some(knob), false) }
}

/// Finds what a knob of a group leads to.
fn leads(library: &Library, group: &Group, name: &str) -> Vec<Lead> {
    let mut found = Vec::new();
    for (_, node) in group.entries("nodes") {
        if let Some(declaration) = library.declaration(node) {
            gather(declaration.items, node, name, &mut found);
        }
    }
    found
}

fn gather(items: &'static [Item], body: &Value, name: &str, found: &mut Vec<Lead>) {
    for item in items {
        let Some(value) = body.get(item.name()) else { continue };
        let is_sole =
            value.as_str().is_some_and(|text| link::is_link(text) && link::sole(text) == Some(("knobs", name)));
        match item {
            Item::Knob(knob) if is_sole => found.push(Lead { knob: Some(*knob), animated: knob.animated }),
            Item::Knob(knob) if has(value, name) => found.push(Lead { knob: None, animated: knob.animated }),
            Item::Port(port) if is_sole => found.push(Lead { knob: Some(literal_of(port)), animated: true }),
            Item::Port(_) if has(value, name) => found.push(Lead { knob: None, animated: true }),
            Item::List(list) => {
                let records = value.as_array().map_or(&[][..], Vec::as_slice);
                records.iter().for_each(|record| gather(list.items, record, name, found));
            }
            Item::Knob(_) | Item::Port(_) => {}
        }
    }
}

/// Returns the knob that a literal in a port is like.
fn literal_of(port: &Port) -> Knob {
    let takes = match port.accepts {
        accepts if accepts.takes_color() => KnobType::Color,
        Accepts::Mask => KnobType::Number { min: 0.0, max: 1.0 },
        _ => KnobType::Number { min: f64::NEG_INFINITY, max: f64::INFINITY },
    };
    Knob {
        name: port.name,
        help: port.help,
        unit: "",
        takes,
        default: None,
        animated: true,
        hold_keys: false,
        accuracy: false,
        affects_cost: false,
        in_pixels: false,
        picture_height: false,
        places: None,
    }
}

/// Returns whether a value has a link to a knob of the group.
fn has(value: &Value, name: &str) -> bool {
    let mut has = false;
    link::each(value, &mut |text| {
        has |= link::names(text).iter().any(|(_, node, knob)| (*node, *knob) == ("knobs", name));
    });
    has
}

/// Returns the kind of what an input takes, as far as that is known.
pub(super) fn kind_of_input(accepts: Accepts) -> Kind {
    match accepts {
        Accepts::Color => Kind::Color,
        Accepts::Mask => Kind::MASK,
        Accepts::Weights => Kind::ANY_WEIGHTS,
        Accepts::Scalar | Accepts::Field => Kind::Field(1),
        Accepts::Direction => Kind::Field(2),
        Accepts::Image => Kind::ANY,
        Accepts::Surface => Kind::Surface,
        Accepts::Camera => Kind::Camera,
        Accepts::Light => Kind::Light,
        Accepts::View => Kind::View,
    }
}

/// Returns the kind of a reference within a group, as far as declarations tell.
fn kind(library: &Library, group: &Group, text: &str, depth: usize) -> Option<Kind> {
    let (name, output) = text.split_once('.').map_or((text, None), |(name, output)| (name, Some(output)));
    if let Some(input) = group.body.get("inputs").and_then(|inputs| inputs.get(name)) {
        let kind = input.as_str().or_else(|| input.get("kind")?.as_str())?;
        return if output.is_none() { Some(kind_of_input(input_accepts(kind)?)) } else { None };
    }
    let body = object(&group.body, "nodes")?.get(name)?;
    let declaration = library.declaration(body)?;
    let made = match output {
        None => declaration.outputs.first(),
        Some(output) => declaration.outputs.iter().find(|known| known.name == output),
    };
    let made = made?.kind;
    let first = declaration.items.iter().find_map(|item| match item {
        Item::Port(port) => body.get(port.name),
        _ => None,
    });
    match first {
        Some(Value::String(text)) if made == Kind::ANY && !is_color(text) && depth > 0 => {
            kind(library, group, text, depth - 1)
        }
        _ => Some(made),
    }
}

/// Declarations of all groups of this run, by what they say.
static KNOWN: Mutex<Option<HashMap<String, &'static Declaration>>> = Mutex::new(None);

/// Returns a declaration that lives as long as the program, as those of node types do, on which all widgets rely. Equal
/// ones are made once, so memory grows only when a group's inputs, knobs or outputs change.
fn declared(base: Declaration, items: Vec<Item>, outputs: Vec<NodeOutput>) -> &'static Declaration {
    let key = format!("{:?} {items:?} {outputs:?}", (base.name, base.end, base.summary, base.source));
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.get_or_insert_default().entry(key).or_insert_with(|| {
        let (items, outputs): (&'static [Item], &'static [NodeOutput]) = (items.leak(), outputs.leak());
        Box::leak(Box::new(Declaration { items, outputs, ..base }))
    })
}

/// Texts and lists of numbers of these declarations.
static TEXTS: Mutex<Option<HashMap<String, &'static str>>> = Mutex::new(None);
static NUMBERS: Mutex<Option<HashMap<String, &'static [f64]>>> = Mutex::new(None);

/// Returns a text that lives as long as the program.
pub(super) fn kept(text: &str) -> &'static str {
    if text.is_empty() {
        return "";
    }
    // Names of types are known already.
    if let Some(ty) = registry().get(text) {
        return ty.declaration().name;
    }
    let mut known = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    match known.get(text) {
        Some(kept) => kept,
        None => known.entry(text.into()).or_insert(String::from(text).leak()),
    }
}

fn kept_numbers(numbers: Vec<f64>) -> &'static [f64] {
    let mut known = NUMBERS.lock().unwrap_or_else(PoisonError::into_inner);
    known.get_or_insert_default().entry(format!("{numbers:?}")).or_insert_with(|| numbers.leak())
}

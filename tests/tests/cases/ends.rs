//! Numbers at the ends of their declared ranges, one at a time, in the golden case of every front-end node, with one
//! test per node: each document is refused, or its masks lie from 0 to 1 and nothing is NaN.

use crate::support::{folder, root, settings};
use crate::trial;
use libtest_mimic::Trial;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use trochoid::{Buffers, Cache, End, Item, Kind, KnobType, Plan, Silent, parse, registry};

/// Returns the smallest and largest value of each number of these items, with its key.
fn ends(items: &[Item]) -> Vec<(&'static str, [Value; 2])> {
    let numbers = items.iter().filter_map(|item| match item {
        Item::Knob(knob) => match knob.takes {
            KnobType::Number { min, max } => Some((knob.name, [json!(min), json!(max)])),
            KnobType::Integer { min, max } => Some((knob.name, [json!(min), json!(max)])),
            _ => None,
        },
        _ => None,
    });
    numbers.collect()
}

/// Returns the document with one number changed, each time with a text that says which: for all numbers of the node,
/// and of the first record of each of its lists.
fn variants(document: &Value, node: &str, items: &[Item]) -> Vec<(String, Value)> {
    let mut places: Vec<(String, &str, [Value; 2])> = Vec::new();
    let place = format!("/nodes/{node}");
    places.extend(ends(items).into_iter().map(|(key, ends)| (place.clone(), key, ends)));
    for item in items {
        let Item::List(list) = item else { continue };
        let first = format!("{place}/{}/0", list.name);
        if document.pointer(&first).is_some() {
            places.extend(ends(list.items).into_iter().map(|(key, ends)| (first.clone(), key, ends)));
        }
    }
    let mut variants = Vec::new();
    for (place, key, ends) in places {
        for end in ends {
            let mut changed = document.clone();
            let what = format!("{place}/{key} = {end}");
            changed.pointer_mut(&place).unwrap()[key] = end;
            variants.push((what, changed));
        }
    }
    variants
}

/// Returns whether the document is refused, or what is wrong with its pictures.
fn judge(document: &Value, folder: &Path) -> Result<bool, String> {
    let Ok(loaded) = parse("test.json", &document.to_string(), folder, &[]) else { return Ok(true) };
    let (first, last) = loaded.graph.frames();
    // Small pieces of work, such as steps of small seas, take longer if threads share them.
    let settings = settings(|s| s.threads = 1);
    let Ok(plan) = Plan::new(&loaded.graph, &[], (first + last) / 2, &[], &settings) else { return Ok(true) };
    let Ok(frame) = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent) else { return Ok(true) };
    for picture in &frame.pictures {
        let output = &loaded.graph.outputs()[picture.output].name;
        if picture.audit.nan_count + picture.audit.hull_exits > 0 {
            return Err(format!("{output}: {} NaN, {} outside", picture.audit.nan_count, picture.audit.hull_exits));
        }
        for value in picture.planes.iter().flat_map(|plane| plane.samples()) {
            let legal = match picture.kind {
                Kind::Weights(_) => (0.0..=1.0).contains(value),
                Kind::Color => *value >= 0.0 && value.is_finite(),
                _ => !value.is_nan(),
            };
            if !legal {
                return Err(format!("{output}: {value}"));
            }
        }
    }
    Ok(false)
}

fn holds(name: &str, items: &[Item]) -> Result<(), String> {
    let folder = folder();
    let path = root().join("tests/nodes").join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut document: Value = serde_json::from_str(&text).unwrap();
    let nodes = document["nodes"].as_object().unwrap();
    let is = |node: &Value, ty: &str| node["type"] == ty;
    // A document that reads pictures keeps their size.
    if !nodes.values().any(|node| ["Read", "ViewFromPasses", "CryptoMask"].iter().any(|ty| is(node, ty))) {
        (document["format"]["width"], document["format"]["height"]) = (json!(16), json!(9));
    }
    let nodes = document["nodes"].as_object().unwrap();
    let node = nodes.iter().find(|(_, node)| is(node, name)).unwrap().0.clone();
    let (mut faults, mut refused, mut seen) = (Vec::new(), 0, 0);
    for (what, document) in variants(&document, &node, items) {
        match catch_unwind(AssertUnwindSafe(|| judge(&document, folder.path()))) {
            Ok(Ok(true)) => refused += 1,
            Ok(Ok(false)) => seen += 1,
            Ok(Err(fault)) => faults.push(format!("{what}: {fault}")),
            Err(_) => faults.push(format!("{what}: panicked")),
        }
    }
    if seen == 0 && refused > 0 {
        faults.push(format!("all {refused} documents are refused, so none of the numbers is evaluated"));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n")) }
}

pub(crate) fn trials() -> Vec<Trial> {
    let front = registry().iter().map(|ty| ty.declaration()).filter(|declaration| declaration.end == End::Front);
    front.map(|declaration| trial("ends", declaration.name, || holds(declaration.name, declaration.items))).collect()
}

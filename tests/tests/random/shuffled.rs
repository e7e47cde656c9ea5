//! A document with its nodes renamed and in another order.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use serde_json::{Map, Value};
use std::collections::HashMap;

/// New names of nodes by their old ones.
pub(crate) type Names = HashMap<String, String>;

/// Renames and shuffles the nodes of a document. No text but a connection may be a node's name.
pub(crate) fn shuffled(text: &str, random: &mut impl Rng) -> (String, Names) {
    let mut document: Value = serde_json::from_str(text).unwrap();
    let nodes = document["nodes"].as_object().unwrap();
    let mut names = Names::new();
    for (index, name) in nodes.keys().enumerate() {
        let first = char::from(random.random_range(b'a'..=b'z'));
        // As the old names sort, or the other way, or neither.
        names.insert(name.clone(), format!("{first}{}_{index}", random.random_range(0..1000)));
    }
    let mut entries: Vec<(String, Value)> =
        nodes.iter().map(|(name, node)| (names[name].clone(), renamed(node, &names))).collect();
    entries.shuffle(random);
    document["nodes"] = Value::Object(entries.into_iter().collect());
    let outputs = renamed(&document["outputs"], &names);
    let mut entries: Vec<(String, Value)> = outputs.as_object().unwrap().clone().into_iter().collect();
    entries.shuffle(random);
    document["outputs"] = Value::Object(entries.into_iter().collect::<Map<_, _>>());
    (document.to_string(), names)
}

/// Renames every connection within a value.
fn renamed(value: &Value, names: &Names) -> Value {
    match value {
        Value::String(text) => match text.split_once('.') {
            Some((node, output)) if names.contains_key(node) => Value::String(format!("{}.{output}", names[node])),
            _ => Value::String(names.get(text).unwrap_or(text).clone()),
        },
        Value::Array(items) => Value::Array(items.iter().map(|item| renamed(item, names)).collect()),
        Value::Object(entries) => {
            Value::Object(entries.iter().map(|(key, value)| (key.clone(), renamed(value, names))).collect())
        }
        _ => value.clone(),
    }
}

/// Replaces old names, where they stand between quotes, by the new ones.
pub(crate) fn told_anew(told: &str, names: &Names) -> String {
    let pieces = told.split('"').map(|piece| names.get(piece).map_or(piece, String::as_str));
    pieces.collect::<Vec<_>>().join("\"")
}

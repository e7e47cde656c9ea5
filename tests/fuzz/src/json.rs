//! Structural mutations of JSON documents, since mutations of bytes would nearly always break the JSON.

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value, json};

/// Numbers at the ends of the ranges of knobs, and beyond.
const NUMBERS: &[f64] = &[
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    3.0,
    1e-300,
    1e-9,
    1e9,
    1e300,
    -1e300,
    0.999_999_999,
    255.0,
    4096.0,
    65_536.0,
    2_147_483_648.0,
    9_007_199_254_740_993.0,
    -5.0,
    90.0,
    360.0,
];
const WORDS: &[&str] = &[
    "", "#fff", "#000", "view", "sea", "camera", "color", "weights", "field", "x", "a.b", "a.weight", "../x", "####",
    "%04d",
];

/// Mutates a JSON text of `size` bytes within `data`, or its bytes if it is not JSON. Returns the new size, at most
/// `max`.
pub fn mutate_json(data: &mut [u8], size: usize, max: usize, seed: u32) -> usize {
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(seed));
    let parsed = serde_json::from_slice::<Value>(&data[..size]);
    let Ok(mut value) =
        parsed.map_err(drop).and_then(|value| if random.random_bool(0.05) { Err(()) } else { Ok(value) })
    else {
        return libfuzzer_sys::fuzzer_mutate(data, size, max);
    };
    for _ in 0..random.random_range(1..4) {
        let places = count(&value);
        let mut at = random.random_range(0..places);
        let donor = pick(&value, &mut random);
        change(&mut value, &mut at, donor, &mut random);
    }
    let text = value.to_string();
    if text.len() > max {
        return libfuzzer_sys::fuzzer_mutate(data, size, max);
    }
    data[..text.len()].copy_from_slice(text.as_bytes());
    text.len()
}

fn children(value: &Value) -> Vec<&Value> {
    match value {
        Value::Array(list) => list.iter().collect(),
        Value::Object(map) => map.values().collect(),
        _ => Vec::new(),
    }
}

fn count(value: &Value) -> usize {
    1 + children(value).into_iter().map(count).sum::<usize>()
}

/// Returns a random value of the document, to be put elsewhere.
fn pick(value: &Value, random: &mut Pcg64Mcg) -> Value {
    let mut at = random.random_range(0..count(value));
    fn find<'v>(value: &'v Value, at: &mut usize) -> Option<&'v Value> {
        if *at == 0 {
            return Some(value);
        }
        *at -= 1;
        children(value).into_iter().find_map(|child| find(child, at))
    }
    find(value, &mut at).filter(|value| count(value) < 200).cloned().unwrap_or(Value::Null)
}

/// Changes the value at this place in the order of the text; returns whether there is one.
fn change(value: &mut Value, at: &mut usize, donor: Value, random: &mut Pcg64Mcg) -> bool {
    if *at == 0 {
        become_another(value, donor, random);
        return true;
    }
    *at -= 1;
    match value {
        Value::Array(list) => list.iter_mut().any(|child| change(child, at, donor.clone(), random)),
        Value::Object(map) => map.values_mut().any(|child| change(child, at, donor.clone(), random)),
        _ => false,
    }
}

fn become_another(value: &mut Value, donor: Value, random: &mut Pcg64Mcg) {
    match (random.random_range(0..8), &mut *value) {
        (0, _) => *value = donor,
        (1..=5, Value::Number(number)) => {
            let number = number.as_f64().unwrap_or_default();
            *value = match random.random_range(0..4) {
                0 => json!(NUMBERS.choose(random)),
                1 => json!(number * random.random_range(-2.0..4.0)),
                2 => json!((number.round() as i64).saturating_add(random.random_range(-2..3))),
                _ => json!(-number),
            };
        }
        (1..=4, Value::String(text)) => {
            *value = match random.random_range(0..3) {
                0 => json!(WORDS.choose(random)),
                1 => json!(format!("{text}{text}")),
                _ => json!(format!("#{:06x}", random.random_range(0..1 << 24))),
            };
        }
        (1..=5, Value::Array(list)) if !list.is_empty() => {
            let index = random.random_range(0..list.len());
            match random.random_range(0..3) {
                0 => drop(list.remove(index)),
                1 => list.insert(index, donor),
                _ => list.push(list[index].clone()),
            }
        }
        (1..=5, Value::Object(map)) if !map.is_empty() => alter(map, donor, random),
        (6, _) => *value = json!({ "keys": [[1, value.clone()], [random.random_range(-3..50), donor]] }),
        _ => *value = json!(NUMBERS.choose(random)),
    }
}

/// Removes, replaces, renames or swaps an entry.
fn alter(map: &mut Map<String, Value>, donor: Value, random: &mut Pcg64Mcg) {
    let keys: Vec<String> = map.keys().cloned().collect();
    let (Some(one), Some(other)) = (keys.choose(random), keys.choose(random)) else { return };
    match random.random_range(0..4) {
        0 => drop(map.remove(one)),
        1 => drop(map.insert(one.clone(), donor)),
        2 => {
            if let Some(moved) = map.remove(one) {
                map.insert(format!("{one}{}", random.random_range(0..3)), moved);
            }
        }
        _ => {
            if let (Some(a), Some(b)) = (map.get(one).cloned(), map.get(other).cloned()) {
                map.insert(one.clone(), b);
                map.insert(other.clone(), a);
            }
        }
    }
}

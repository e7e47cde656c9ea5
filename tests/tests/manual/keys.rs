//! Keyed numbers and lists of numbers: "Keys" of the definitions.

use serde_json::Value as Json;

/// Replaces everything that is keyed in a value by what it is at a frame.
pub(super) fn at_frame(value: &Json, frame: i64) -> Json {
    match value {
        Json::Object(items) if items.contains_key("keys") => keyed(value, frame as f64),
        Json::Object(items) => items.iter().map(|(key, item)| (key.clone(), at_frame(item, frame))).collect(),
        Json::Array(items) => items.iter().map(|item| at_frame(item, frame)).collect(),
        other => other.clone(),
    }
}

fn keyed(value: &Json, frame: f64) -> Json {
    let keys: Vec<(f64, &Json)> =
        value["keys"].as_array().unwrap().iter().map(|key| (key[0].as_f64().unwrap(), &key[1])).collect();
    let interpolation = value["interpolation"].as_str().unwrap_or("linear");
    let one = |component: &dyn Fn(&Json) -> f64| {
        let keys: Vec<[f64; 2]> = keys.iter().map(|(frame, value)| [*frame, component(value)]).collect();
        curve(&keys, interpolation, frame)
    };
    match keys[0].1.as_array() {
        Some(list) => (0..list.len()).map(|index| one(&|value| value[index].as_f64().unwrap())).collect(),
        None => one(&|value| value.as_f64().unwrap()).into(),
    }
}

/// Returns the value of a curve through frames and values.
fn curve(keys: &[[f64; 2]], interpolation: &str, frame: f64) -> f64 {
    let Some(last) = keys.iter().rposition(|key| key[0] <= frame) else { return keys[0][1] };
    if last + 1 == keys.len() || interpolation == "hold" {
        return keys[last][1];
    }
    let ([start, from], [end, to]) = (keys[last], keys[last + 1]);
    let (t, width) = ((frame - start) / (end - start), end - start);
    if interpolation == "linear" {
        return from + t * (to - from);
    }
    let slope = |key: usize| {
        if key == 0 || key + 1 == keys.len() {
            return 0.0;
        }
        let rise = |a: usize, b: usize| (keys[b][1] - keys[a][1]) / (keys[b][0] - keys[a][0]);
        let (before, after) = (rise(key - 1, key), rise(key, key + 1));
        if before * after > 0.0 { 2.0 * before * after / (before + after) } else { 0.0 }
    };
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * from
        + (t3 - 2.0 * t2 + t) * width * slope(last)
        + (3.0 * t2 - 2.0 * t3) * to
        + (t3 - t2) * width * slope(last + 1)
}

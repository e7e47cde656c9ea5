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
    let keys = value["keys"].as_array().unwrap();
    let interpolation = value["interpolation"].as_str().unwrap_or("linear");
    let one = |component: &dyn Fn(&Json) -> f64| {
        let points: Vec<[f64; 2]> = keys.iter().map(|key| [key[0].as_f64().unwrap(), component(&key[1])]).collect();
        let last = points.iter().rposition(|point| point[0] <= frame);
        let own = last.and_then(|last| keys[last][2]["interpolation"].as_str()).unwrap_or(interpolation);
        let handle = |key: usize, side: &str| {
            let handle = keys.get(key)?[2].get(side)?;
            Some([handle[0].as_f64().unwrap(), component(&handle[1])])
        };
        let handles = last.map_or([None, None], |last| [handle(last, "out"), handle(last + 1, "in")]);
        match last.filter(|last| last + 1 < keys.len()) {
            Some(last) if own != "hold" && handles != [None, None] => bezier(&points, last, own, handles, frame),
            _ => curve(&points, own, frame),
        }
    };
    match keys[0][1].as_array() {
        Some(list) => (0..list.len()).map(|index| one(&|value| value[index].as_f64().unwrap())).collect(),
        None => one(&|value| value.as_f64().unwrap()).into(),
    }
}

/// Returns the value of a curve with handles after a key.
fn bezier(keys: &[[f64; 2]], last: usize, interpolation: &str, handles: [Option<[f64; 2]>; 2], frame: f64) -> f64 {
    let ([start, from], [end, to]) = (keys[last], keys[last + 1]);
    let width = end - start;
    let mut points = [[0.0, from], [0.0, 0.0], [0.0, 0.0], [width, to]];
    for (side, handle) in handles.into_iter().enumerate() {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let [frames, change] = handle.unwrap_or_else(|| {
            let slope = if interpolation == "monotone" { slope(keys, last + side) } else { (to - from) / width };
            [sign * width / 3.0, sign * slope * width / 3.0]
        });
        let share = if frames.abs() > width { width / frames.abs() } else { 1.0 };
        let [at, value] = points[3 * side];
        points[1 + side] = [at + share * frames, value + share * change];
    }
    let along = |u: f64, axis: usize| {
        let s = 1.0 - u;
        let weights = [s * s * s, 3.0 * s * s * u, 3.0 * s * u * u, u * u * u];
        weights.iter().zip(points).map(|(weight, point)| weight * point[axis]).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        (low, high) = if along(middle, 0) < frame - start { (middle, high) } else { (low, middle) };
    }
    along(0.5 * (low + high), 1)
}

/// Returns the slope at a key.
fn slope(keys: &[[f64; 2]], key: usize) -> f64 {
    if key == 0 || key + 1 == keys.len() {
        return 0.0;
    }
    let rise = |a: usize, b: usize| (keys[b][1] - keys[a][1]) / (keys[b][0] - keys[a][0]);
    let (before, after) = (rise(key - 1, key), rise(key, key + 1));
    if before * after > 0.0 { 2.0 * before * after / (before + after) } else { 0.0 }
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
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * from
        + (t3 - 2.0 * t2 + t) * width * slope(keys, last)
        + (3.0 * t2 - 2.0 * t3) * to
        + (t3 - t2) * width * slope(keys, last + 1)
}

//! Finds the place in a node where a control color is written.

use crate::document::color::rgb;
use crate::document::{Path, Sheet, edit};
use serde_json::Value;
use trochoid::{Item, KnobType, WorkingSpace, srgb_decode};

/// Tolerance for equal colors: rounding errors only.
const SAME: f64 = 1e-6;

/// Returns the readable name of the knob, port, or record that holds a control color; `None` if none or several match.
pub(super) fn origin(sheet: &Sheet, node: &str, color: [f64; 3], space: WorkingSpace) -> Option<String> {
    let body = sheet.get(&Path::node(node))?;
    let mut all = Vec::new();
    gather(sheet.node(node)?.declaration?.items, body, "", space, &mut all);
    let is_it = |own: &[f64; 3]| own.iter().zip(color).all(|(own, value)| (own - value).abs() < SAME);
    let mut found = all.into_iter().filter(|(_, own)| is_it(own));
    let (name, _) = found.next()?;
    found.next().is_none().then_some(name)
}

/// Collects the colors written in items, with their names.
fn gather(items: &[Item], body: &Value, before: &str, space: WorkingSpace, all: &mut Vec<(String, [f64; 3])>) {
    let counts = |item: &&Item| match item {
        Item::Knob(knob) => matches!(knob.takes, KnobType::Color),
        Item::Port(port) => port.accepts.takes_color(),
        Item::List(_) => true,
    };
    let colored: Vec<&Item> = items.iter().filter(counts).collect();
    for item in &colored {
        let name = item.name().replace('_', " ");
        // A record's only color is named after the record.
        let own = match before {
            "" => name.clone(),
            _ if colored.len() == 1 => before.into(),
            _ => format!("{before}.{name}"),
        };
        let value = body.get(item.name());
        match (item, value) {
            (Item::List(list), Some(Value::Array(records))) => {
                for (index, record) in records.iter().enumerate() {
                    gather(list.items, record, &format!("{name}[{index}]"), space, all);
                }
            }
            (Item::Knob(knob), None) => {
                all.extend(literal(&edit::default_value(knob), space).map(|color| (own, color)));
            }
            (Item::Port(_) | Item::Knob(_), Some(value)) => match literal(value, space) {
                Some(color) => all.push((own, color)),
                None => {
                    let elements = value.as_array().map_or(&[][..], Vec::as_slice).iter().enumerate();
                    let named = |(index, element): (usize, &Value)| {
                        Some((format!("{name}[{index}]"), literal(element, space)?))
                    };
                    all.extend(elements.filter_map(named));
                }
            },
            _ => {}
        }
    }
}

/// Returns a literal color in the working space; `None` for any other value.
fn literal(value: &Value, space: WorkingSpace) -> Option<[f64; 3]> {
    match value {
        Value::String(text) => {
            let encoded = rgb(text)?.map(|value| (f64::from(value) * 255.0).round() / 255.0);
            Some(space.from_linear_srgb(encoded.map(srgb_decode)))
        }
        Value::Array(items) => match items.as_slice() {
            [r, g, b] => Some([r.as_f64()?, g.as_f64()?, b.as_f64()?]),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;

    #[test]
    fn a_control_color_is_known_by_what_holds_it() {
        let text = r##"{
          "trochoid": 1,
          "nodes": {
            "across": { "type": "ScreenX" },
            "mix": { "type": "Mix", "a": "#102030", "b": [0.25, 0.5, 1.5], "weight": "across" },
            "same": { "type": "Mix", "a": "#102030", "b": "#102030", "weight": "across" },
            "glow": { "type": "Ramp", "weight": "across", "stops": [
              { "at": 0, "color": "#000000" }, { "at": 0.5, "color": "#ff8000" }, { "at": 1, "color": "mix" }
            ] },
            "sheet": { "type": "Patch", "u": "across", "v": "across",
              "colors": ["#000000", "#ff8000", "#00ff00", "#0000ff"] }
          }
        }"##;
        let session = Session::new(text.into(), None);
        let of = |node: &str, color: [f64; 3]| origin(session.sheet(), node, color, WorkingSpace::LinearSrgb);
        let orange = [1.0, srgb_decode(128.0 / 255.0), 0.0];
        let dark = [16.0, 32.0, 48.0].map(|value: f64| srgb_decode(value / 255.0));
        assert_eq!(of("mix", dark).as_deref(), Some("a"));
        assert_eq!(of("mix", [0.25, 0.5, 1.5]).as_deref(), Some("b"));
        assert_eq!(of("glow", orange).as_deref(), Some("stops[1]"));
        assert_eq!(of("sheet", orange).as_deref(), Some("colors[1]"));
        assert_eq!(of("same", dark), None, "both controls match");
        assert_eq!(of("mix", orange), None, "no control matches");
    }
}

//! Declarations in words, shared by all manuals.

use crate::{Accepts, Arity, Declaration, Item, Knob, KnobDefault, KnobType, Output, Port, expected};
use serde_json::{Map, Value, json};

/// Returns a range of counts in words: "2", "1 to 4", "1 or more".
pub fn counted(min: usize, max: usize) -> String {
    match (min, max) {
        (min, max) if min == max => min.to_string(),
        (min, max) if max > 4096 => format!("{min} or more"),
        (min, max) => format!("{min} to {max}"),
    }
}

impl Port {
    /// Describes the accepted values in words, and whether the port is optional.
    pub fn takes(&self) -> String {
        let literal = match self.accepts {
            Accepts::Color => ", or a literal color",
            Accepts::Image => ", or a literal color or mask",
            Accepts::Mask => ", or a literal number from 0 to 1",
            Accepts::Scalar | Accepts::Field => ", or a literal number",
            Accepts::Weights => ", or literal numbers that sum to 1",
            _ => "",
        };
        let accepts = self.accepts;
        let open = if self.is_required() { "" } else { "; optional" };
        match self.arity {
            Arity::One | Arity::Optional => format!("{accepts}{literal}{open}"),
            Arity::Many { min, max } => format!("a list of {} × {accepts}{literal}{open}", counted(min, max)),
        }
    }

    /// Returns whether the port must be connected.
    pub fn is_required(&self) -> bool {
        !matches!(self.arity, Arity::Optional | Arity::Many { min: 0, .. })
    }
}

impl Knob {
    /// Describes the accepted values in words, with the unit.
    pub fn takes_in_words(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(", in {}", self.unit) };
        format!("{}{unit}", expected(&self.takes))
    }

    /// Returns the default as a person would write it; null if the knob is required or unset by default.
    pub fn default_value(&self) -> Value {
        match self.default {
            Some(KnobDefault::Number(number)) if number.fract() == 0.0 && number.abs() < 1e15 => json!(number as i64),
            Some(KnobDefault::Number(number)) => json!(number),
            Some(KnobDefault::Bool(value)) => json!(value),
            Some(KnobDefault::Text(text)) => json!(text),
            Some(KnobDefault::Vector(values)) => json!(values),
            Some(KnobDefault::Unset) | None => Value::Null,
        }
    }
}

impl Output {
    /// Returns the kinds that it can have, in words: "Color, mask or Field".
    pub fn kinds_in_words(&self) -> String {
        let mut kinds: Vec<String> = [&[self.kind], self.others].concat().iter().map(ToString::to_string).collect();
        match (kinds.pop(), kinds.is_empty()) {
            (Some(last), false) => format!("{} or {last}", kinds.join(", ")),
            (last, _) => last.unwrap_or_default(),
        }
    }
}

/// Returns a node of a type as documents have it: only what is required, with values that stand in for the user's. Ports
/// that take no literals get what `connection` returns for them.
pub fn smallest_node(declaration: &Declaration, connection: &dyn Fn(Accepts) -> Option<Value>) -> Value {
    let mut body = Map::from_iter([("type".to_string(), json!(declaration.name))]);
    fill(declaration.items, connection, &mut body);
    Value::Object(body)
}

/// Adds a value for every required item.
fn fill(items: &[Item], connection: &dyn Fn(Accepts) -> Option<Value>, body: &mut Map<String, Value>) {
    for item in items {
        match item {
            Item::Port(port) => {
                let accepts = port.accepts;
                let literal = match accepts {
                    _ if accepts.takes_color() => Some(json!("#808080")),
                    Accepts::Mask => Some(json!(0.5)),
                    _ if accepts.takes_number() => Some(json!(0)),
                    _ => connection(accepts),
                };
                let value = match (port.arity, literal) {
                    (Arity::One, literal) => literal,
                    (Arity::Many { min: 1.., .. }, None) | (Arity::Optional | Arity::Many { min: 0, .. }, _) => None,
                    (Arity::Many { min, .. }, Some(literal)) => Some(json!(vec![literal; min])),
                };
                body.extend(value.map(|value| (port.name.to_string(), value)));
            }
            Item::Knob(knob) if knob.default.is_none() => {
                body.insert(knob.name.into(), stand_in(&knob.takes));
            }
            Item::Knob(_) => {}
            Item::List(list) if list.min > 0 => {
                let records = (0..list.min).map(|index| smallest_record(list.items, index, connection));
                body.insert(list.name.into(), records.collect());
            }
            Item::List(_) => {}
        }
    }
}

/// Returns a record of a list with a value for every required item.
pub fn smallest_record(items: &[Item], index: usize, connection: &dyn Fn(Accepts) -> Option<Value>) -> Value {
    let mut body = Map::new();
    fill(items, connection, &mut body);
    // Stops of a ramp ascend, as far as their range allows.
    for item in items {
        if let Item::Knob(Knob { name: "at", takes: KnobType::Number { min, max }, .. }) = item {
            body.insert("at".into(), json!((index as f64).clamp(*min, *max)));
        }
    }
    Value::Object(body)
}

/// Returns a valid value for a knob without a default.
pub fn stand_in(takes: &KnobType) -> Value {
    match takes {
        KnobType::Number { min, max } => json!(0.0_f64.clamp(*min, *max)),
        KnobType::Integer { min, max } => json!(0_i64.clamp(*min, *max)),
        KnobType::Bool => json!(false),
        KnobType::Choice(words) => json!(words.first()),
        KnobType::Color => json!("#808080"),
        KnobType::Vector(n) => json!(vec![0; *n]),
        KnobType::Text | KnobType::Path => json!(""),
        KnobType::Numbers { min, .. } => json!(vec![0; *min]),
        KnobType::Texts { .. } => json!([]),
    }
}

//! Declarations in words, shared by all manuals.

use crate::{Accepts, Arity, Knob, KnobDefault, Port, expected};
use serde_json::{Value, json};

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

//! Reads values: numbers, lists, colors, literal weights, and values keyed over frames.

use super::palette::is_name;
use super::{Checker, FaultLocation};
use crate::declare::KnobType;
use crate::literal::{LITERAL_SUM_TOLERANCE, parts};
use crate::spanned::{Json, Spanned, number_text};
use crate::{Severity, Source};
use trochoid_image::{WorkingSpace, parse_hex, srgb_decode};

impl<'a> Checker<'a> {
    /// Reads numbers as weights, which must be ≥ 0 with sum 1 up to the rounding of decimal fractions, and divides them
    /// by their sum.
    pub(super) fn literal_weights(&mut self, items: &'a [Spanned], place: FaultLocation<'_>) -> Option<Source> {
        let mut numbers = Vec::with_capacity(items.len());
        for item in items {
            if let Json::String(_) = item.json {
                let remedy = "write numbers; or instead of the list the name of one node that makes all weights";
                self.error(place.at(item.offset), item.brief(), "a finite number", remedy);
                return None;
            }
            numbers.push(self.number(item, f64::MIN, f64::MAX, place.at(item.offset))?);
        }
        let sum: f64 = numbers.iter().sum();
        let lowest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest < 0.0 {
            let found = format!("the weight {}", number_text(lowest));
            let remedy = "a negative weight pushes the color out of the palette on the far side: use 0, or another control color";
            self.error(place, found, "weights ≥ 0 that sum to 1", remedy);
            return None;
        }
        if (sum - 1.0).abs() > LITERAL_SUM_TOLERANCE {
            let scaled: Vec<String> = numbers.iter().map(|w| format!("{:.4}", w / sum)).collect();
            let found = format!("weights that sum to {sum}: equal colors of 0.6 would give {}", 0.6 * sum);
            let remedy = if sum > 0.0 {
                format!("divide by the sum: [{}]", scaled.join(", "))
            } else {
                "one weight must be above 0".into()
            };
            self.error(place, found, "weights ≥ 0 that sum to 1", remedy);
            return None;
        }
        parts(&numbers).map(Source::Numbers)
    }

    pub(super) fn number(&mut self, value: &Spanned, min: f64, max: f64, place: FaultLocation<'_>) -> Option<f64> {
        match value.json {
            // Adding 0 turns −0 into 0, so that pruning changes no bit of a picture.
            Json::Number(n) if (min..=max).contains(&n) => Some(n + 0.0),
            Json::Number(n) if !n.is_finite() => {
                self.error(place, value.brief(), "a finite number", "write a smaller number");
                None
            }
            Json::Number(n) => {
                let limit = n.clamp(min, max);
                let takes = KnobType::Number { min, max };
                let (expected, remedy) = match limit.abs() >= WIDE {
                    // The limit is that of f32 rather than of the knob; its two digits, 3.4e38, are within it.
                    true => (
                        "a number that f32 can hold".into(),
                        format!("write at {} {limit:.1e}", if n > max { "most" } else { "least" }),
                    ),
                    false => (expected(&takes), format!("the nearest legal value is {}", number_text(limit))),
                };
                self.error(place, number_text(n), expected, remedy);
                None
            }
            _ => {
                self.error(place, value.brief(), expected(&KnobType::Number { min, max }), "write a number");
                None
            }
        }
    }

    pub(super) fn vector(
        &mut self,
        value: &Spanned,
        min: usize,
        max: usize,
        place: FaultLocation<'_>,
    ) -> Option<Vec<f64>> {
        match &value.json {
            Json::Array(items) if (min..=max).contains(&items.len()) => {
                // Kernels work in f32, so its largest value is the limit.
                let limit = f64::from(f32::MAX);
                items.iter().map(|item| self.number(item, -limit, limit, place.at(item.offset))).collect()
            }
            _ => {
                let expected = format!("a list of {}", count(min, max, "number"));
                self.error(place, value.brief(), expected, "write the numbers in brackets: [ … ]");
                None
            }
        }
    }

    /// Reads a color, `"#rrggbb"` in sRGB or `[r, g, b]` in the working space, and returns it in the working space.
    pub(super) fn color(&mut self, value: &Spanned, place: FaultLocation<'_>) -> Option<Vec<f64>> {
        match &value.json {
            Json::String(text) if is_name(text) => {
                let named = self.named(text, place, false)?;
                if named.frames().next().is_some() {
                    let found = format!("{}, which is keyed itself, as the value of a key", value.brief());
                    let remedy = "write the name without keys, or a color that is not keyed";
                    self.error(place, found, "a color that is constant", remedy);
                    return None;
                }
                Some(named.at(0.0))
            }
            Json::String(text) => match parse_hex(text) {
                Ok(color) => Some(self.space.from_linear_srgb(color.map(srgb_decode)).map(|v| v.max(0.0)).to_vec()),
                Err(_) => {
                    let remedy = match self.meant(text) {
                        Some(named) => format!("did you mean \"{named}\"?"),
                        None => "write #rrggbb or #rgb with hexadecimal digits; it is read as sRGB".into(),
                    };
                    self.error(place, value.brief(), "a color", remedy);
                    None
                }
            },
            Json::Array(items) if items.len() == 3 && !items.iter().any(is_color_or_list) => {
                let color: Option<Vec<f64>> = items
                    .iter()
                    .map(|item| self.number(item, 0.0, f64::from(f32::MAX), place.at(item.offset)))
                    .collect();
                let most = color.iter().flatten().copied().fold(0.0, f64::max);
                if most > brightest(self.space) {
                    let found = format!("the color {}", value_text(items));
                    let remedy = if most > 16.0 {
                        format!("divide by {}, or write \"#rrggbb\"", if most > 255.0 { most } else { 255.0 })
                    } else {
                        "lower it, or choose a linear working space, in which light may be brighter than white".into()
                    };
                    let expected = "channels from 0 to 1, where 1 is white".into();
                    self.report(Severity::Warning, place.at(value.offset), found, expected, remedy);
                }
                color
            }
            Json::Array(items) if items.iter().any(is_color_or_list) => {
                let remedy = "list the colors one after another, without brackets around some of them";
                self.error(place, value.brief(), expected(&KnobType::Color), remedy);
                None
            }
            _ => {
                self.error(place, value.brief(), expected(&KnobType::Color), "write a color");
                None
            }
        }
    }
}

/// Whether an item is a color or a list rather than a channel of a color.
fn is_color_or_list(item: &Spanned) -> bool {
    matches!(item.json, Json::String(_) | Json::Array(_))
}

/// Largest channel without a warning: 1 in the display-encoded space, more in linear ones, where light may be
/// brighter than white.
fn brightest(space: WorkingSpace) -> f64 {
    if space == WorkingSpace::Srgb { 1.0 } else { 16.0 }
}

/// Formats a list of numbers as it was written.
pub(super) fn value_text(items: &[Spanned]) -> String {
    let texts: Vec<String> = items.iter().map(Spanned::brief).collect();
    format!("[{}]", texts.join(", "))
}

/// From this size on, a limit means that of f32.
const WIDE: f64 = 1e30;

/// Describes the values that a knob takes.
pub fn expected(takes: &KnobType) -> String {
    match takes {
        KnobType::Number { min, max } => match (*min > -WIDE, *max < WIDE) {
            (true, true) => format!("a number from {} to {}", number_text(*min), number_text(*max)),
            (true, false) => format!("a number, at least {}", number_text(*min)),
            (false, true) => format!("a number, at most {}", number_text(*max)),
            (false, false) => "a finite number".into(),
        },
        KnobType::Integer { min, max } => format!("a whole number from {min} to {max}"),
        KnobType::Bool => "true or false".into(),
        KnobType::Choice(words) => format!("one of {}", words.join(", ")),
        KnobType::Color => {
            "a color: \"#rrggbb\" in sRGB, [r, g, b] in the working space, or the name of one, \"palette.NAME\"".into()
        }
        KnobType::Vector(n) => format!("a list of {n} numbers"),
        KnobType::Text => "a string".into(),
        KnobType::Path => "a path relative to the document".into(),
        KnobType::Numbers { min, max } => format!("a list of {}", count(*min, *max, "number")),
        KnobType::Texts { max } => format!("a list of {}", count(1, *max, "string")),
    }
}

pub(super) fn count(min: usize, max: usize, what: &str) -> String {
    let plural = if max == 1 || what == "Weights" { "" } else { "s" };
    if min == max {
        format!("{min} {what}{plural}")
    } else if max > 4096 && min == 0 {
        format!("{what}{plural}")
    } else if max > 4096 {
        format!("at least {min} {what}{plural}")
    } else {
        format!("{min} to {max} {what}{plural}")
    }
}

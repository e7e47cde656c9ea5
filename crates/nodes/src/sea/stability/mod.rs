//! Long-term numerical behavior of seas: predictions compared with measurements.

mod errors;
mod toon;
mod waves;

pub(crate) use errors::errors;
pub(crate) use toon::toon;
pub(crate) use waves::waves;

use trochoid_graph::{Figure, Relation};

/// Returns a figure with neither a prediction nor a measurement yet.
fn figure(key: &'static str, name: &'static str, unit: &'static str) -> Figure {
    Figure { key, name, unit, predicted: None, measured: None, relation: Relation::Unrelated, note: String::new() }
}

/// Formats a number of seconds in a readable unit.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{s:.3} s"),
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 6e3 => format!("{:.0} minutes", s / 60.0),
        s if s < 1.7e5 => format!("{:.0} hours", s / 3600.0),
        s if s < 6e7 => format!("{:.0} days", s / 86_400.0),
        s if s < 1e13 => format!("{:.0} years", s / 3.156e7),
        _ => "longer than any animation".into(),
    }
}

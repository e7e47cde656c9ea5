//! The report as plain text, at most 100 columns wide.

use super::{NodeErrors, steps};
use crate::shell::{HEADING, printable, wrap};
use std::fmt::Write as _;
use std::path::PathBuf;
use trochoid::{CheckedGraph, Figure, NodeId, Relation, Stability};

/// Widths of the columns: names, numbers, and results of comparisons.
const NAME: usize = 32;
const NUMBER: usize = 12;
const HOLDS: usize = 2;

/// Formats the report on all nodes.
pub(super) fn report(
    graph: &CheckedGraph,
    found: &[(NodeId, Stability)],
    maps: &[(NodeId, PathBuf)],
    errors: &[NodeErrors],
) -> String {
    let mut text = String::new();
    for (index, (id, report)) in found.iter().enumerate() {
        let node = graph.node(*id);
        let gap = if index > 0 { "\n" } else { "" };
        let title = format!("{} ({})", printable(&node.name), node.ty.declaration().name);
        let _ = writeln!(text, "{gap}{HEADING}{title}{HEADING:#}: {}", report.verdict.name());
        report.explanation.iter().for_each(|sentence| text.push_str(&wrap(sentence, 2)));
        if !report.figures.is_empty() {
            let _ = writeln!(text, "\n  {:NAME$}{:>NUMBER$}{:>NUMBER$}", "", "predicted", "measured");
            report.figures.iter().for_each(|figure| text.push_str(&row(figure)));
        }
        if let Some((_, path)) = maps.iter().find(|(mapped, _)| mapped == id) {
            let _ = writeln!(text, "\n  map: {}", printable(&path.display().to_string()));
        }
        if let Some((_, errors, plot)) = errors.iter().find(|(measured, ..)| measured == id) {
            let _ = write!(text, "\n{}", steps::table(errors));
            if let Some(path) = plot {
                let _ = writeln!(text, "\n  plot: {}", printable(&path.display().to_string()));
            }
        }
    }
    if found.is_empty() {
        text.push_str("no node depends on time except through keyframes: nothing can grow\n");
    }
    text
}

fn row(figure: &Figure) -> String {
    let name = match figure.unit {
        "" => figure.name.to_string(),
        unit => format!("{}, {unit}", figure.name),
    };
    let cell = |value: Option<f64>| value.map_or(String::new(), number);
    let holds = match (figure.holds(), figure.relation) {
        (Some(false), _) => "≠",
        (Some(true), Relation::AtMost) => "≤",
        (Some(true), Relation::AtLeast(_)) => "≥",
        (Some(true), Relation::Near(_)) => "≈",
        (Some(true), _) => "=",
        (None, _) => "",
    };
    let (predicted, measured) = (cell(figure.predicted), cell(figure.measured));
    let line = format!("  {name:NAME$}{predicted:>NUMBER$}{measured:>NUMBER$} {holds:HOLDS$}{}", figure.note);
    format!("{}\n", line.trim_end())
}

/// Formats a number with six digits, or in scientific notation if it is very small or large.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !size.is_finite() => value.to_string(),
        size if (1e-3..1e6).contains(&size) => {
            let digits = (5 - size.log10().floor() as i32).clamp(0, 8) as usize;
            let text = format!("{value:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.926_038_4, "0.926038"),
            (9.020_4, "9.0204"),
            (-1.0, "-1"),
            (123_456.7, "123457"),
            (999_999.99, "1000000"),
            (3.2e-8, "3.20e-8"),
            (4.5e9, "4.50e9"),
            (f64::INFINITY, "inf"),
            (60.0, "60"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn rows_fit_and_say_what_is_wrong() {
        let mut figure = Figure {
            key: "a",
            name: "least eigenvalue of the grid",
            unit: "",
            predicted: Some(-0.999_924_7),
            measured: Some(-1.234_56e-12),
            relation: Relation::Equal(1e-6),
            note: "mean of 4 neighbors, 256 × 256 cells".into(),
        };
        assert!(row(&figure).contains(" ≠ ") && row(&figure).trim_end().chars().count() <= 100, "{}", row(&figure));
        figure.measured = figure.predicted;
        assert!(row(&figure).contains(" = "), "{}", row(&figure));
    }
}

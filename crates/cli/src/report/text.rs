//! The report as plain text, at most 100 columns wide.

use super::data::{Report, beyond, certified, measured};
use super::numbers::{count, interval, percent, place, seconds};
use crate::shell::{HEADING, printable, wrap};
use std::fmt::Write as _;
use trochoid::Tolerance;
use trochoid::accuracy::Rung;

/// Widths of the columns: settings, and numbers.
const LABEL: usize = 28;
const NUMBER: usize = 10;
const WIDTH: usize = 100;
/// Widths of errors with their places, of quantiles and of shares with their intervals.
const PLACE: usize = 22;
const QUANTILE: usize = 24;
const SHARE: usize = 24;
/// Number of savings that are listed.
const SAVINGS: usize = 3;

/// Returns the rungs, the result of each tolerance, and the omitted work as text.
pub(super) fn table(report: &Report<'_>) -> String {
    let ladder = report.ladder;
    let format = ladder.format;
    let mut text = String::new();
    for sentence in report.summary() {
        text.push_str(&wrap(&printable(&sentence), 0));
    }
    let samples = count(format.samples() as usize, "sample");
    let size = format!("{} × {} pixels, {samples}", format.width(), format.height());
    let facts = format!("{}: frame {}, {size}, {}", report.scene, ladder.frame, count(ladder.threads, "thread"));
    let _ = writeln!(text, "\n{}", clip(&printable(&facts), WIDTH));
    let _ = writeln!(text, "Errors are in {}; intervals, in brackets, hold with 95 %.\n", report.unit());
    costs(&mut text, report);
    text.push('\n');
    errors(&mut text, report);
    tolerances(&mut text, report);
    savings(&mut text, report);
    text
}

/// Writes a line of a table: marks, a label, and cells.
fn line(text: &mut String, rung: &Rung, label: &str, cells: &str) {
    let best = if rung.is_best { '*' } else { ' ' };
    let mesh = if rung.is_method { ' ' } else { '+' };
    let _ = writeln!(text, "{best}{mesh}{:LABEL$}{cells}", clip(&printable(label), LABEL - 1));
}

/// Writes the table of largest errors and of times.
fn costs(text: &mut String, report: &Report<'_>) {
    let head = ["certified", "measured", "ambiguous", "render", "spread", "certify", "MiB"];
    let head: String = head.map(|name| format!("{name:>NUMBER$}")).concat();
    let _ = writeln!(text, "{HEADING}  {:LABEL$}{head}{HEADING:#}", "largest error, and time");
    for (rung, label) in report.rungs() {
        let [least, most] = rung.times.range();
        let certify = rung.certify.map(|certify| {
            let about = if certify.is_predicted { "~" } else { "" };
            format!("{about}{}", seconds(certify.seconds))
        });
        let cells = [
            number(certified(rung).map(|at| at.size.display)),
            number(measured(rung).map(|at| at.size.display)),
            rung.ambiguous.map_or_else(|| "–".into(), |share| percent(share.value)),
            seconds(rung.times.median()),
            if rung.times.runs() > 1 { format!("± {}", seconds(0.5 * (most - least))) } else { "one run".into() },
            certify.unwrap_or_else(|| "–".into()),
            format!("{:.1}", rung.bytes as f64 / f64::from(1 << 20)),
        ];
        line(text, rung, label, &cells.map(|cell| format!("{cell:>NUMBER$}")).concat());
    }
    text.push_str("* no other settings are certified to a smaller error in a time within the spread\n");
    if report.ladder.rungs.iter().any(|rung| !rung.is_method) {
        text.push_str(
            "+ a coarser or finer mesh, which plan does not choose: it changes which samples are ambiguous\n",
        );
    }
    text.push_str("certified, measured: where no sample of the pixel is ambiguous");
    text.push_str(report.at_pixels());
    text.push('\n');
    if report.ladder.rungs.iter().any(|rung| rung.certify.is_some_and(|certify| certify.is_predicted)) {
        text.push_str("certify: for the whole picture; ~ is extrapolated from a 24th of it\n");
    }
}

/// Writes the table of where errors are, and how many pixels have them.
fn errors(text: &mut String, report: &Report<'_>) {
    if report.ladder.rungs.iter().all(|rung| rung.measured.is_none()) {
        return;
    }
    let head = format!("{:>PLACE$}{:>QUANTILE$}{:>SHARE$}", "largest", "99 % of the pixels", "pixels off by > 1/255");
    let _ = writeln!(text, "{HEADING}  {:LABEL$}{head}{HEADING:#}", "measured, of all samples");
    for (rung, label) in report.rungs() {
        let at = rung.measured.as_ref().and_then(|figures| figures.max);
        let quantile = rung.measured.as_ref().and_then(|figures| figures.picture.quantile(0.99));
        let cells = format!(
            "{:>PLACE$}{:>QUANTILE$}{:>SHARE$}",
            at.map_or_else(|| "–".into(), |at| format!("{} at {}", figure(at.size.display), place(at.pixel))),
            interval(quantile, figure),
            interval(beyond(&rung.measured)[0], percent),
        );
        line(text, rung, label, &cells);
    }
}

fn tolerances(text: &mut String, report: &Report<'_>) {
    let ladder = report.ladder;
    let by = format!("met{} by the fastest method that is certified to it", report.at_pixels());
    let _ = writeln!(text, "\n{HEADING}  {:12}{:12}{by}{HEADING:#}", "tolerance", "allowed");
    for attempt in &ladder.attempts {
        let by = match (attempt.rung, &attempt.limit) {
            (Some(rung), _) => format!("{} in {}", report.met_by(rung), seconds(ladder.rungs[rung].times.median())),
            (None, Some(limit)) => format!("nothing: {limit}"),
            (None, None) => "nothing: there was no time to certify every method".into(),
        };
        let asked = Tolerance::Error(attempt.tolerance).to_string();
        let line = format!("  {asked:12}{:12}{}", number(Some(attempt.allowed)), printable(&by));
        let _ = writeln!(text, "{}", clip(&line, WIDTH));
    }
    let unit = report.space.name();
    let _ = writeln!(text, "allowed: in units of {unit}; judged on unambiguous samples, also beside ambiguous ones");
}

fn savings(text: &mut String, report: &Report<'_>) {
    let savings = report.savings();
    if !savings.is_empty() {
        let _ = writeln!(text, "\n{HEADING}  {:24}{:>12}  why{HEADING:#}", "left out", "saves");
    }
    for saving in savings.iter().take(SAVINGS) {
        let name = clip(&printable(&format!("{} ({})", saving.node, saving.ty)), 23);
        let saved = saving.seconds.map_or_else(|| "–".to_owned(), seconds);
        let line = format!("  {name:24}{saved:>12}  {}", printable(&saving.why));
        let _ = writeln!(text, "{}", clip(&line, WIDTH));
    }
    if savings.len() > SAVINGS {
        let _ = writeln!(text, "  and {} more", savings.len() - SAVINGS);
    }
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(|| "–".into(), figure)
}

/// Formats an error as in each of the tables: `8.5e-3`.
fn figure(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.1e}") }
}

/// Clips a text to this many characters.
fn clip(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    text.chars().take(width - 1).chain(['…']).collect()
}

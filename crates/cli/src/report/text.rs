//! The report as plain text, at most 100 columns wide.

use super::data::Report;
use super::numbers::{count, seconds};
use crate::shell::{HEADING, printable, wrap};
use std::fmt::Write as _;
use trochoid::Tolerance;

/// Widths of the columns: settings, and numbers.
const LABEL: usize = 30;
const NUMBER: usize = 11;
const WIDTH: usize = 100;
/// Number of savings that are listed.
const SAVINGS: usize = 3;

/// Returns the rungs, the result of each tolerance, and the omitted work as text.
pub(super) fn table(report: &Report<'_>) -> String {
    let ladder = report.ladder;
    let format = ladder.format;
    let mut text = wrap(&printable(&report.summary().join(" ")), 0);
    let samples = count(format.samples() as usize, "sample");
    let size = format!("{} × {} pixels, {samples}", format.width(), format.height());
    let facts = format!("{}: frame {}, {size}, {}", report.scene, ladder.frame, count(ladder.threads, "thread"));
    let _ = writeln!(text, "\n{}", clip(&printable(&facts), WIDTH));
    let on_strips = if report.whole { "" } else { "†" };
    let head = ["certified", "99.9 %", "measured", "ambiguous"].map(|name| format!("{name}{on_strips}"));
    let head = head.into_iter().chain(["time".into(), "MiB".into()]);
    let head: String = head.map(|name| format!("{name:>NUMBER$}")).collect();
    let _ = writeln!(text, "{HEADING}  {:LABEL$}{head}{HEADING:#}", "settings");
    for (rung, label) in report.rungs() {
        let cells = [
            number(rung.certified.max),
            number(rung.certified.p999),
            number(rung.measured.max),
            format!("{:.2} %", 100.0 * rung.ambiguous),
            seconds(rung.seconds),
            format!("{:.1}", rung.bytes as f64 / f64::from(1 << 20)),
        ];
        let cells: String = cells.iter().map(|cell| format!("{cell:>NUMBER$}")).collect();
        let best = if rung.is_best { '*' } else { ' ' };
        let mesh = if rung.is_method { ' ' } else { '+' };
        let _ = writeln!(text, "{best}{mesh}{:LABEL$}{cells}", clip(&printable(label), LABEL - 1));
    }
    text.push_str("* no other settings are both faster and certified to a smaller error\n");
    if ladder.rungs.iter().any(|rung| !rung.is_method) {
        text.push_str(
            "+ a coarser or finer mesh, which plan does not choose: it changes which samples are ambiguous\n",
        );
    }
    if !report.whole {
        text.push_str("† on strips, an eighth of the picture in total; --whole certifies the whole picture\n");
    }
    let by = format!("met{} by the fastest method that is certified to it", report.on_strips());
    let _ = writeln!(text, "\n{HEADING}  {:12}{:12}{by}{HEADING:#}", "tolerance", "allowed");
    for attempt in &ladder.attempts {
        let by = match (attempt.rung, &attempt.limit) {
            (Some(rung), _) => format!("{} in {}", report.met_by(rung), seconds(ladder.rungs[rung].seconds)),
            (None, Some(limit)) => format!("nothing: {limit}"),
            (None, None) => "nothing".into(),
        };
        let asked = Tolerance::Error(attempt.tolerance).to_string();
        let line = format!("  {asked:12}{:12}{}", number(attempt.allowed), printable(&by));
        let _ = writeln!(text, "{}", clip(&line, WIDTH));
    }
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
    text
}

fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:.1e}") } else { "–".into() }
}

/// Clips a text to this many characters.
fn clip(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    text.chars().take(width - 1).chain(['…']).collect()
}

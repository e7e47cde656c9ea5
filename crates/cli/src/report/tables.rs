//! The tables of the page.

use super::data::Report;
use super::escape::escape;
use super::numbers::{mebibytes, percent, seconds, short};
use std::fmt::Write as _;
use trochoid::accuracy::Rung;

/// Returns the table of omitted work, with reasons and time saved.
pub(super) fn savings(report: &Report<'_>) -> String {
    let savings = report.savings();
    if savings.is_empty() {
        return "<p>Nothing is left out: the output needs the whole document.</p>".into();
    }
    let mut table = String::from(
        "<div class=\"wide\"><table>\n<thead><tr><th class=\"text\">node</th><th class=\"text\">type</th>\
         <th class=\"text\">why</th><th>time saved, all threads</th></tr></thead>\n<tbody>\n",
    );
    for saving in savings {
        let _ = writeln!(
            table,
            "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"why\">{}</td><td>{}</td></tr>",
            escape(&saving.node),
            saving.ty,
            escape(&saving.why),
            saving.seconds.map_or_else(|| "not measured".into(), seconds),
        );
    }
    table + "</tbody></table></div>"
}

/// Groups of columns whose figures apply to the strips if only strips are certified.
const CERTIFIED: &str = "certified";
const MEASURED: &str = "measured";
const RATIO: &str = "ratio";
const DOUBT: &str = "ambiguous samples";

/// Groups of columns of the full table.
const GROUPS: &[(&str, &[&str])] = &[
    (CERTIFIED, &["largest", "99.9 %", "median"]),
    (MEASURED, &["largest", "RMS", "99.9 %", "median", "pixels"]),
    (RATIO, &["cert. ÷ meas."]),
    (DOUBT, &["all", "> 1/255"]),
    ("pixels", &["outside hull", "not a number"]),
    ("time", &["median", "spread", "predicted", "÷ median"]),
    ("memory", &["held"]),
];

fn cells(rung: &Rung) -> Vec<String> {
    let (certified, measured) = (rung.certified, rung.measured);
    vec![
        short(certified.max),
        short(certified.p999),
        short(certified.median),
        short(measured.max),
        short(measured.rms),
        short(measured.p999),
        short(measured.median),
        rung.measured_pixels.to_string(),
        short(rung.ratio),
        percent(rung.ambiguous),
        percent(rung.ambiguous_beyond_8_bit),
        rung.hull_exits.to_string(),
        rung.nan.to_string(),
        seconds(rung.seconds),
        seconds(rung.spread),
        seconds(rung.predicted),
        short(rung.predicted / rung.seconds),
        mebibytes(rung.bytes),
    ]
}

/// Returns the full table: all columns of all rungs.
pub(super) fn rungs(report: &Report<'_>) -> String {
    let mut table =
        String::from("<div class=\"wide\"><table>\n<thead>\n<tr><th class=\"text\" rowspan=\"2\">settings</th>");
    for (name, columns) in GROUPS {
        let strips = if [CERTIFIED, MEASURED, RATIO, DOUBT].contains(name) { report.on_strips() } else { "" };
        let _ = write!(table, "<th class=\"group\" colspan=\"{}\">{name}{strips}</th>", columns.len());
    }
    table.push_str("</tr>\n<tr>");
    for column in GROUPS.iter().flat_map(|(_, columns)| *columns) {
        let _ = write!(table, "<th>{}</th>", escape(column));
    }
    table.push_str("</tr>\n</thead>\n<tbody>\n");
    for (rung, label) in report.rungs() {
        let class = match (rung.is_best, rung.is_method) {
            (true, true) => " class=\"best\"",
            (true, false) => " class=\"best mesh\"",
            (false, true) => "",
            (false, false) => " class=\"mesh\"",
        };
        // The full assignments, for use with `--set`.
        let _ = write!(
            table,
            "<tr{class}><td class=\"text\" title=\"{}\">{}</td>",
            escape(&rung.set.join(" ")),
            escape(label)
        );
        for cell in cells(rung) {
            let _ = write!(table, "<td>{}</td>", escape(&cell));
        }
        table.push_str("</tr>\n");
    }
    table + "</tbody></table></div>"
}

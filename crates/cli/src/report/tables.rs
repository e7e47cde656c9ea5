//! The tables of the page.

use super::data::{Report, beyond};
use super::escape::escape;
use super::numbers::{interval, mebibytes, percent, place, seconds, short};
use std::fmt::Write as _;
use trochoid::accuracy::{ErrorAt, ErrorSample, Rung};

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

/// Groups of columns of the full table.
const GROUPS: &[(&str, &[&str])] = &[
    ("certified, where not ambiguous", &["largest", "at pixel"]),
    ("certified", &["largest", "at pixel", "99 % of the pixels", "median"]),
    ("measured, where not ambiguous", &["largest", "at pixel"]),
    ("measured", &["largest", "at pixel", "RMS", "99 % of the pixels", "median", "pixels > 1/255"]),
    ("measured where settings differ", &["RMS", "99 % of the pixels", "pixels > 1/255"]),
    ("certified ÷ measured, median", &["all pixels", "where settings differ"]),
    ("pixels with ambiguous samples", &["all", "certified > 1/255"]),
    ("pixels of the picture", &["outside the hull", "no number"]),
    ("time of rendering", &["median", "least to most", "runs", "predicted", "÷ median"]),
    ("time of certifying", &["whole picture", "÷ rendering"]),
    ("memory", &["held"]),
];

fn cells(rung: &Rung) -> Vec<String> {
    let none = || "–".to_owned();
    let largest = |at: Option<ErrorAt>| {
        [at.map_or_else(none, |at| short(at.size.display)), at.map_or_else(none, |at| place(at.pixel))]
    };
    let [certified, measured] = [&rung.certified, &rung.measured].map(Option::as_ref);
    let quantile =
        |sample: Option<&ErrorSample>, share: f64| interval(sample.and_then(|sample| sample.quantile(share)), short);
    let rms = |sample: Option<&ErrorSample>| sample.and_then(ErrorSample::rms).map_or_else(none, short);
    let [beyond, beyond_apart] = beyond(&rung.measured).map(|share| interval(share, percent));
    let [bounds, errors] = [certified, measured].map(|figures| figures.map(|figures| &figures.picture));
    let apart = measured.map(|figures| &figures.apart);
    let [least, most] = rung.times.range().map(seconds);
    let median = rung.times.median();
    let certify = rung.certify.map_or_else(none, |certify| {
        format!("{}{}", if certify.is_predicted { "about " } else { "" }, seconds(certify.seconds))
    });
    let mut cells = Vec::new();
    cells.extend(largest(certified.and_then(|figures| figures.clear_max)));
    cells.extend(largest(certified.and_then(|figures| figures.max)));
    cells.extend([0.99, 0.5].map(|share| quantile(bounds, share)));
    cells.extend(largest(measured.and_then(|figures| figures.clear_max)));
    cells.extend(largest(measured.and_then(|figures| figures.max)));
    cells.extend([rms(errors), quantile(errors, 0.99), quantile(errors, 0.5), beyond]);
    cells.extend([rms(apart), quantile(apart, 0.99), beyond_apart]);
    cells.extend(rung.ratios.map(|ratio| ratio.map_or_else(none, short)));
    cells.extend([rung.ambiguous, rung.ambiguous_beyond_8_bit].map(|share| interval(share, percent)));
    cells.extend([rung.hull_exits, rung.nan].map(|count| count.to_string()));
    cells.extend([seconds(median), format!("{least} to {most}"), rung.times.runs().to_string()]);
    cells.extend([rung.predicted.map_or_else(none, seconds), rung.predicted.map_or_else(none, |p| short(p / median))]);
    cells.extend([certify, rung.certify.map_or_else(none, |certify| short(certify.seconds / median))]);
    cells.push(mebibytes(rung.bytes));
    cells
}

/// Returns the full table: all columns of all rungs.
pub(super) fn rungs(report: &Report<'_>) -> String {
    let mut table =
        String::from("<div class=\"wide\"><table>\n<thead>\n<tr><th class=\"text\" rowspan=\"2\">settings</th>");
    for (name, columns) in GROUPS {
        let _ = write!(table, "<th class=\"group\" colspan=\"{}\">{name}</th>", columns.len());
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

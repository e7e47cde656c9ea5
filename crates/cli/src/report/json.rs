//! The report as JSON, and the columns of its table.

use super::data::{AS_IT_IS, Report};
use serde_json::{Map, Value, json};
use trochoid::accuracy::{EIGHT_BIT, ErrorAt, ErrorFigures, Estimate, Limit, Rung};
use trochoid::{Shading, VERSION};

/// Returns a number as JSON: null if it is not finite.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn known(value: Option<f64>) -> Value {
    value.map_or(Value::Null, finite)
}

type Columns = Vec<(String, Value)>;

/// Adds an estimate as three columns: the value, and the ends of its interval.
fn estimate(columns: &mut Columns, name: &str, estimate: Option<Estimate>) {
    columns.push((name.to_owned(), known(estimate.map(|estimate| estimate.value))));
    columns.push((format!("{name}_low"), known(estimate.map(|estimate| estimate.low))));
    columns.push((format!("{name}_high"), known(estimate.map(|estimate| estimate.high))));
}

/// Adds a largest error as columns: in both units, with its place.
fn largest(columns: &mut Columns, name: &str, at: Option<ErrorAt>) {
    columns.push((name.to_owned(), known(at.map(|at| at.size.display))));
    columns.push((format!("{name}_working"), known(at.map(|at| at.size.working))));
    for (axis, name) in ["x", "y"].iter().map(|axis| format!("{name}_{axis}")).enumerate() {
        columns.push((name, at.map_or(Value::Null, |at| json!(at.pixel[axis]))));
    }
}

/// Adds the figures of errors or bounds.
fn figures(columns: &mut Columns, name: &str, figures: Option<&ErrorFigures>) {
    largest(columns, &format!("{name}_clear_max"), figures.and_then(|figures| figures.clear_max));
    largest(columns, &format!("{name}_max"), figures.and_then(|figures| figures.max));
    for part in ["", "_apart"] {
        let sample = figures.map(|figures| if part.is_empty() { &figures.picture } else { &figures.apart });
        columns.push((format!("{name}{part}_pixels"), json!(sample.map_or(0, |sample| sample.count()))));
        for (share, word) in [(0.5, "median"), (0.99, "p99"), (0.999, "p999")] {
            estimate(columns, &format!("{name}{part}_{word}"), sample.and_then(|sample| sample.quantile(share)));
        }
        columns.push((format!("{name}{part}_rms"), known(sample.and_then(|sample| sample.rms()))));
        let beyond = sample.and_then(|sample| sample.above(EIGHT_BIT));
        estimate(columns, &format!("{name}{part}_beyond_8_bit"), beyond);
    }
}

/// Returns the row of a rung: names and values of its columns. All rungs have the same names.
pub(super) fn columns(report: &Report<'_>, rung: &Rung) -> Columns {
    let ladder = report.ladder;
    let settings = if rung.set.is_empty() { AS_IT_IS.to_owned() } else { rung.set.join(" ") };
    let own = |name: &str, value: Value| (name.to_owned(), value);
    let mut columns = vec![
        own("scene", json!(report.scene)),
        own("output", json!(ladder.output)),
        own("frame", json!(ladder.frame)),
        own("settings", json!(settings)),
        own("seed", json!(ladder.seed)),
        own("is_method", json!(rung.is_method)),
        own("scope", json!(report.scope())),
    ];
    figures(&mut columns, "certified", rung.certified.as_ref());
    figures(&mut columns, "measured", rung.measured.as_ref());
    estimate(&mut columns, "ambiguous_pixels", rung.ambiguous);
    estimate(&mut columns, "ambiguous_pixels_beyond_8_bit", rung.ambiguous_beyond_8_bit);
    let [least, most] = rung.times.range();
    let certify = rung.certify.map(|certify| certify.seconds);
    columns.extend([
        own("certified_over_measured", known(rung.ratios[0])),
        own("certified_over_measured_apart", known(rung.ratios[1])),
        own("bounds_broken", json!(rung.broken.len())),
        own("pixels_outside_hull", json!(rung.hull_exits)),
        own("pixels_no_number", json!(rung.nan)),
        own("render_seconds", finite(rung.times.median())),
        own("render_seconds_least", finite(least)),
        own("render_seconds_most", finite(most)),
        own("render_runs", json!(rung.times.runs())),
        own("render_seconds_predicted", known(rung.predicted)),
        own("predicted_over_taken", known(rung.predicted.map(|predicted| predicted / rung.times.median()))),
        own("certify_seconds", known(certify)),
        own("certify_is_predicted", rung.certify.map_or(Value::Null, |certify| json!(certify.is_predicted))),
        own("certify_over_render", known(certify.map(|certify| certify / rung.times.median()))),
        own("bytes", json!(rung.bytes)),
        own("threads", json!(ladder.threads)),
        own("pareto", json!(rung.is_best)),
    ]);
    columns
}

/// Returns a limit as JSON: a pass, with the reason if it has no error bound; or a word for another limit.
fn limited_by(limit: &Limit) -> Value {
    match limit {
        Limit::Pass { node, ty } => json!({ "node": node, "type": ty }),
        Limit::Unbounded { node, ty, why } => json!({ "node": node, "type": ty, "why": why }),
        Limit::Rounding => json!("rounding"),
        Limit::Unseen => json!("what is seen"),
    }
}

/// Returns the whole report except for its pictures as JSON.
pub(super) fn to_json(report: &Report<'_>) -> Value {
    let ladder = report.ladder;
    let rungs = ladder.rungs.iter().map(|rung| {
        let mut row: Map<String, Value> = columns(report, rung).into_iter().collect();
        row.insert("set".into(), json!(rung.set));
        let passes = rung.passes.iter();
        let passes = passes.map(|pass| json!({ "node": pass.node, "type": pass.ty, "drop": finite(pass.drop) }));
        row.insert("passes".into(), passes.collect());
        let broken = rung.broken.iter();
        let broken = broken.map(
            |broken| json!({ "pixel": broken.pixel, "bound": finite(broken.bound), "error": finite(broken.error) }),
        );
        row.insert("broken".into(), broken.collect());
        Value::Object(row)
    });
    let attempts = ladder.attempts.iter().map(|attempt| {
        let met = attempt.rung.map(|index| &ladder.rungs[index]);
        json!({
            "tolerance": finite(attempt.tolerance),
            "allowed": finite(attempt.allowed),
            "scope": report.scope(),
            "met": met.is_some(),
            "set": met.map(|rung| &rung.set),
            "certified": met.and_then(|rung| rung.judged),
            "limited_by": attempt.limit.as_ref().map(limited_by),
        })
    });
    let savings = ladder.savings.iter().map(|saving| {
        let seconds = saving.seconds.map(finite);
        json!({ "node": saving.node, "type": saving.ty, "why": saving.why, "seconds": seconds })
    });
    let scalings = ladder.scalings.iter().map(|scaling| {
        let points = scaling.points.iter();
        let points = points.map(|(value, seconds)| json!({ "value": finite(*value), "seconds": finite(*seconds) }));
        json!({ "knob": scaling.knob, "points": points.collect::<Vec<_>>() })
    });
    let (at, short) = (ladder.looked_at, &ladder.shortfall);
    json!({
        "trochoid": VERSION,
        "scene": report.scene,
        "output": ladder.output,
        "frame": ladder.frame,
        "format": {
            "width": ladder.format.width(),
            "height": ladder.format.height(),
            "samples": ladder.format.samples(),
            "adaptive": ladder.format.adaptive(),
            "shading": match ladder.format.shading() { Shading::Pixel => "pixel", Shading::Sample => "sample" },
        },
        "space": report.space.name(),
        "unit": report.unit(),
        "threads": ladder.threads,
        "seed": ladder.seed,
        "whole": ladder.is_whole,
        "within_seconds": report.within,
        "pixels": {
            "picture": at.picture,
            "apart": at.apart,
            "looked_at": at.all,
            "total": at.total,
            "differing": at.differing,
            "without_reference": at.given_up,
        },
        "confidence": 0.95,
        "summary": report.summary(),
        "missing": {
            "settings": short.settings,
            "rungs_without_bounds": short.bounds,
            "references": short.references,
            "rungs_without_certify_seconds": short.certify,
            "passes": short.passes,
        },
        "left_to_whole": report.left_to_whole(),
        "unseen": ladder.unseen.iter().map(|unseen| json!({ "view": unseen.view, "nodes": unseen.nodes }))
            .collect::<Vec<_>>(),
        "rungs": rungs.collect::<Vec<_>>(),
        "attempts": attempts.collect::<Vec<_>>(),
        "savings": savings.collect::<Vec<_>>(),
        "scalings": scalings.collect::<Vec<_>>(),
    })
}

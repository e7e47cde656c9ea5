//! Plots of error against time, certified against measured error, and requested against achieved error.

use super::labels::Labels;
use super::{CERTIFIED, INK, LogLog, MEASURED, Mark, Outcome, REFUSED, WIDTH, around, legend, log_log, svg};
use crate::report::data::{Report, certified, measured};
use plotters::prelude::*;
use std::ops::Range;
use trochoid::Tolerance;
use trochoid::accuracy::{Estimate, Limit, Rung};

const HEIGHT: u32 = 480;

/// Share of pixels whose largest error is drawn with its interval: few pixels suffice to bound it.
const MOST: f64 = 0.9;

/// Returns the ends of an interval as far as they are known.
fn ends(estimate: Estimate) -> [f64; 2] {
    [estimate.low, if estimate.high.is_finite() { estimate.high } else { estimate.value }]
}

/// Returns whether a logarithmic axis can show a value.
fn shows(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Returns the position of a point in the drawing.
fn spot(chart: &LogLog<'_>, point: (f64, f64)) -> (i32, i32) {
    chart.backend_coord(&point)
}

fn room(chart: &LogLog<'_>) -> Labels {
    let (across, down) = chart.plotting_area().get_pixel_range();
    Labels::within([across.start + 4, down.start - 8, WIDTH as i32 - 4, down.end - 4])
}

/// Plots certified and measured error against time; `None` if there is neither.
pub(in crate::report) fn time(report: &Report<'_>) -> Outcome<Option<String>> {
    let rungs = || report.rungs();
    let largest = |rung: &Rung| [certified(rung), measured(rung)].map(|at| at.map_or(f64::NAN, |at| at.size.display));
    if !rungs().any(|(rung, _)| largest(rung).iter().any(|error| shows(*error))) {
        return Ok(None);
    }
    let most = |rung: &Rung| rung.measured.as_ref().and_then(|figures| figures.picture.quantile(MOST));
    let x = around(rungs().flat_map(|(rung, _)| rung.times.range()));
    let y = around(rungs().flat_map(|(rung, _)| {
        let interval = most(rung).map(ends);
        largest(rung).into_iter().chain(interval.into_iter().flatten())
    }));
    svg(HEIGHT, |area| {
        let mut chart = log_log(area, [x, y.clone()], ["seconds a frame", "error, certified and measured"])?;
        let mut front: Vec<(f64, f64)> = rungs()
            .filter(|(rung, _)| rung.is_best && shows(largest(rung)[0]))
            .map(|(rung, _)| (rung.times.median(), largest(rung)[0]))
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.draw_series(LineSeries::new(front, CERTIFIED.stroke_width(2)))?;
        let mut labels = room(&chart);
        for (rung, _) in rungs() {
            let seconds = rung.times.median();
            let points = largest(rung).map(|error| (seconds, error));
            if let Some((_, error)) = points.into_iter().find(|point| shows(point.1)) {
                let ends = rung.times.range().map(|end| (end, error));
                chart.draw_series(LineSeries::new(ends, INK.mix(0.5).stroke_width(1)))?;
            }
            if let Some(most) = most(rung).filter(|most| shows(most.value)) {
                let ends = ends(most).map(|end| (seconds, end.clamp(y.start, y.end)));
                chart.draw_series(LineSeries::new(ends, MEASURED.mix(0.6).stroke_width(2)))?;
                chart.draw_series([Cross::new((seconds, most.value), 4, MEASURED.stroke_width(2))])?;
            }
            for (point, style) in points.into_iter().zip([CERTIFIED.filled(), MEASURED.stroke_width(2)]) {
                if shows(point.1) {
                    chart.draw_series([Circle::new(point, 5, style)])?;
                    labels.keep_clear(spot(&chart, point));
                }
            }
        }
        for (rung, label) in rungs() {
            if let Some(error) = largest(rung).into_iter().find(|error| shows(*error)) {
                labels.put(area, spot(&chart, (rung.times.median(), error)), label)?;
            }
        }
        let marks = [
            (Mark::Dot(CERTIFIED), "largest certified"),
            (Mark::Ring(MEASURED), "largest measured"),
            (Mark::Cross(MEASURED), "measured, 90 % of the pixels"),
            (Mark::Line, "beaten by no other settings"),
        ];
        legend(area, (100, 20), &marks)?;
        Ok(())
    })
    .map(Some)
}

/// Plots the largest certified against the largest measured errors; `None` if no settings have both.
pub(in crate::report) fn measured_and_certified(report: &Report<'_>) -> Outcome<Option<String>> {
    let points = || {
        let all = report
            .rungs()
            .filter_map(|(rung, label)| Some(((measured(rung)?.size.display, certified(rung)?.size.display), label)));
        all.filter(|((measured, certified), _)| shows(*measured) && shows(*certified))
    };
    if points().next().is_none() {
        return Ok(None);
    }
    let x = around(points().map(|((measured, _), _)| measured));
    let y = around(points().flat_map(|((measured, certified), _)| [measured, certified]));
    svg(HEIGHT, |area| {
        let names = ["largest measured error at the pixels looked at", "largest certified error"];
        let certified = format!("{}{}", names[1], report.at_pixels());
        let mut chart = log_log(area, [x.clone(), y.clone()], [names[0], &certified])?;
        equal(&mut chart, &x, &y)?;
        let mut labels = room(&chart);
        for (point, _) in points() {
            chart.draw_series([Circle::new(point, 5, CERTIFIED.filled())])?;
            labels.keep_clear(spot(&chart, point));
        }
        for (point, label) in points() {
            labels.put(area, spot(&chart, point), label)?;
        }
        legend(area, (100, 20), &[(Mark::Dot(CERTIFIED), "settings"), (Mark::Dashes, "where both are equal")])?;
        Ok(())
    })
    .map(Some)
}

/// Draws the line where both coordinates are equal.
fn equal(chart: &mut LogLog<'_>, x: &Range<f64>, y: &Range<f64>) -> Outcome<()> {
    let (low, high) = (x.start.max(y.start), x.end.min(y.end));
    if low < high {
        // Dashes are cut from a series of points: more points make a straighter line.
        let points = (0..=200).map(|step| {
            let value = low * (high / low).powf(f64::from(step) / 200.0);
            (value, value)
        });
        let dashes = DashedLineSeries::new(points, 5, 5, INK.mix(0.6).stroke_width(1));
        chart.draw_series(dashes)?;
    }
    Ok(())
}

/// Plots requested tolerances against achieved errors, and refused ones against the smallest certified error; `None` if
/// nothing is certified.
pub(in crate::report) fn asked(report: &Report<'_>) -> Outcome<Option<String>> {
    let ladder = report.ladder;
    let judged = |rung: usize| ladder.rungs[rung].judged.unwrap_or(f64::NAN);
    let methods = ladder.rungs.iter().filter(|rung| rung.is_method).filter_map(|rung| rung.judged);
    let least = methods.fold(f64::INFINITY, f64::min);
    let points = || {
        let all = ladder.attempts.iter().map(|attempt| {
            let achieved = attempt.rung.map_or(least, judged);
            ((attempt.allowed, achieved), attempt)
        });
        all.filter(|((allowed, achieved), _)| shows(*allowed) && shows(*achieved))
    };
    if points().next().is_none() {
        return Ok(None);
    }
    let x = around(points().map(|((allowed, _), _)| allowed));
    let y = around(points().flat_map(|((allowed, achieved), _)| [allowed, achieved]));
    svg(HEIGHT, |area| {
        let space = report.space.name();
        let names =
            [format!("error that the tolerance allows, in {space}"), format!("largest certified error, in {space}")];
        let mut chart = log_log(area, [x.clone(), y.clone()], names.each_ref().map(String::as_str))?;
        equal(&mut chart, &x, &y)?;
        let mut labels = room(&chart);
        for (point, attempt) in points() {
            if attempt.rung.is_some() {
                chart.draw_series([Circle::new(point, 5, CERTIFIED.filled())])?;
            } else {
                chart.draw_series([Cross::new(point, 5, REFUSED.stroke_width(2))])?;
            }
            labels.keep_clear(spot(&chart, point));
        }
        for (point, attempt) in points() {
            let asked = Tolerance::Error(attempt.tolerance).to_string();
            labels.put(area, spot(&chart, point), &asked)?;
        }
        let met = format!("met{}", report.at_pixels());
        let mut marks = vec![(Mark::Dot(CERTIFIED), met.as_str()), (Mark::Dashes, "exactly as requested")];
        let refusal = refusal(report);
        if let Some(refusal) = &refusal {
            marks.insert(1, (Mark::Cross(REFUSED), refusal.as_str()));
        }
        legend(area, (100, 20), &marks)?;
        Ok(())
    })
    .map(Some)
}

/// Returns the legend for refused tolerances, with the pass that limits them: it is the same for all, because the
/// most accurate settings have a single worst place.
fn refusal(report: &Report<'_>) -> Option<String> {
    let refused = report.ladder.attempts.iter().find(|attempt| attempt.rung.is_none())?;
    Some(match &refused.limit {
        Some(Limit::Pass { node, ty }) => format!("refused, limited by {node} ({ty})"),
        Some(limit) => format!("refused, {limit}"),
        None => "refused".into(),
    })
}

//! Run time over the knobs that increase work.

use super::{CERTIFIED, INK, NORMAL, Outcome, SMALL, WIDTH, font, svg};
use crate::report::data::Report;
use crate::report::numbers;
use plotters::prelude::*;
use trochoid::accuracy::Scaling;

const COLUMNS: usize = 3;
const HEIGHT: u32 = 260;

/// Draws a small plot for each knob; `None` if there are none.
pub(in crate::report) fn scalings(report: &Report<'_>) -> Outcome<Option<String>> {
    let all: Vec<&Scaling> = report.ladder.scalings.iter().filter(|scaling| !scaling.points.is_empty()).collect();
    if all.is_empty() {
        return Ok(None);
    }
    let rows = all.len().div_ceil(COLUMNS);
    let most = all.iter().flat_map(|scaling| &scaling.points).map(|point| point.1).fold(0.0, f64::max);
    let svg = svg(HEIGHT * rows as u32, |area| {
        let cells = area.split_evenly((rows, COLUMNS));
        for (scaling, cell) in all.iter().zip(&cells) {
            let last = scaling.points.iter().map(|point| point.0).fold(0.0, f64::max);
            let last = if last > 0.0 { last } else { 1.0 };
            let mut chart = ChartBuilder::on(cell)
                .caption(&scaling.knob, font(NORMAL))
                .margin_right(WIDTH / 40)
                .margin_top(6)
                .x_label_area_size(34)
                .y_label_area_size(70)
                .build_cartesian_2d(0.0..1.08 * last, 0.0..1.15 * most)?;
            chart
                .configure_mesh()
                .light_line_style(TRANSPARENT)
                .bold_line_style(INK.mix(0.12))
                .axis_style(INK.mix(0.4))
                .label_style(font(SMALL))
                .x_labels(4)
                .y_labels(5)
                .x_label_formatter(&plain)
                .y_label_formatter(&|seconds| if *seconds == 0.0 { "0".into() } else { numbers::seconds(*seconds) })
                .draw()?;
            let mut points = scaling.points.clone();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            chart.draw_series(LineSeries::new(points.iter().copied(), CERTIFIED.stroke_width(2)))?;
            chart.draw_series(points.iter().map(|point| Circle::new(*point, 4, CERTIFIED.filled())))?;
        }
        Ok(())
    })?;
    Ok(Some(svg))
}

/// Formats the value of a knob.
fn plain(value: &f64) -> String {
    // Ticks are sums of steps, so their last digits are rounding errors.
    ((value * 1e6).round() / 1e6 + 0.0).to_string()
}

//! Time of rendering beside time of certifying.

use super::{CERTIFIED, INK, MEASURED, Mark, Outcome, SMALL, WIDTH, around, at, font, legend, svg, ticks};
use crate::report::data::Report;
use crate::report::numbers::seconds;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const ROW: i32 = 48;
const BAR: i32 = 15;
const TOP: i32 = 50;
const LEFT: i32 = 250;
const RIGHT: i32 = 210;

/// Draws two bars for each rung on a logarithmic scale; `None` if no time of certifying is known.
pub(in crate::report) fn times(report: &Report<'_>) -> Outcome<Option<String>> {
    let rows: Vec<_> = report.rungs().collect();
    let certify = || rows.iter().filter_map(|(rung, _)| rung.certify);
    if certify().next().is_none() {
        return Ok(None);
    }
    let all = rows.iter().flat_map(|(rung, _)| rung.times.range()).chain(certify().map(|certify| certify.seconds));
    let range = around(all);
    let height = TOP + ROW * rows.len() as i32 + 40;
    let span = f64::from(WIDTH as i32 - LEFT - RIGHT);
    let x = |value: f64| {
        let part = (value / range.start).ln() / (range.end / range.start).ln();
        LEFT + (span * part.clamp(0.0, 1.0)).round() as i32
    };
    let svg = svg(height as u32, |area| {
        let marks = [
            (Mark::Patch(CERTIFIED), "rendering, median of all runs"),
            (Mark::Patch(MEASURED), "certifying the whole picture"),
        ];
        legend(area, (LEFT, 20), &marks)?;
        let bottom = height - 36;
        for tick in ticks(&range) {
            area.draw(&PathElement::new([(x(tick), TOP - 8), (x(tick), bottom)], INK.mix(0.12).stroke_width(1)))?;
            area.draw(&Text::new(seconds(tick), (x(tick), bottom + 16), font(SMALL).pos(at(HPos::Center))))?;
        }
        for (index, (rung, label)) in rows.iter().enumerate() {
            let y = TOP + ROW * index as i32;
            let name = font(SMALL).pos(at(HPos::Right));
            area.draw(&Text::new((*label).to_owned(), (LEFT - 12, y + BAR + 1), name))?;
            let [least, most] = rung.times.range();
            let median = rung.times.median();
            let beside = font(SMALL).pos(at(HPos::Left));
            area.draw(&Rectangle::new([(LEFT, y), (x(median), y + BAR)], CERTIFIED.filled()))?;
            let middle = y + BAR / 2;
            area.draw(&PathElement::new([(x(least), middle), (x(most), middle)], INK.stroke_width(2)))?;
            area.draw(&Text::new(seconds(median), (x(most) + 10, middle), beside.clone()))?;
            let Some(certify) = rung.certify else { continue };
            let top = y + BAR + 2;
            area.draw(&Rectangle::new([(LEFT, top), (x(certify.seconds), top + BAR)], MEASURED.filled()))?;
            let about = if certify.is_predicted { "about " } else { "" };
            let text = format!("{about}{}, {:.0} ×", seconds(certify.seconds), certify.seconds / median);
            area.draw(&Text::new(text, (x(certify.seconds) + 10, top + BAR / 2), beside))?;
        }
        Ok(())
    })?;
    Ok(Some(svg))
}

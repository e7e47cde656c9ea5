//! The scale of the colors of error maps.

use super::{Outcome, SMALL, WIDTH, at, font, svg, ticks};
use crate::report::numbers::short;
use crate::report::pictures::color;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::ops::Range;

const STEPS: i32 = 208;
const MARGIN: i32 = 40;

/// Draws a bar of all colors with ticks at its decades.
pub(in crate::report) fn bar(scale: &Range<f64>) -> Outcome<String> {
    let span = f64::from(WIDTH as i32 - 2 * MARGIN);
    svg(62, |area| {
        let x = |part: f64| MARGIN + (span * part).round() as i32;
        let bound = |part: f64| scale.start * (scale.end / scale.start).powf(part);
        for step in 0..STEPS {
            let [left, right] = [step, step + 1].map(|step| f64::from(step) / f64::from(STEPS));
            let middle = color(bound(0.5 * (left + right)), scale);
            area.draw(&Rectangle::new([(x(left), 6), (x(right), 26)], middle.filled()))?;
        }
        // The ends are powers of ten, and have ticks, too.
        for tick in ticks(&(scale.start * 0.999..scale.end * 1.001)) {
            let part = (tick / scale.start).ln() / (scale.end / scale.start).ln();
            area.draw(&Text::new(short(tick), (x(part), 40), font(SMALL).pos(at(HPos::Center))))?;
        }
        Ok(())
    })
}

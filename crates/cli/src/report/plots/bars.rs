//! Stacked bars of the error by pass.

use super::{INK, Mark, Outcome, SMALL, WIDTH, at, font, legend, svg};
use crate::report::data::Report;
use crate::report::numbers::short;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use trochoid::accuracy::Rung;

/// Colors of Okabe and Ito, which most color-blind people can tell apart.
const COLORS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0xC9, 0xBC, 0x2E),
];
const OTHER: RGBColor = RGBColor(0x8A, 0x90, 0x98);
const ROW: i32 = 34;
const LEFT: i32 = 250;
const RIGHT: i32 = 120;

/// Draws a bar for each rung with the shares of the passes; `None` if no pass has errors.
pub(in crate::report) fn passes(report: &Report<'_>) -> Outcome<Option<String>> {
    let total = |rung: &Rung| rung.passes.iter().map(|pass| pass.drop).sum::<f64>();
    let rows: Vec<_> = report.rungs().filter(|(rung, _)| total(rung) > 0.0).collect();
    // The passes, sorted by the sum of their shares over all rungs, largest first.
    let mut names: Vec<(&str, f64)> = Vec::new();
    for (rung, _) in &rows {
        for pass in &rung.passes {
            let share = pass.drop / total(rung);
            match names.iter_mut().find(|(name, _)| *name == pass.node) {
                Some((_, sum)) => *sum += share,
                None => names.push((&pass.node, share)),
            }
        }
    }
    if names.is_empty() {
        return Ok(None);
    }
    names.sort_by(|a, b| b.1.total_cmp(&a.1));
    let shown: Vec<(&str, RGBColor)> = names.iter().map(|(name, _)| *name).zip(COLORS).collect();
    let mut marks: Vec<(Mark, &str)> = shown.iter().map(|(name, color)| (Mark::Patch(*color), *name)).collect();
    if names.len() > shown.len() {
        marks.push((Mark::Patch(OTHER), "other passes"));
    }
    // A legend may take several lines.
    let top = 66 + 24 * (marks.iter().map(|(_, name)| name.len() as i32 * 10 + 52).sum::<i32>() / WIDTH as i32);
    let height = top + ROW * rows.len() as i32 + 44;
    let span = f64::from(WIDTH as i32 - LEFT - RIGHT);
    let svg = svg(height as u32, |area| {
        legend(area, (LEFT, 20), &marks)?;
        let bottom = height - 40;
        for part in 0..=4 {
            let x = LEFT + (span * f64::from(part) / 4.0) as i32;
            area.draw(&PathElement::new([(x, top - 8), (x, bottom)], INK.mix(0.12).stroke_width(1)))?;
            let text = format!("{} %", 25 * part);
            area.draw(&Text::new(text, (x, bottom + 16), font(SMALL).pos(at(HPos::Center))))?;
        }
        let sum = "sum of drops".to_owned();
        area.draw(&Text::new(sum, (WIDTH as i32 - 8, top - 18), font(SMALL).pos(at(HPos::Right))))?;
        for (index, (rung, label)) in rows.iter().enumerate() {
            let y = top + ROW * index as i32;
            let middle = y + ROW / 2 - 4;
            area.draw(&Text::new((*label).to_owned(), (LEFT - 12, middle), font(SMALL).pos(at(HPos::Right))))?;
            let all = total(rung);
            let drop =
                |name: &str| rung.passes.iter().filter(|pass| pass.node == name).map(|pass| pass.drop).sum::<f64>();
            let parts = shown.iter().map(|(name, color)| (drop(name), *color)).chain([(f64::INFINITY, OTHER)]);
            let mut done = 0.0;
            for (part, color) in parts {
                // The other passes take the rest.
                let end = (done + part).min(all);
                let x = |drop: f64| LEFT + (span * drop / all).round() as i32;
                if x(end) > x(done) {
                    area.draw(&Rectangle::new([(x(done), y), (x(end), y + ROW - 8)], color.filled()))?;
                }
                done = end;
            }
            let sum = short(all);
            area.draw(&Text::new(sum, (WIDTH as i32 - 8, middle), font(SMALL).pos(at(HPos::Right))))?;
        }
        Ok(())
    })?;
    Ok(Some(svg))
}

//! Plots as SVG, in two colors of the page and few of their own, so that they are readable in light and dark mode.

mod bars;
mod labels;
mod ladder;
mod scale;
mod times;
mod work;

pub(super) use bars::passes;
pub(super) use ladder::{asked, measured_and_certified, time};
pub(super) use scale::bar;
pub(super) use times::times;
pub(super) use work::scalings;

use super::numbers::short;
use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints as _, LogCoord, WithKeyPoints};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};
use std::error::Error;
use std::ops::Range;

/// Ink: the style sheet of the page replaces this color by its own.
pub(super) const INK: RGBColor = RGBColor(0x1B, 0x24, 0x30);
const CERTIFIED: RGBColor = RGBColor(0x3B, 0x7D, 0xBD);
const MEASURED: RGBColor = RGBColor(0xDB, 0x85, 0x2E);
const REFUSED: RGBColor = RGBColor(0xD0, 0x4A, 0x4A);

/// Font of the page; labels are laid out by the metrics of a wide one.
const FONT: &str = "system-ui, sans-serif";
pub(super) const WIDTH: u32 = 1040;
/// Font sizes are heights of lines, which SVG makes 1.24 times as high as letters.
const SMALL: i32 = 15;
const NORMAL: i32 = 16;

pub(super) type Outcome<T> = Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type LogAxis = WithKeyPoints<LogCoord<f64>>;
type LogLog<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<LogAxis, LogAxis>>;

/// Draws an SVG element of this height in pixels.
fn svg(height: u32, draw: impl FnOnce(&Area<'_>) -> Outcome<()>) -> Outcome<String> {
    register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font cannot be read")?;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    Ok(text)
}

fn font(size: i32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

fn at(anchor: HPos) -> Pos {
    Pos::new(anchor, VPos::Center)
}

/// Returns the smallest range between powers of ten that contains two numbers.
pub(super) fn decades(low: f64, high: f64) -> Range<f64> {
    // Exact powers of ten stay unchanged.
    let (first, last) = ((low.log10() + 1e-9).floor(), (high.log10() - 1e-9).ceil());
    10.0_f64.powf(first)..10.0_f64.powf(last.max(first + 1.0))
}

/// Returns the range of a logarithmic axis: all values that have a logarithm, with a margin.
fn around(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for value in values.into_iter().filter(|value| value.is_finite() && *value > 0.0) {
        (low, high) = (low.min(value), high.max(value));
    }
    if high == 0.0 { 0.1..1.0 } else { low / 1.8..high * 1.8 }
}

/// Returns at most about eight powers of ten as ticks, with 2 and 5 times each on short ranges.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    let factors: &[f64] = if range.end / range.start < 300.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let step = (((last - first) as usize).div_ceil(8)).max(1);
    let powers = (first..=last).filter(|power| power.rem_euclid(step as i32) == 0);
    let all = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10.0_f64.powi(power)));
    all.filter(|tick| range.contains(tick)).collect()
}

/// Draws the axes of a log–log plot, with grid lines and titles.
fn log_log<'a>(area: &Area<'a>, [x, y]: [Range<f64>; 2], [across, up]: [&str; 2]) -> Outcome<LogLog<'a>> {
    let axis =
        |range: &Range<f64>| -> LogAxis { LogCoord::from(range.clone().log_scale()).with_key_points(ticks(range)) };
    let mut chart = ChartBuilder::on(area)
        .margin_top(44)
        .margin_right(28)
        .margin_bottom(8)
        .margin_left(8)
        .x_label_area_size(56)
        .y_label_area_size(84)
        .build_cartesian_2d(axis(&x), axis(&y))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(INK.mix(0.4))
        .label_style(font(SMALL))
        .axis_desc_style(font(NORMAL))
        .x_desc(across)
        .y_desc(up)
        .x_label_formatter(&|tick| short(*tick))
        .y_label_formatter(&|tick| short(*tick))
        .draw()?;
    Ok(chart)
}

/// Symbol or line in a legend.
enum Mark {
    Dot(RGBColor),
    Ring(RGBColor),
    Cross(RGBColor),
    Line,
    Dashes,
    Patch(RGBColor),
}

/// Draws a legend from left to right, in several lines if necessary; returns the position of the last line.
fn legend(area: &Area<'_>, start: (i32, i32), marks: &[(Mark, &str)]) -> Outcome<i32> {
    let (mut x, mut y) = start;
    for (mark, name) in marks {
        let style = font(SMALL).pos(at(HPos::Left));
        let width = 30 + area.estimate_text_size(name, &style)?.0 as i32 + 22;
        if x > start.0 && x + width > WIDTH as i32 {
            (x, y) = (start.0, y + 24);
        }
        let middle = (x + 10, y);
        match mark {
            Mark::Dot(color) => area.draw(&Circle::new(middle, 5, color.filled()))?,
            Mark::Ring(color) => area.draw(&Circle::new(middle, 5, color.stroke_width(2)))?,
            Mark::Cross(color) => area.draw(&Cross::new(middle, 5, color.stroke_width(2)))?,
            Mark::Line => area.draw(&PathElement::new([(x, y), (x + 20, y)], CERTIFIED.stroke_width(2)))?,
            Mark::Dashes => {
                for step in 0..3 {
                    let left = x + 8 * step;
                    area.draw(&PathElement::new([(left, y), (left + 4, y)], INK.mix(0.6).stroke_width(1)))?;
                }
            }
            Mark::Patch(color) => area.draw(&Rectangle::new([(x + 3, y - 7), (x + 17, y + 7)], color.filled()))?,
        }
        area.draw(&Text::new((*name).to_owned(), (x + 28, y), style))?;
        x += width;
    }
    Ok(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_some_ticks_and_not_many() {
        for (low, high) in [(1e-7, 0.9), (0.3, 2.0), (1.0, 40.0), (1e-30, 1e30)] {
            let range = around([low, high]);
            let ticks = ticks(&range);
            assert!((2..=9).contains(&ticks.len()), "{range:?}: {ticks:?}");
            assert!(ticks.iter().all(|tick| range.contains(tick)));
        }
        assert_eq!(around([f64::NAN, 0.0]), 0.1..1.0);
        assert_eq!(decades(1e-3, 1.0), 1e-3..1.0);
    }
}

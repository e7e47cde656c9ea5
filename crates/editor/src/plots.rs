//! Axes of plots: as many round ticks as are legible, none of them cut off by the edge.

use egui::Ui;
use egui_plot::{AxisHints, GridInput, GridMark, Plot};

/// Minimum distance between ticks, horizontally and vertically, in points.
const APART: [f64; 2] = [40.0, 24.0];
/// Width at the right end of an axis in which a label would be cut off, in points.
const END: f64 = 14.0;
/// Points per base step of an `egui_plot` grid.
const BASE: f64 = 8.0;

/// Returns the smallest of 1, 2, and 5 times a power of ten that is not below a number.
fn round_up(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|of| of * power).find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(power)
}

/// Returns the ticks of a horizontal (0) or vertical (1) axis; `point` is the value per point.
pub(crate) fn ticks((low, high): (f64, f64), point: f64, axis: usize) -> Vec<GridMark> {
    let step_size = round_up(point.abs() * APART[axis]);
    if !(low.is_finite() && high.is_finite() && step_size.is_finite() && step_size > 0.0) {
        return Vec::new();
    }
    let end = if axis == 0 { high - END * point.abs() } else { high };
    let [first, last] = [(low / step_size).ceil() as i64, (end / step_size).floor() as i64];
    (first..=last).take(1000).map(|index| GridMark { value: index as f64 * step_size, step_size }).collect()
}

/// Returns the ticks of a decimal logarithmic axis: powers of ten, and values in between if there is room.
fn decades((low, high): (f64, f64), point: f64) -> Vec<GridMark> {
    const FINE: [&[f64]; 4] =
        [&[1.0, 1.3, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.5, 8.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
    let apart = |of: &&&[f64]| {
        let next = of.iter().skip(1).chain(&[10.0]);
        let least = of.iter().zip(next).map(|(a, b)| (b / a).log10()).fold(f64::INFINITY, f64::min);
        least >= point.abs() * APART[0]
    };
    if !(low.is_finite() && high.is_finite()) {
        return Vec::new();
    }
    let of = FINE.iter().find(apart).unwrap_or(&FINE[3]);
    let all = (low.floor() as i64..=high.ceil() as i64).take(100);
    // The lines of powers of ten are the strongest ones. All of them get labels: their distance is already taken care of.
    let step = |index: usize| match index {
        0 => 1.0,
        _ => (of.get(index + 1).unwrap_or(&10.0) / of[index]).log10(),
    };
    all.flat_map(|decade| of.iter().enumerate().map(move |(index, of)| (index, decade as f64 + of.log10())))
        .map(|(index, value)| GridMark { value, step_size: step(index) })
        .filter(|mark| (low..=high - END * point.abs()).contains(&mark.value))
        .collect()
}

/// Formats a tick's value with the digits that its step needs.
pub(crate) fn numbered(value: f64, step: f64) -> String {
    let digits = (-step.log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    let value = if value.abs() < 0.5 * step { 0.0 } else { value };
    format!("{value:.digits$}")
}

/// Returns the height of a plot in all of the width: higher in a wide panel, where it would be a strip.
pub(crate) fn height(ui: &Ui, least: f32) -> f32 {
    (0.28 * ui.available_width()).clamp(least, 2.0 * least)
}

/// Returns the side of a square plot.
pub(crate) fn side(ui: &Ui, least: f32) -> f32 {
    height(ui, least).min(ui.available_width())
}

/// Returns the value per point.
fn point(input: &GridInput) -> f64 {
    input.base_step_size / BASE
}

/// Adds round ticks and axis labels to a plot.
pub(crate) fn even<'p>(plot: Plot<'p>, across: &str, up: &str) -> Plot<'p> {
    let number = |mark: GridMark, _: &_| numbered(mark.value, mark.step_size);
    // The wheel scrolls the panel, and nothing can lose the data.
    let plot = plot.allow_scroll(false).allow_drag(false).allow_zoom(false).allow_boxed_zoom(false);
    plot.custom_x_axes(vec![AxisHints::new_x().label(across).label_spacing(20.0..=30.0).formatter(number)])
        .custom_y_axes(vec![AxisHints::new_y().label(up).label_spacing(14.0..=22.0).formatter(number)])
        .x_grid_spacer(|input| ticks(input.bounds, point(&input), 0))
        .y_grid_spacer(|input| ticks(input.bounds, point(&input), 1))
}

/// Like [`even`], with a horizontal axis of decimal logarithms.
pub(crate) fn logarithmic<'p>(plot: Plot<'p>, across: &str, up: &str) -> Plot<'p> {
    let number = |mark: GridMark, _: &_| ((10f64.powf(mark.value) * 1e4).round() / 1e4).to_string();
    even(plot, across, up)
        .custom_x_axes(vec![AxisHints::new_x().label(across).label_spacing(20.0..=30.0).formatter(number)])
        .x_grid_spacer(|input| decades(input.bounds, point(&input)))
}

/// Like [`even`], for a view from above: labels of the vertical axis increase downward, as Z does.
pub(crate) fn above<'p>(plot: Plot<'p>, across: &str, up: &str) -> Plot<'p> {
    let down = |mark: GridMark, _: &_| numbered(-mark.value, mark.step_size);
    even(plot, across, up).custom_y_axes(vec![AxisHints::new_y().label(up).label_spacing(14.0..=22.0).formatter(down)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wherever_there_is_room_at_least_two_ticks_are_numbered() {
        for (axis, points) in [(0, 180.0), (1, 100.0)] {
            for high in [0.0013, 0.02, 0.9, 1.0, 3.7, 24.0, 100.0, 5123.0] {
                let all = ticks((-0.04 * high, high), 1.04 * high / points, axis);
                assert!(all.len() >= 2, "{high} on {points}: {all:?}");
                let mut texts: Vec<String> = all.iter().map(|tick| numbered(tick.value, tick.step_size)).collect();
                texts.dedup();
                assert_eq!(texts.len(), all.len(), "{texts:?}");
                let end = all.last().unwrap().value;
                assert!(axis == 1 || end <= high - END * 1.04 * high / points, "{end} would be cut");
            }
        }
        assert_eq!(numbered(0.5, 0.5), "0.5");
        assert_eq!(numbered(-0.0, 20.0), "0");
    }

    #[test]
    fn lengths_are_numbered_within_a_decade_as_over_many() {
        for (low, high) in [(0.3, 0.7), (0.0, 1.0), (-1.0, 2.0), (-3.0, 4.0)] {
            let all = decades((low, high), (high - low) / 200.0);
            assert!(all.len() >= 2, "{low} to {high}: {all:?}");
            assert!(all.windows(2).all(|two| two[1].value > two[0].value));
            let is_power = |mark: &GridMark| mark.value.fract().abs() < 1e-9;
            assert!(all.iter().all(|mark| (mark.step_size == 1.0) == is_power(mark)), "{all:?}");
        }
    }
}

//! What f32 loses, step by step: a table, and a plot with a panel for each thing that changes.

use super::map::{Area, FONT, INK, PAPER, picture};
use crate::files::OverwriteOptions;
use crate::shell::wrap;
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use trochoid::{StepErrorGroup, StepErrors};

const WIDTH: usize = 1500;
const HEIGHT: usize = 1000;
/// Height of a panel's title, and of a line of its legend, in pixels.
const TITLE: i32 = 34;
const LINE: i32 = 25;
/// Lines of a legend.
const LINES: usize = 5;
/// Share at the lower end of the plot; smaller errors are drawn there.
const LEAST: f64 = 1e-9;
/// Widths of the columns of names and numbers.
const NAME: usize = 30;
const NUMBER: usize = 9;
/// Most columns of numbers.
const COLUMNS: usize = 7;

const COLORS: [RGBColor; LINES] = [
    RGBColor(24, 84, 128),
    RGBColor(190, 80, 30),
    RGBColor(60, 130, 70),
    RGBColor(130, 60, 130),
    RGBColor(110, 100, 60),
];

/// Formats the table, at most 100 columns wide.
pub(super) fn table(errors: &StepErrors) -> String {
    let is_shown = |index: &usize| {
        let steps = errors.steps[*index];
        *index + 1 == errors.steps.len() || (steps >= 10 && 10_u64.pow(steps.ilog10()) == steps)
    };
    let mut shown: Vec<usize> = (0..errors.steps.len()).filter(is_shown).collect();
    shown.drain(..shown.len().saturating_sub(COLUMNS - 1));
    let mut text = wrap(&format!("Errors of f32 beside f64, {}:", errors.note), 2);
    let _ = write!(text, "\n  {:NAME$}", "after steps");
    shown.iter().for_each(|index| _ = write!(text, "{:>NUMBER$}", errors.steps[*index]));
    let _ = writeln!(text, "{:>NUMBER$}", "f64");
    for StepErrorGroup { name, rows } in &errors.groups {
        let _ = writeln!(text, "  {name}");
        for row in rows {
            let _ = write!(text, "    {:width$}", row.name, width = NAME - 2);
            shown.iter().for_each(|index| _ = write!(text, "{:>NUMBER$.1e}", row.errors[*index]));
            let _ = writeln!(text, "{:>NUMBER$.0e}", row.doubt);
        }
    }
    text.push_str(&wrap(
        "Under f64 stands how far rounding may have carried the f64 run itself after the last step.",
        2,
    ));
    text
}

/// Writes the plot as PNG, creating missing folders.
///
/// # Errors
/// The plot cannot be laid out or written.
pub(super) fn write(
    path: &Path,
    over: OverwriteOptions,
    name: &str,
    errors: &StepErrors,
) -> Result<(), Box<dyn Error>> {
    picture(path, over, [WIDTH, HEIGHT], |area| draw(area, name, errors))
}

fn draw(area: &Area<'_>, name: &str, errors: &StepErrors) -> Result<(), Box<dyn Error>> {
    let font = |size: i32| (FONT, size).into_font().color(&INK);
    area.fill(&PAPER)?;
    let (title, panels) = area.split_vertically(84);
    title.draw(&Text::new(format!("{name}: what 32-bit floats lose, beside 64-bit floats"), (24, 14), font(28)))?;
    title.draw(&Text::new(errors.note.clone(), (24, 52), font(19)))?;
    for (group, panel) in errors.groups.iter().zip(panels.split_evenly((2, 3))) {
        plot(&panel, group, errors)?;
    }
    Ok(())
}

fn plot(panel: &Area<'_>, group: &StepErrorGroup, errors: &StepErrors) -> Result<(), Box<dyn Error>> {
    let font = |size: i32| (FONT, size).into_font().color(&INK);
    let (legend, sub) = panel.split_vertically(TITLE + LINE * LINES as i32);
    legend.draw(&Text::new(group.name, (24, 6), font(22)))?;
    for (index, (row, color)) in group.rows.iter().zip(COLORS).enumerate() {
        let y = TITLE + LINE * index as i32 + LINE / 2;
        legend.draw(&PathElement::new([(28, y), (62, y)], color.stroke_width(3)))?;
        legend.draw(&Text::new(row.name.clone(), (72, y - 5), font(18)))?;
    }
    let all = group.rows.iter().flat_map(|row| &row.errors).copied();
    let most = all.fold(1e-6_f64, f64::max);
    let first = errors.steps.first().map_or(1.0, |steps| *steps as f64);
    let last = errors.steps.last().map_or(10.0, |steps| *steps as f64).max(2.0 * first);
    let mut chart = ChartBuilder::on(&sub)
        .margin_left(16)
        .margin_right(30)
        .margin_top(8)
        .x_label_area_size(60)
        .y_label_area_size(84)
        .build_cartesian_2d((first..last).log_scale(), (LEAST..most * 4.0).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.18))
        .axis_style(INK)
        .label_style(font(16))
        .axis_desc_style(font(19))
        .x_desc("steps from rest, as in a preroll")
        .y_desc("error")
        .x_labels(6)
        .y_labels(8)
        .x_label_formatter(&|steps| if *steps < 1e5 { format!("{steps:.0}") } else { format!("{steps:.0e}") })
        .y_label_formatter(&|error| format!("{error:.0e}"))
        .draw()?;
    for (row, color) in group.rows.iter().zip(COLORS) {
        let points = errors.steps.iter().zip(&row.errors).map(|(steps, error)| (*steps as f64, error.max(LEAST)));
        chart.draw_series(LineSeries::new(points, color.stroke_width(3)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::StepErrorRow;

    fn errors() -> StepErrors {
        let row = |name: &str, by: f64| StepErrorRow {
            name: name.into(),
            errors: [1.0, 2.0, 5.0, 10.0, 100.0, 1000.0, 1500.0].map(|steps| by * steps).into(),
            doubt: 1e-14,
        };
        let group = |name| StepErrorGroup { name, rows: vec![row("one", 1e-8), row("c1 = 1 - 1e-4, c2 = 9e-5", 0.0)] };
        StepErrors {
            steps: vec![1, 2, 5, 10, 100, 1000, 1500],
            groups: vec![group("mode"), group("damping")],
            note: "n".into(),
        }
    }

    #[test]
    fn tables_show_powers_of_ten_and_the_end() {
        let text = table(&errors());
        assert!(text.contains("       10      100     1000     1500      f64"), "{text}");
        assert!(text.contains("  1.0e-7   1.0e-6   1.0e-5   1.5e-5    1e-14"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    }

    #[test]
    fn a_plot_shows_what_it_is_given() {
        let folder = tempfile::tempdir().unwrap();
        let drawn = |errors: &StepErrors, name: &str| {
            let path = folder.path().join(name);
            write(&path, OverwriteOptions::default(), "sea", errors).unwrap();
            std::fs::read(path).unwrap()
        };
        let (all, mut less) = (errors(), errors());
        less.groups[1].rows[0].errors[3] *= 10.0;
        assert_ne!(drawn(&all, "all.png"), drawn(&less, "less.png"));
        let info = trochoid::io::info(folder.path().join("all.png"), &trochoid::io::Limits::default()).unwrap();
        assert_eq!((info.parts[0].data.width(), info.parts[0].data.height()), (WIDTH, HEIGHT));
    }
}

//! The stability map over two coefficients: growth of the sea at each point, the stable region, and the node's own
//! point.

use crate::files::OverwriteOptions;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;
use std::path::Path;
use trochoid::io::{PngImage, Samples, write_png8};
use trochoid::{Form, StabilityMap, marks};

const WIDTH: usize = 1200;
const HEIGHT: usize = 1000;
pub(super) const FONT: &str = "labels";
/// Growth per step at the upper end of the scale.
const MOST: f64 = 2.5;

pub(super) const INK: RGBColor = RGBColor(24, 32, 44);
pub(super) const PAPER: RGBColor = RGBColor(250, 248, 243);

/// Returns the color of a growth: blue for decay, paler the slower; warm for growth, darker the faster.
fn color(growth: f64) -> RGBColor {
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| {
        let [r, g, b] = [0, 1, 2].map(|i| (a[i] + (b[i] - a[i]) * t).round() as u8);
        RGBColor(r, g, b)
    };
    if growth <= 1.0 {
        mix([24.0, 84.0, 128.0], [214.0, 234.0, 240.0], growth * growth)
    } else {
        mix([250.0, 214.0, 160.0], [140.0, 36.0, 30.0], ((growth - 1.0) / (MOST - 1.0)).min(1.0))
    }
}

/// Writes the map as PNG, creating missing folders.
///
/// # Errors
/// The plot cannot be laid out or written.
pub(super) fn write(path: &Path, over: OverwriteOptions, name: &str, map: &StabilityMap) -> Result<(), Box<dyn Error>> {
    picture(path, over, [WIDTH, HEIGHT], |area| draw(area, name, map))
}

/// Draws something and writes it as PNG, creating missing folders.
///
/// # Errors
/// It cannot be laid out or written.
pub(super) fn picture(
    path: &Path,
    over: OverwriteOptions,
    [width, height]: [usize; 2],
    draw: impl Fn(&Area<'_>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let pixels = pixels([width, height], draw)?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let channel =
        |channel: usize| -> Vec<f32> { pixels.chunks_exact(3).map(|p| f32::from(p[channel]) / 255.0).collect() };
    let channels = [0, 1, 2].map(channel);
    let channels = channels.each_ref().map(|channel| Samples::contiguous(channel));
    let image = PngImage { metadata: marks(Form::Map), ..PngImage::new(width as u32, height as u32, channels) };
    Ok(write_png8(over.target(path, Form::Map), &image)?)
}

/// Draws something; returns interleaved R, G and B.
fn pixels(
    [width, height]: [usize; 2],
    draw: impl Fn(&Area<'_>) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<u8>, Box<dyn Error>> {
    // The font is part of the program, so that every machine draws the same labels.
    register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font cannot be read")?;
    let mut pixels = vec![0; width * height * 3];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, (width as u32, height as u32)).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    Ok(pixels)
}

/// Draws the map.
fn draw(area: &Area<'_>, name: &str, map: &StabilityMap) -> Result<(), Box<dyn Error>> {
    area.fill(&PAPER)?;
    let (left, right) = area.split_horizontally(WIDTH as u32 - 170);
    plane(&left, name, map)?;
    scale(&right)
}

pub(super) type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

fn plane(area: &Area<'_>, name: &str, map: &StabilityMap) -> Result<(), Box<dyn Error>> {
    let [[left, right], [low, high]] = map.ranges;
    let (title, sub) = area.split_vertically(84);
    let font = |size: i32| (FONT, size).into_font().color(&INK);
    title.draw(&Text::new(
        format!("{name}: growth per step over {} and {}", map.axes[0], map.axes[1]),
        (24, 16),
        font(28),
    ))?;
    title.draw(&Text::new(map.note.clone(), (24, 54), font(19)))?;
    let mut chart = ChartBuilder::on(&sub)
        .margin(16)
        .x_label_area_size(58)
        .y_label_area_size(74)
        .build_cartesian_2d(left..right, low..high)?;
    chart.draw_series((0..map.growth.len()).map(|cell| {
        let step = [(right - left) / map.size[0] as f64, (high - low) / map.size[1] as f64];
        let (column, row) = ((cell % map.size[0]) as f64, (cell / map.size[0]) as f64);
        let corner = [left + column * step[0], low + row * step[1]];
        Rectangle::new(
            [(corner[0], corner[1]), (corner[0] + step[0], corner[1] + step[1])],
            color(map.growth[cell]).filled(),
        )
    }))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.18))
        .axis_style(INK)
        .label_style(font(19))
        .axis_desc_style(font(24))
        .x_desc(map.axes[0])
        .y_desc(map.axes[1])
        .x_labels(13)
        .y_labels(15)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .draw()?;
    let around = map.region.iter().chain(map.region.first()).map(|corner| (corner[0], corner[1]));
    chart.draw_series(LineSeries::new(around, INK.stroke_width(3)))?;
    for (at, growth) in &map.measured {
        chart.draw_series([
            Circle::new((at[0], at[1]), 7, color(*growth).filled()),
            Circle::new((at[0], at[1]), 7, INK.mix(0.55).stroke_width(1)),
        ])?;
    }
    let at = (map.point[0], map.point[1]);
    chart.draw_series([
        Circle::new(at, 9, PAPER.filled()),
        Circle::new(at, 9, INK.stroke_width(3)),
        Circle::new(at, 4, INK.filled()),
    ])?;
    let label = format!("({}, {})", map.point[0], map.point[1]);
    chart.draw_series([EmptyElement::at(at) + Text::new(label, (16, -26), font(22))])?;
    Ok(())
}

/// Formats a tick with one decimal, and without −0.
fn tick(value: &f64) -> String {
    format!("{:.1}", (value * 10.0).round() / 10.0 + 0.0)
}

/// Draws the scale of the colors.
fn scale(area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let (_, sub) = area.split_vertically(84);
    let font = |size: i32| (FONT, size).into_font().color(&INK);
    let mut chart = ChartBuilder::on(&sub)
        .margin_top(16)
        .margin_right(20)
        .margin_bottom(74)
        .margin_left(0)
        .y_label_area_size(96)
        .build_cartesian_2d(0.0..1.0, 0.0..MOST)?;
    let steps = 500;
    chart.draw_series((0..steps).map(|step| {
        let at = |step: i32| MOST * f64::from(step) / f64::from(steps);
        Rectangle::new([(0.0, at(step)), (1.0, at(step + 1))], color(at(step) + 0.5 * at(1)).filled())
    }))?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(font(19))
        .axis_desc_style(font(22))
        .y_desc("growth per step: below 1, waves die away")
        .y_labels(11)
        .draw()?;
    chart.draw_series(LineSeries::new([(0.0, 1.0), (1.0, 1.0)], INK.stroke_width(3)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_shows_what_it_is_given() {
        let map = StabilityMap {
            axes: ["c1", "c2"],
            ranges: [[-1.2, 1.2], [-1.4, 1.4]],
            size: [2, 1],
            growth: vec![0.5, 2.0],
            region: vec![[-0.3, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]],
            point: [0.3, 0.65],
            measured: vec![([0.5, 0.0], 0.1)],
            note: "8 × 8 cells".into(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("maps/map.png");
        write(&path, OverwriteOptions::default(), "sea", &map).unwrap();
        let info = trochoid::io::info(&path, &trochoid::io::Limits::default()).unwrap();
        assert_eq!((info.parts[0].data.width(), info.parts[0].data.height()), (WIDTH, HEIGHT));
        let around = |map: &StabilityMap| pixels([WIDTH, HEIGHT], |area| draw(area, "sea", map)).unwrap();
        assert_ne!(around(&map), around(&StabilityMap { point: [0.0, 0.0], ..map.clone() }));
        assert_ne!(around(&map), around(&StabilityMap { growth: vec![0.5, 0.6], ..map.clone() }));
        assert_ne!(around(&map), around(&StabilityMap { measured: Vec::new(), ..map.clone() }));
    }

    #[test]
    fn colors_tell_growth_from_decay() {
        let warm = |growth: f64| color(growth).0 > color(growth).2;
        assert!(!warm(0.0) && !warm(0.9999) && warm(1.0001) && warm(1e9));
    }
}

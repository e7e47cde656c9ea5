//! The picture and maps of its error bounds, as PNG embedded in the page.

use super::plots::decades;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use std::error::Error;
use std::ops::Range;
use trochoid::accuracy::Rung;
use trochoid::io::{PngImage, Samples, encode_png8};
use trochoid::{Kind, Picture, WorkingSpace};

/// Maximum number of decades that a map shows; smaller bounds have the color of the lowest.
const DECADES: i32 = 8;

/// Encodes the picture for display as a data URL; of several weights, the first.
pub(super) fn shown(picture: &Picture, space: WorkingSpace) -> Result<String, Box<dyn Error>> {
    let color = picture.kind == Kind::Color;
    let channel = |channel: usize| picture.planes[if color { channel } else { 0 }].samples();
    let [red, green, blue] = [0, 1, 2].map(channel);
    let pixels = red.iter().zip(green).zip(blue).map(|((r, g), b)| {
        let value = [r, g, b].map(|value| f64::from(*value));
        let shown = if color { space.to_display(value) } else { value };
        // NaN is black, and counted in the table.
        shown.map(|value| if value.is_nan() { 0.0 } else { value as f32 })
    });
    encode(&pixels.collect::<Vec<_>>(), picture)
}

/// Returns the range of all maps in whole decades; `None` if no finite bound is above 0.
pub(super) fn scale<'r>(rungs: impl IntoIterator<Item = &'r Rung>) -> Option<Range<f64>> {
    let known = |bound: &&f32| bound.is_finite() && **bound > 0.0;
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for bound in rungs.into_iter().flat_map(|rung| rung.map.iter().filter(known)) {
        low = low.min(f64::from(*bound));
        high = high.max(f64::from(*bound));
    }
    (high > 0.0).then(|| {
        let decades = decades(low, high);
        decades.start.max(decades.end * 0.1_f64.powi(DECADES))..decades.end
    })
}

/// Encodes the error map of a rung as a data URL, with colors on a logarithmic scale.
pub(super) fn map(rung: &Rung, scale: &Range<f64>) -> Result<String, Box<dyn Error>> {
    let pixels = rung.map.iter().map(|bound| {
        let RGBColor(r, g, b) = color(f64::from(*bound), scale);
        [r, g, b].map(|value| f32::from(value) / 255.0)
    });
    encode(&pixels.collect::<Vec<_>>(), &rung.picture)
}

/// Returns the color of a bound: Viridis, in which equal steps look equal.
pub(super) fn color(bound: f64, scale: &Range<f64>) -> RGBColor {
    let place = (bound / scale.start).ln() / (scale.end / scale.start).ln();
    ViridisRGB.get_color(if place.is_nan() { 1.0 } else { place.clamp(0.0, 1.0) as f32 })
}

fn encode(pixels: &[[f32; 3]], like: &Picture) -> Result<String, Box<dyn Error>> {
    let window = like.planes[0].window();
    data_url(pixels, window.width(), window.height())
}

/// Encodes displayed colors as a data URL, row by row.
///
/// # Errors
/// They are not as many as the width and the height say.
pub(crate) fn data_url(pixels: &[[f32; 3]], width: usize, height: usize) -> Result<String, Box<dyn Error>> {
    let image = PngImage::new(width as u32, height as u32, Samples::rgb(pixels));
    let png = encode_png8(&PngImage { clamp: true, ..image })?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_brighten_with_the_bound_and_stop_at_the_ends() {
        let light = |bound: f64| {
            let RGBColor(r, g, b) = color(bound, &(1e-6..1.0));
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let lights = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0].map(light);
        assert!(lights.is_sorted(), "{lights:?}");
        assert_eq!((light(0.0), light(f64::INFINITY)), (lights[0], lights[6]));
    }
}

//! OKLab, in which distances are about those that one sees (Ottosson, *A perceptual color space for image processing*,
//! 2020), and its polar form OKLCh: lightness, chroma and hue.

use crate::{srgb_decode, srgb_encode};

/// Responses of cones to linear sRGB.
pub const CONES: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];
/// OKLab of the cube roots of the cones' responses.
pub const OPPONENTS: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];
/// The ways back.
const ROOTS: [[f64; 3]; 3] = [
    [1.0, 0.396_337_777_4, 0.215_803_757_3],
    [1.0, -0.105_561_345_8, -0.063_854_172_8],
    [1.0, -0.089_484_177_5, -1.291_485_548_0],
];
const LIGHT: [[f64; 3]; 3] = [
    [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
    [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
    [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
];

fn times(matrix: &[[f64; 3]; 3], by: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| a * by[0] + b * by[1] + c * by[2])
}

/// Converts a displayed color, sRGB from 0 to 1, to OKLab: lightness from 0 to 1, then green to red and blue to yellow.
///
/// ```
/// let [lightness, a, b] = trochoid_image::oklab([1.0, 1.0, 1.0]);
/// assert!((lightness - 1.0).abs() < 1e-6 && a.abs() < 1e-6 && b.abs() < 1e-6);
/// ```
pub fn oklab(color: [f64; 3]) -> [f64; 3] {
    times(&OPPONENTS, times(&CONES, color.map(srgb_decode)).map(libm::cbrt))
}

/// Converts a displayed color to OKLCh: lightness from 0 to 1, chroma ≥ 0, and hue in degrees from 0 to 360. Grays have the
/// hue 0.
pub fn oklch(color: [f64; 3]) -> [f64; 3] {
    let [lightness, a, b] = oklab(color);
    let chroma = libm::hypot(a, b);
    let hue = if chroma < 1e-4 { 0.0 } else { libm::atan2(b, a).to_degrees().rem_euclid(360.0) };
    [lightness, chroma, hue]
}

/// Converts OKLCh to a displayed color. A display cannot show channels outside of 0 to 1.
fn from_oklch([lightness, chroma, hue]: [f64; 3]) -> [f64; 3] {
    let hue = hue.to_radians();
    let roots = times(&ROOTS, [lightness, chroma * libm::cos(hue), chroma * libm::sin(hue)]);
    times(&LIGHT, roots.map(|root| root * root * root)).map(srgb_encode)
}

/// Distance from 0 to 1 that a channel may have, for rounding.
const SLACK: f64 = 1e-4;

/// Returns the displayed color of OKLCh that an sRGB display can show: that of the same lightness and hue with the largest
/// chroma up to the given one; and that chroma.
///
/// ```
/// let (color, chroma) = trochoid_image::shown_oklch([0.7, 0.05, 30.0]);
/// assert!(chroma == 0.05 && color.iter().all(|channel| (0.0..=1.0).contains(channel)));
/// assert!(trochoid_image::shown_oklch([0.7, 0.5, 30.0]).1 < 0.3);
/// ```
pub fn shown_oklch([lightness, chroma, hue]: [f64; 3]) -> ([f64; 3], f64) {
    let lightness = lightness.clamp(0.0, 1.0);
    let shown = |chroma: f64| {
        let color = from_oklch([lightness, chroma, hue]);
        let fits = color.iter().all(|channel| (-SLACK..=1.0 + SLACK).contains(channel));
        (color.map(|channel| channel.clamp(0.0, 1.0)), fits)
    };
    let chroma = chroma.max(0.0);
    if let (color, true) = shown(chroma) {
        return (color, chroma);
    }
    let (mut low, mut high) = (0.0, chroma);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if shown(middle).1 {
            low = middle;
        } else {
            high = middle;
        }
    }
    (shown(low).0, low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_come_back() {
        for step in 0..=1000_u32 {
            let color = [step % 10, step / 10 % 10, step / 100].map(|part| (f64::from(part) / 9.0).min(1.0));
            let lch = oklch(color);
            let (back, chroma) = shown_oklch(lch);
            assert!((chroma - lch[1]).abs() < 1e-3, "{color:?}: {chroma} of {lch:?}");
            assert!(back.iter().zip(color).all(|(a, b)| (a - b).abs() < 1.0 / 512.0), "{color:?}: {back:?}");
        }
    }

    #[test]
    fn what_no_display_shows_loses_chroma_and_keeps_its_hue() {
        for hue in (0..360).step_by(15).map(f64::from) {
            let (color, chroma) = shown_oklch([0.6, 0.4, hue]);
            assert!(chroma < 0.4 && chroma > 0.05, "{hue}: {chroma}");
            let [lightness, _, back] = oklch(color);
            let turned = (back - hue).rem_euclid(360.0);
            assert!(turned.min(360.0 - turned) < 1.0 && (lightness - 0.6).abs() < 0.01, "{hue}: {back}");
        }
        assert!(shown_oklch([0.0, 0.3, 120.0]).1 < 0.02, "black has no chroma");
    }
}

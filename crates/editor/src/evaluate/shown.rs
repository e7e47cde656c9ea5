//! Conversion of pictures to screen pixels. None of its settings are stored in the document.

use crate::transform::{CubeFile, Takes, Transform};
use rayon::prelude::*;
use std::sync::{Arc, LazyLock};
use trochoid::{Kind, Picture, Plane, WorkingSpace, srgb_decode, srgb_encode};

/// Channels of a picture to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Channel {
    /// Colors as colors; the first channel of other kinds.
    #[default]
    All,
    /// A single channel.
    One(usize),
    /// Luminance of a color.
    Luminance,
}

/// Settings that map values to brightness.
#[derive(Clone, Debug, PartialEq)]
pub struct Display {
    /// Channels to show.
    pub channel: Channel,
    /// Exposure in stops.
    pub exposure: f32,
    /// Display gamma: midtones are darker below 1 and brighter above 1.
    pub gamma: f32,
    /// Values of a Field shown as black and white; `None` uses the range of its values. Ignored for colors.
    pub range: Option<[f32; 2]>,
    /// Whether grayscale displays use false colors.
    pub false_color: bool,
    /// What is made of the light of colors.
    pub transform: Transform,
}

impl Default for Display {
    fn default() -> Self {
        let (channel, transform) = (Channel::All, Transform::Srgb);
        Self { channel, exposure: 0.0, gamma: 1.0, range: None, false_color: false, transform }
    }
}

/// A picture converted for the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Screen {
    /// Width and height, in pixels.
    pub size: [usize; 2],
    /// sRGB, four bytes per pixel.
    pub pixels: Vec<u8>,
}

/// Returns the smallest and largest finite value of a plane; 0 and 1 if there are none.
pub fn range_of(plane: &Plane) -> [f32; 2] {
    let chunks = plane.samples().par_chunks(1 << 16);
    let ends = chunks.map(|chunk| {
        chunk
            .iter()
            .filter(|value| value.is_finite())
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
    });
    let [low, high] = ends.reduce(|| [f32::INFINITY, f32::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    match low < high {
        true => [low, high],
        false if low == high => [low - 0.5, low + 0.5],
        false => [0.0, 1.0],
    }
}

/// Returns the range of values from black to white, which the display may override.
pub fn range(picture: &Picture, display: &Display) -> [f32; 2] {
    match (display.range, picture.kind) {
        (_, Kind::Color) => [0.0, 1.0],
        (Some(range), _) => range,
        (None, Kind::Weights(_)) => [0.0, 1.0],
        (None, _) => {
            let channel = if let Channel::One(channel) = display.channel { channel } else { 0 };
            picture.planes.get(channel.min(picture.planes.len().saturating_sub(1))).map_or([0.0, 1.0], range_of)
        }
    }
}

/// Converts a picture for the screen.
pub fn screen(picture: &Picture, space: WorkingSpace, display: &Display) -> Screen {
    let Some(first) = picture.planes.first() else { return Screen { size: [0, 0], pixels: Vec::new() } };
    let window = first.window();
    let size = [window.width(), window.height()];
    let mut pixels = vec![255_u8; 4 * size[0] * size[1]];
    let rows = pixels.par_chunks_mut(4 * size[0].max(1)).enumerate();
    let planes: Vec<&[f32]> = picture.planes.iter().map(Plane::samples).collect();
    if picture.kind == Kind::Color {
        let encode = Encoder::new(space, display);
        rows.for_each(|(y, row)| {
            let own = y * size[0]..(y + 1) * size[0];
            encode.row([0, 1, 2].map(|channel| &planes[channel][own.clone()]), row);
        });
    } else {
        let [low, high] = range(picture, display);
        let index = if let Channel::One(channel) = display.channel { channel } else { 0 };
        let plane = planes[index.min(planes.len() - 1)];
        let (bias, gain) = (low, if high > low { 1.0 / (high - low) } else { 1.0 });
        let shade = Shade::new(display);
        rows.for_each(|(y, row)| {
            let start = y * size[0];
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                pixel[..3].copy_from_slice(&shade.of((plane[start + x] - bias) * gain));
            }
        });
    }
    Screen { size, pixels }
}

/// Converts colors of the working space to the screen, with a look-up table over exposed channels.
pub(super) struct Encoder {
    space: WorkingSpace,
    channel: Channel,
    false_color: bool,
    /// Factor applied to light before the table; 1 if the table is indexed by encoded values.
    gain: f32,
    /// Table of colors through which light goes first, and the factor before it.
    cube: Option<(Arc<CubeFile>, f32)>,
    table: Vec<u8>,
    /// Decoding table from encoded values to light; empty if the working space is linear.
    light: Vec<f32>,
}

/// Number of entries of tables over [0, 1], a power of two.
pub(super) const TABLE: usize = 1 << 12;
/// Pixels that are converted at once.
const PIECE: usize = 64;
/// Luminance weights of linear sRGB.
pub(super) const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Smallest light whose encoding has each place of the table, or one beyond.
pub(super) static STEPS: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let first = |sought: usize| {
        let near = srgb_decode((sought as f64 - 0.5) / (TABLE - 1) as f64) as f32;
        let (mut low, mut high) = ((near * 0.999).to_bits(), (near * 1.001).to_bits());
        while low < high {
            let between = low + (high - low) / 2;
            if place(encoded(f32::from_bits(between))) < sought { low = between + 1 } else { high = between }
        }
        f32::from_bits(low)
    };
    std::iter::once(0.0).chain((1..TABLE).map(first)).collect()
});

/// Returns the place of a value in a table over [0, 1].
fn place(value: f32) -> usize {
    (value.clamp(0.0, 1.0) * (TABLE - 1) as f32 + 0.5) as usize
}

/// Encodes light for the screen.
fn encoded(light: f32) -> f32 {
    srgb_encode(f64::from(light)) as f32
}

impl Encoder {
    pub(super) fn new(space: WorkingSpace, display: &Display) -> Self {
        let exposed = f64::from(display.exposure).exp2();
        let gamma = 1.0 / f64::from(display.gamma).max(1e-3);
        let encoded = space == WorkingSpace::Srgb;
        let at = |index: usize| index as f64 / (TABLE - 1) as f64;
        // Exposure multiplies light, so encoded values are decoded first.
        let light = |index: usize| if encoded { srgb_decode(at(index)) * exposed } else { at(index) };
        let entry = |index: usize| {
            let shown = match &display.transform {
                Transform::Srgb => srgb_encode(light(index).clamp(0.0, 1.0)),
                Transform::Bt1886 => light(index).clamp(0.0, 1.0).powf(1.0 / 2.4),
                Transform::Cube(_) => at(index),
            };
            (shown.powf(gamma).clamp(0.0, 1.0) * 255.0).round() as u8
        };
        let cube = match &display.transform {
            Transform::Cube(file) => Some((file.clone(), exposed as f32)),
            _ => None,
        };
        let light = (0..TABLE).filter(|_| encoded).map(|index| srgb_decode(at(index)) as f32);
        Self {
            space,
            channel: display.channel,
            false_color: display.false_color,
            gain: if encoded || cube.is_some() { 1.0 } else { exposed as f32 },
            cube,
            table: (0..TABLE).map(entry).collect(),
            light: light.collect(),
        }
    }

    /// Converts a pixel: the whole color, or the chosen channel as an equally bright gray.
    fn pixel(&self, color: [f32; 3]) -> [u8; 3] {
        if color.iter().any(|value| value.is_nan()) {
            return NAN;
        }
        if let Some((file, exposed)) = &self.cube {
            return self.through(file, *exposed, color);
        }
        let gray = match self.channel {
            Channel::All => return self.screen(color).map(|value| self.byte(value)),
            // Grays of the working space are grays of the screen.
            Channel::One(channel) => color[channel.min(2)],
            // Places of encoded luminance are searched for: to encode the light of each pixel takes a power.
            Channel::Luminance if !self.light.is_empty() => {
                let light = self.light_of(color);
                return self.gray(self.table[STEPS.partition_point(|step| *step <= light).saturating_sub(1)]);
            }
            Channel::Luminance => self.light_of(self.screen(color)),
        };
        self.gray(self.byte(gray))
    }

    /// Returns the pixel of a gray.
    fn gray(&self, byte: u8) -> [u8; 3] {
        if self.false_color { turbo(f32::from(byte) / 255.0) } else { [byte; 3] }
    }

    /// Converts a pixel by a table of colors.
    fn through(&self, file: &CubeFile, exposed: f32, color: [f32; 3]) -> [u8; 3] {
        let color = match self.channel {
            Channel::All => color,
            Channel::One(channel) => [color[channel.min(2)]; 3],
            // The gray in the working space is the same as on the screen.
            Channel::Luminance => [self.luminance(self.screen(color)); 3],
        };
        let light = color.map(|value| if self.light.is_empty() { value } else { self.decoded(value) } * exposed);
        let taken = match file.takes {
            Takes::Light => light,
            Takes::Encoded => self.screen(light).map(|value| srgb_encode(f64::from(value.max(0.0))) as f32),
        };
        let shown = file.cube.of(taken).map(|value| self.byte(value));
        let is_false = self.false_color && self.channel != Channel::All;
        if is_false { turbo(f32::from(shown[1]) / 255.0) } else { shown }
    }

    /// Converts a row of pixels; of each in `out`, the last byte stays as it is.
    pub(super) fn row(&self, color: [&[f32]; 3], out: &mut [u8]) {
        if self.channel != Channel::All || self.space == WorkingSpace::AcesCg || self.cube.is_some() {
            for (x, pixel) in out.chunks_exact_mut(4).enumerate() {
                pixel[..3].copy_from_slice(&self.pixel(color.map(|channel| channel[x])));
            }
            return;
        }
        // In pieces whose places in the table are found by vector instructions.
        let mut places = [[0_u32; PIECE]; 3];
        for (piece, out) in out.chunks_mut(4 * PIECE).enumerate() {
            let count = out.len() / 4;
            let range = piece * PIECE..piece * PIECE + count;
            let mut is_number = true;
            for (places, channel) in places.iter_mut().zip(color) {
                for (place, value) in places.iter_mut().zip(&channel[range.clone()]) {
                    is_number &= !value.is_nan();
                    let scaled = (value * self.gain).clamp(0.0, 1.0) * (TABLE - 1) as f32 + 0.5;
                    *place = scaled as u32;
                }
            }
            for (x, pixel) in out.chunks_exact_mut(4).enumerate() {
                (0..3).for_each(|channel| pixel[channel] = self.table[places[channel][x] as usize & (TABLE - 1)]);
            }
            if !is_number {
                for (x, pixel) in out.chunks_exact_mut(4).enumerate() {
                    pixel[..3].copy_from_slice(&self.pixel(color.map(|channel| channel[range.start + x])));
                }
            }
        }
    }

    /// Converts a color to the screen's primaries, encoded if the working space is.
    fn screen(&self, color: [f32; 3]) -> [f32; 3] {
        match self.space {
            WorkingSpace::AcesCg => self.space.to_linear_srgb(color.map(f64::from)).map(|value| value as f32),
            _ => color,
        }
    }

    /// Returns the gray with the luminance of a color, encoded if the color is.
    fn luminance(&self, color: [f32; 3]) -> f32 {
        let light = self.light_of(color);
        if self.light.is_empty() { light } else { encoded(light) }
    }

    /// Returns the luminance of a color, as light.
    fn light_of(&self, color: [f32; 3]) -> f32 {
        let light = if self.light.is_empty() { color } else { color.map(|value| self.decoded(value)) };
        light.iter().zip(LUMINANCE).map(|(light, share)| light * share).sum()
    }

    /// Interpolates between table entries, so that encoding the result restores the value.
    fn decoded(&self, value: f32) -> f32 {
        let at = value.clamp(0.0, 1.0) * (TABLE - 1) as f32;
        let index = (at as usize).min(TABLE - 2);
        let (low, high) = (self.light[index], self.light[index + 1]);
        low + (at - index as f32) * (high - low)
    }

    fn byte(&self, value: f32) -> u8 {
        self.table[place(value * self.gain)]
    }
}

/// What a graphics card needs, to do the same.
#[cfg(feature = "gpu")]
impl Encoder {
    /// Whether light goes through a table of colors.
    pub(super) fn has_cube(&self) -> bool {
        self.cube.is_some()
    }

    /// Returns the factor before the table.
    pub(super) fn gain(&self) -> f32 {
        self.gain
    }

    /// Returns the light of encoded values, if colors are encoded.
    pub(super) fn light(&self) -> &[f32] {
        &self.light
    }

    /// Returns the pixels by place: of a channel as an equal gray, if colors are shown as colors.
    pub(super) fn shades(&self) -> Vec<[u8; 3]> {
        let shade = |byte: &u8| if self.channel == Channel::All { [*byte; 3] } else { self.gray(*byte) };
        self.table.iter().map(shade).collect()
    }
}

/// Conspicuous color for values that are not numbers.
const NAN: [u8; 3] = [255, 0, 255];

/// Maps numbers to gray or false colors, with a look-up table.
pub(super) struct Shade {
    pub(super) table: Vec<[u8; 3]>,
}

impl Shade {
    pub(super) fn new(display: &Display) -> Self {
        let gain = display.exposure.exp2();
        let table = (0..TABLE).map(|index| {
            let value = (index as f32 / (TABLE - 1) as f32 * gain).clamp(0.0, 1.0).powf(1.0 / display.gamma.max(1e-3));
            if display.false_color { turbo(value) } else { [(value * 255.0).round() as u8; 3] }
        });
        Self { table: table.collect() }
    }

    fn of(&self, value: f32) -> [u8; 3] {
        if value.is_nan() {
            return NAN;
        }
        self.table[place(value)]
    }
}

/// Returns a false color with evenly rising hue: the polynomial approximation of Mikhailov's Turbo.
///
/// Source: A. Mikhailov, *Turbo, An Improved Rainbow Colormap for Visualization*, 2019.
pub fn turbo(t: f32) -> [u8; 3] {
    let polynomial = |c: [f32; 6]| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let r = polynomial([0.135_721_4, 4.615_392_6, -42.660_32, 132.131_08, -152.942_4, 59.286_38]);
    let g = polynomial([0.091_402_61, 2.194_188_4, 4.842_966_6, -14.185_033, 4.277_298_6, 2.829_566]);
    let b = polynomial([0.106_673_3, 12.641_946, -60.582_05, 110.362_77, -89.903_11, 27.348_25]);
    [r, g, b].map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_encoded_light_are_found_without_encoding_it() {
        let found = |light: f32| STEPS.partition_point(|step| *step <= light).saturating_sub(1);
        assert!(STEPS.len() == TABLE && STEPS.is_sorted());
        let near = |step: &f32| [step.next_down(), *step, step.next_up(), step * 1.000_1];
        let others = (0..20_000).map(|at| at as f32 / 19_000.0);
        let mut count = 0;
        for light in STEPS.iter().flat_map(near).chain(others).filter(|light| *light >= 0.0) {
            assert_eq!(found(light), place(encoded(light)), "{light}");
            count += 1;
        }
        assert!(count > 36_000);
    }
}

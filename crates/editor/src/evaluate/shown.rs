//! How a picture is shown: what becomes of its values on the screen. Nothing of it is in the document.

use rayon::prelude::*;
use trochoid::{Kind, Picture, Plane, WorkingSpace, srgb_decode, srgb_encode};

/// Which of a picture's channels are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Channel {
    /// Colors as colors; of anything else the first channel.
    #[default]
    All,
    /// One channel alone.
    One(usize),
    /// The luminance of a color.
    Luminance,
}

/// How values become brightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Which channels.
    pub channel: Channel,
    /// Stops by which colors are brightened.
    pub exposure: f32,
    /// Exponent by which displayed values are darkened (below 1) or brightened (above 1) in their middle.
    pub gamma: f32,
    /// What is shown black and white of a Field; found from its values if `None`. Colors are shown as light, whatever
    /// this says.
    pub range: Option<[f32; 2]>,
    /// Whether what is shown as gray is shown in false colors.
    pub false_color: bool,
}

impl Default for Display {
    fn default() -> Self {
        Self { channel: Channel::All, exposure: 0.0, gamma: 1.0, range: None, false_color: false }
    }
}

/// A picture for the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Screen {
    /// Width and height.
    pub size: [usize; 2],
    /// sRGB, four bytes a pixel.
    pub pixels: Vec<u8>,
}

/// The least and greatest finite value of a plane; 0 and 1 where there is none.
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

/// The range in which a picture's values are shown, where the display does not say.
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

/// What is shown of a picture.
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
            let start = y * size[0];
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                let color = [planes[0][start + x], planes[1][start + x], planes[2][start + x]];
                pixel[..3].copy_from_slice(&encode.pixel(color));
            }
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

/// Colors of the working space as the screen shows them, by a table over what each channel is multiplied to.
struct Encoder {
    space: WorkingSpace,
    channel: Channel,
    false_color: bool,
    /// By which light is multiplied before the table; 1 where the table holds encoded values.
    gain: f32,
    table: Vec<u8>,
    /// The light of encoded values; empty where the working space is light.
    light: Vec<f32>,
}

/// Entries of tables over [0, 1].
const TABLE: usize = 1 << 12;
/// Shares of linear sRGB in luminance.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

impl Encoder {
    fn new(space: WorkingSpace, display: &Display) -> Self {
        let exposed = f64::from(display.exposure).exp2();
        let gamma = 1.0 / f64::from(display.gamma).max(1e-3);
        let encoded = space == WorkingSpace::Srgb;
        let at = |index: usize| index as f64 / (TABLE - 1) as f64;
        let entry = |index: usize| {
            // Light is what an exposure multiplies, so encoded values are decoded before.
            let light = if encoded { srgb_decode(at(index)) * exposed } else { at(index) };
            (srgb_encode(light.clamp(0.0, 1.0)).powf(gamma).clamp(0.0, 1.0) * 255.0).round() as u8
        };
        let light = (0..TABLE).filter(|_| encoded).map(|index| srgb_decode(at(index)) as f32);
        Self {
            space,
            channel: display.channel,
            false_color: display.false_color,
            gain: if encoded { 1.0 } else { exposed as f32 },
            table: (0..TABLE).map(entry).collect(),
            light: light.collect(),
        }
    }

    /// A pixel: all of a color, or what was chosen of it as gray that is as bright.
    fn pixel(&self, color: [f32; 3]) -> [u8; 3] {
        if color.iter().any(|value| value.is_nan()) {
            return NAN;
        }
        let gray = match self.channel {
            Channel::All => return self.screen(color).map(|value| self.byte(value)),
            // A gray of the working space is one of the screen.
            Channel::One(channel) => color[channel.min(2)],
            Channel::Luminance => self.luminance(self.screen(color)),
        };
        let byte = self.byte(gray);
        if self.false_color { turbo(f32::from(byte) / 255.0) } else { [byte; 3] }
    }

    /// A color in the screen's primaries, encoded where the working space is.
    fn screen(&self, color: [f32; 3]) -> [f32; 3] {
        match self.space {
            WorkingSpace::AcesCg => self.space.to_linear_srgb(color.map(f64::from)).map(|value| value as f32),
            _ => color,
        }
    }

    /// The gray of as much light, encoded where the color is.
    fn luminance(&self, color: [f32; 3]) -> f32 {
        let sum = |light: [f32; 3]| light.iter().zip(LUMINANCE).map(|(light, share)| light * share).sum::<f32>();
        if self.light.is_empty() {
            return sum(color);
        }
        srgb_encode(f64::from(sum(color.map(|value| self.decoded(value))))) as f32
    }

    /// Between two entries of the table, so that what is encoded again is what it was.
    fn decoded(&self, value: f32) -> f32 {
        let at = value.clamp(0.0, 1.0) * (TABLE - 1) as f32;
        let index = (at as usize).min(TABLE - 2);
        let (low, high) = (self.light[index], self.light[index + 1]);
        low + (at - index as f32) * (high - low)
    }

    fn byte(&self, value: f32) -> u8 {
        self.table[((value * self.gain).clamp(0.0, 1.0) * (TABLE - 1) as f32 + 0.5) as usize]
    }
}

/// What is not a number stands out.
const NAN: [u8; 3] = [255, 0, 255];

/// One number as gray or as a false color.
struct Shade {
    table: Vec<[u8; 3]>,
}

impl Shade {
    fn new(display: &Display) -> Self {
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
        self.table[(value.clamp(0.0, 1.0) * (TABLE - 1) as f32 + 0.5) as usize]
    }
}

/// A false color that rises evenly in hue: the polynomial of Mikhailov's Turbo.
///
/// Source: A. Mikhailov, *Turbo, An Improved Rainbow Colormap for Visualization*, 2019.
pub fn turbo(t: f32) -> [u8; 3] {
    let polynomial = |c: [f32; 6]| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let r = polynomial([0.135_721_4, 4.615_392_6, -42.660_32, 132.131_08, -152.942_4, 59.286_38]);
    let g = polynomial([0.091_402_61, 2.194_188_4, 4.842_966_6, -14.185_033, 4.277_298_6, 2.829_566]);
    let b = polynomial([0.106_673_3, 12.641_946, -60.582_05, 110.362_77, -89.903_11, 27.348_25]);
    [r, g, b].map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
}

//! What a card needs to convert numbers and colors as the processor does: the processor's own tables.

use super::card::Card;
use super::error::CardError;
use crate::evaluate::shown::{Channel, Display, Encoder, LUMINANCE, STEPS, Shade};
use trochoid::WorkingSpace;
use wgpu::Buffer;

/// The kernels' common part.
pub(super) const TEXT: &str = include_str!("conversion.wgsl");

/// Ways to show a pixel, as the kernels number them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// Each channel by the table.
    Color = 0,
    /// Each channel of the color in the screen's primaries by the table.
    Converted = 1,
    /// A channel by the table.
    Channel = 2,
    /// The luminance of light by the table.
    Luminance = 3,
    /// The luminance of an encoded color by the table.
    Encoded = 4,
    /// A number within a range by the table.
    Field = 5,
}

/// Settings and tables of a conversion.
pub(super) struct Conversion {
    mode: Mode,
    channel: u32,
    /// Factor before the table.
    gain: f32,
    range: [f32; 2],
    /// Rows whose sums with a color count.
    rows: [[f32; 3]; 3],
    /// Pixels by place.
    pub(super) table: Vec<u32>,
    /// Light by place, for encoded luminance.
    light: Vec<f32>,
}

/// Settings and tables on a card.
pub(super) struct Uploaded {
    pub(super) settings: Buffer,
    pub(super) table: Buffer,
    pub(super) encoding: Buffer,
}

impl Conversion {
    /// Prepares the conversion of colors.
    ///
    /// # Errors
    /// Only the processor does it.
    pub(super) fn of_colors(space: WorkingSpace, display: &Display) -> Result<Self, CardError> {
        let encoder = Encoder::new(space, display);
        if encoder.has_cube() {
            return Err(CardError::Unfit("colors by a table of three dimensions"));
        }
        let unit = |at: usize| std::array::from_fn(|channel| if channel == at { 1.0 } else { 0.0 });
        let columns: [[f64; 3]; 3] = std::array::from_fn(|at| space.to_linear_srgb(unit(at)));
        let matrix = std::array::from_fn(|row| columns.map(|column| column[row] as f32));
        let (mode, channel) = match (display.channel, space) {
            (Channel::All, WorkingSpace::AcesCg) => (Mode::Converted, 0),
            (Channel::All, _) => (Mode::Color, 0),
            (Channel::One(channel), _) => (Mode::Channel, channel.min(2) as u32),
            (Channel::Luminance, WorkingSpace::AcesCg) => {
                return Err(CardError::Unfit("the luminance of ACEScg"));
            }
            (Channel::Luminance, WorkingSpace::LinearSrgb) => (Mode::Luminance, 0),
            (Channel::Luminance, WorkingSpace::Srgb) => (Mode::Encoded, 0),
        };
        let rows = if mode == Mode::Converted { matrix } else { [LUMINANCE; 3] };
        let table = encoder.shades().into_iter().map(packed).collect();
        Self { mode, channel, gain: encoder.gain(), range: [0.0, 1.0], rows, table, light: encoder.light().to_vec() }
            .bounded()
    }

    /// Prepares the conversion of numbers within a range.
    ///
    /// # Errors
    /// Only the processor does it.
    pub(super) fn of_field([low, high]: [f32; 2], display: &Display) -> Result<Self, CardError> {
        if low >= high || !low.is_finite() || !high.is_finite() {
            return Err(CardError::Unfit("a range without numbers in it"));
        }
        let table = Shade::new(display).table.into_iter().map(packed).collect();
        let (range, gain) = ([low, high], 1.0 / (high - low));
        Self { mode: Mode::Field, channel: 0, gain, range, rows: [LUMINANCE; 3], table, light: Vec::new() }.bounded()
    }

    /// Leaves to the processor what a card's numbers may not hold, for it may take the smallest as 0.
    fn bounded(self) -> Result<Self, CardError> {
        let is_fit = (1e-30..1e30).contains(&self.gain);
        if is_fit { Ok(self) } else { Err(CardError::Unfit("numbers with so large or small a factor")) }
    }

    /// Copies it to a card, for a picture of a size. `dims` says whether pixels are dimmed, and `tile` is the size of the tiles
    /// of a recipe.
    pub(super) fn upload(
        &self,
        card: &Card,
        size: [usize; 2],
        tile: [usize; 2],
        dims: bool,
    ) -> Result<Uploaded, CardError> {
        let [width, height] = size;
        let words = [width * height, width, height, tile[0], tile[1]].map(|number| number as u32);
        // The zero is one that no compiler knows of.
        let mut settings = [&words[..], &[self.mode as u32, self.channel, u32::from(dims)], &[0; 4]].concat();
        settings[8] = self.gain.to_bits();
        settings[9..11].copy_from_slice(&self.range.map(f32::to_bits));
        for row in self.rows {
            settings.extend(row.map(f32::to_bits).into_iter().chain([0]));
        }
        let mut encoding: Vec<f32> = self.light.clone();
        if self.mode == Mode::Encoded {
            encoding.extend(&*STEPS);
        }
        Ok(Uploaded {
            settings: card.settings(&settings)?,
            table: card.upload(&[bytemuck::cast_slice(&self.table)])?,
            encoding: card.upload(&[bytemuck::cast_slice(&encoding)])?,
        })
    }
}

/// Returns a pixel as the kernels write it.
pub(super) fn packed([r, g, b]: [u8; 3]) -> u32 {
    u32::from_le_bytes([r, g, b, 255])
}

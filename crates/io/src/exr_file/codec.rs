//! Decoding of chunks to samples: ZIP by [`zip`](super::zip), other methods by the `exr` crate.

use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::compression::Compression as Method;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, IntegerBounds, LevelMode, LineOrder, SampleType as ExrType, Text, TileDescription,
};
use exr::meta::header::Header;
use trochoid_image::Window;

use super::failure::{Failure, WHOLE};
use super::layout::Layout;
use super::zip::{Inflater, Words};
use crate::{Compression, SampleType};

/// Channel as described by the header.
pub(super) struct Described<'a> {
    pub(super) name: &'a [u8],
    pub(super) sample_type: SampleType,
    pub(super) linear: bool,
}

/// Decoder for the chunks of one part.
pub(super) struct Codec {
    header: Header,
    bytes_per_pixel: usize,
}

impl Codec {
    /// Creates the codec of a part; `None` if the method or a sample type is not supported.
    pub(super) fn new<'a>(
        compression: Compression,
        layout: &Layout,
        channels: impl Iterator<Item = Described<'a>>,
    ) -> Option<Self> {
        let method = match compression {
            Compression::None => Method::Uncompressed,
            Compression::Rle => Method::RLE,
            Compression::Zips => Method::ZIP1,
            Compression::Zip => Method::ZIP16,
            Compression::Piz => Method::PIZ,
            Compression::Pxr24 => Method::PXR24,
            Compression::B44 => Method::B44,
            Compression::B44a => Method::B44A,
            Compression::Dwaa => Method::DWAA(None),
            Compression::Dwab => Method::DWAB(None),
            _ => return None,
        };
        let describe = |described: Described<'a>| {
            Some(ChannelDescription {
                name: Text::from_slice_unchecked(described.name),
                sample_type: match described.sample_type {
                    SampleType::Half => ExrType::F16,
                    SampleType::Float => ExrType::F32,
                    SampleType::Uint => ExrType::U32,
                    SampleType::U8 | SampleType::U16 => return None,
                },
                quantize_linearly: described.linear,
                sampling: Vec2(1, 1),
            })
        };
        let blocks = if layout.tiled {
            BlockDescription::Tiles(TileDescription {
                tile_size: Vec2(layout.width, layout.height),
                level_mode: LevelMode::Singular,
                rounding_mode: RoundingMode::Down,
            })
        } else {
            BlockDescription::ScanLines
        };
        let size = Vec2(layout.window.width(), layout.window.height());
        let header = Header::new(Text::from(""), size, channels.map(describe).collect::<Option<_>>()?).with_encoding(
            method,
            blocks,
            LineOrder::Increasing,
        );
        let bytes_per_pixel = header.channels.bytes_per_pixel;
        Some(Self { header, bytes_per_pixel })
    }

    /// Returns the size of a chunk's samples in bytes.
    pub(super) fn raw_size(&self, rectangle: Window) -> usize {
        rectangle.area() * self.bytes_per_pixel
    }

    /// Refuses a chunk whose bytes cannot represent all its samples, before memory is taken for them.
    pub(super) fn check(&self, rectangle: Window, packed: &[u8]) -> Result<(), Failure> {
        let size = self.raw_size(rectangle);
        // Writers store incompressible data unchanged, so a larger chunk is damaged.
        if packed.is_empty() || packed.len() > size {
            return Err(Failure::invalid(format!("{} bytes", packed.len()), format!("1 to {size}")));
        }
        if packed.len() == size {
            return Ok(());
        }
        let method = self.header.compression;
        if method == Method::Uncompressed {
            return Err(Failure::invalid(format!("{} bytes", packed.len()), size.to_string()));
        }
        if (packed.len() as u64).saturating_mul(densest(method)) < size as u64 {
            let expected = format!("enough for {size} when decoded");
            return Err(Failure::invalid(format!("{} bytes", packed.len()), expected));
        }
        if matches!(method, Method::DWAA(_) | Method::DWAB(_)) {
            self.check_dwa(rectangle, packed)?;
        }
        Ok(())
    }

    /// Returns the maximum size of the samples in a file of this length, in bytes.
    pub(super) fn most(&self, length: u64) -> u64 {
        length.saturating_mul(densest(self.header.compression))
    }

    /// Decodes a checked chunk: for each row, and for each channel in the order of the file, the words of the row.
    pub(super) fn unpack(
        &self,
        rectangle: Window,
        packed: &[u8],
        inflater: &mut Inflater,
        target: &mut impl Target,
    ) -> Result<(), Failure> {
        let size = self.raw_size(rectangle);
        let decoded;
        let mut raw = match self.header.compression {
            _ if packed.len() == size => Raw::Plain(packed),
            Method::ZIP1 | Method::ZIP16 => Raw::Split(inflater.inflate(packed, size)?),
            _ => {
                decoded = self.decompress(rectangle, packed.to_vec())?;
                Raw::Plain(&decoded)
            }
        };
        for row in 0..rectangle.height() {
            for (channel, described) in self.header.channels.list.iter().enumerate() {
                let words = rectangle.width() * described.sample_type.bytes_per_sample() / 2;
                match target.row(channel, row, words) {
                    Some(out) => raw.take(out),
                    None => raw.skip(words),
                }
            }
        }
        Ok(())
    }

    /// Decodes a chunk to little-endian bytes by the `exr` crate: for each row, and for each channel, the samples of
    /// the row.
    fn decompress(&self, rectangle: Window, packed: Vec<u8>) -> Result<Vec<u8>, Failure> {
        let size = self.raw_size(rectangle);
        // The B44 decoder of `exr` 1.74 underflows on damaged blocks, which panics if overflow checks are on.
        // The decoder only reads the header, so a panic leaves nothing half-changed.
        let decode = AssertUnwindSafe(|| {
            let section = bounds(rectangle);
            let native =
                self.header.compression.decompress_image_section_from_le(&self.header, packed, section, false)?;
            // Without compression, this only swaps bytes on big-endian processors.
            Method::Uncompressed.compress_image_section_to_le(&self.header, native, section)
        });
        let samples = catch_unwind(decode).map_err(|_| Failure::invalid("bytes that crash the decoder", WHOLE))??;
        if samples.len() == size { Ok(samples) } else { Err(Failure::invalid("too few samples", WHOLE)) }
    }

    /// Checks the sizes that a DWA chunk claims against its length and against the needs of its pixels.
    ///
    /// The decoder allocates what these counters claim, so a few damaged bytes would abort the process.
    fn check_dwa(&self, rectangle: Window, packed: &[u8]) -> Result<(), Failure> {
        let counters = packed.as_chunks::<8>().0.first_chunk::<11>().map(|all| all.map(u64::from_le_bytes));
        let Some([_, unknown, unknown_packed, ac_packed, dc_packed, runs_packed, run_lengths, raw_runs, ac, dc, _]) =
            counters
        else {
            return Err(Failure::invalid(format!("{} bytes", packed.len()), "88 bytes of counters"));
        };
        let size = self.raw_size(rectangle) as u64;
        let blocks = (rectangle.width().div_ceil(8) * rectangle.height().div_ceil(8)) as u64;
        let blocks = blocks * self.header.channels.list.len() as u64;
        let rest = packed.len() as u64 - 88;
        let parts = [unknown_packed, ac_packed, dc_packed, runs_packed];
        let deflated = |packed: u64| packed.saturating_mul(DEFLATE);
        let claims = [
            ("packed bytes", parts.iter().fold(0, |sum: u64, part| sum.saturating_add(*part)), rest),
            ("samples", unknown, size.min(deflated(unknown_packed))),
            // In the worst case every byte is a run of its own, which takes two bytes.
            ("run lengths", run_lengths, (2 * size + 2).min(deflated(runs_packed))),
            ("samples in runs", raw_runs, size.min(run_lengths.saturating_mul(RUN))),
            ("AC coefficients", ac, (64 * blocks).min(deflated(ac_packed) / 2)),
            ("DC coefficients", dc, blocks.min(deflated(dc_packed) / 2)),
        ];
        for (what, found, most) in claims {
            if found > most {
                return Err(Failure::invalid(format!("{found} {what}"), format!("at most {most}")));
            }
        }
        // Each sample is stored unchanged, in runs, or in a block of 64 with one DC coefficient.
        let held = unknown.saturating_add(raw_runs).saturating_add(dc.saturating_mul(64 * 4));
        if held < size {
            return Err(Failure::invalid(format!("room for {held} bytes"), format!("{size}")));
        }
        Ok(())
    }
}

/// Maximum number of bytes per byte of DEFLATE: at best two bits represent a match of 258 bytes.
pub(super) const DEFLATE: u64 = 1032;
/// Longest run of bytes, which is stored in two bytes.
const RUN: u64 = 64;

/// Returns the maximum number of sample bytes per byte of a chunk, by method. Pictures of zeros come close.
fn densest(method: Method) -> u64 {
    match method {
        Method::Uncompressed => 1,
        Method::RLE => RUN,
        Method::ZIP1 | Method::ZIP16 => DEFLATE,
        // Three bytes of each float are deflated.
        Method::PXR24 => DEFLATE * 4 / 3,
        // A code of one bit, one for "repeat" and 8 bits of how often: 256 words in 10 bits, 410 bytes per byte.
        Method::PIZ => 512,
        // Flat blocks of 16 half samples take 3 bytes.
        Method::B44 | Method::B44A => 11,
        // A block of 64 floats with nothing but a DC coefficient, of two bytes, deflated.
        _ => 64 * 4 / 2 * DEFLATE,
    }
}

/// Destination of the words of a chunk.
pub(super) trait Target {
    /// Returns the place for these `words` of a channel and a row of the chunk; `None` if they are not needed.
    fn row(&mut self, channel: usize, row: usize, words: usize) -> Option<&mut [u16]>;
}

/// Reader of a chunk's samples from the front.
enum Raw<'a> {
    Plain(&'a [u8]),
    Split(Words<'a>),
}

impl Raw<'_> {
    fn take(&mut self, out: &mut [u16]) {
        match self {
            Self::Plain(bytes) => {
                let (head, tail) = bytes.split_at(2 * out.len());
                *bytes = tail;
                for (word, bytes) in out.iter_mut().zip(head.as_chunks().0) {
                    *word = u16::from_le_bytes(*bytes);
                }
            }
            Self::Split(words) => words.take(out),
        }
    }

    fn skip(&mut self, count: usize) {
        match self {
            Self::Plain(bytes) => *bytes = &bytes[2 * count..],
            Self::Split(words) => words.skip(count),
        }
    }
}

/// Returns a chunk's rectangle relative to the corner of the data window; windows have been checked to fit in 31 bits.
fn bounds(rectangle: Window) -> IntegerBounds {
    let position = Vec2(rectangle.x0 as i32, rectangle.y0 as i32);
    IntegerBounds::new(position, Vec2(rectangle.width(), rectangle.height()))
}

#[cfg(test)]
#[path = "codec_tests.rs"]
mod tests;

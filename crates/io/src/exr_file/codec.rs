//! Compression and decompression of one chunk, by the `exr` crate.

use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::compression::Compression as Method;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, IntegerBounds, LevelMode, LineOrder, SampleType as ExrType, Text, TileDescription,
};
use exr::meta::header::Header;
use trochoid_image::Window;

use super::layout::Layout;
use crate::{Compression, SampleType};

/// Why a chunk cannot be decoded or encoded.
#[derive(Debug)]
pub(super) enum Failure {
    Invalid { found: String, expected: String },
    Unsupported(String),
}

impl Failure {
    fn invalid(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Invalid { found: found.into(), expected: expected.into() }
    }
}

/// What every chunk is expected to be.
const WHOLE: &str = "a chunk that decodes to its pixels";

impl From<exr::error::Error> for Failure {
    fn from(error: exr::error::Error) -> Self {
        match error {
            exr::error::Error::NotSupported(message) => Self::Unsupported(message.into_owned()),
            other => Self::invalid(other.to_string(), WHOLE),
        }
    }
}

/// One channel as chunks store it.
pub(super) struct Stored<'a> {
    pub(super) name: &'a [u8],
    pub(super) sample_type: SampleType,
    pub(super) linear: bool,
}

/// Knows what the chunks of one part look like.
pub(super) struct Codec {
    header: Header,
    bytes_per_pixel: usize,
}

impl Codec {
    /// The codec of a part; `None` where the method or a sample type is not supported.
    pub(super) fn new<'a>(
        compression: Compression,
        layout: &Layout,
        channels: impl Iterator<Item = Stored<'a>>,
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
        let describe = |stored: Stored<'a>| {
            Some(ChannelDescription {
                name: Text::from_slice_unchecked(stored.name),
                sample_type: match stored.sample_type {
                    SampleType::Half => ExrType::F16,
                    SampleType::Float => ExrType::F32,
                    SampleType::Uint => ExrType::U32,
                    SampleType::U8 | SampleType::U16 => return None,
                },
                quantize_linearly: stored.linear,
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

    /// Bytes of a chunk's samples.
    pub(super) fn raw_size(&self, rectangle: Window) -> usize {
        rectangle.area() * self.bytes_per_pixel
    }

    /// Samples of a chunk in native byte order: for each row, for each channel, the row's samples.
    pub(super) fn decompress(&self, rectangle: Window, packed: Vec<u8>) -> Result<Vec<u8>, Failure> {
        let size = self.raw_size(rectangle);
        // Writers store what does not shrink as it is, so a larger chunk is damaged.
        if packed.is_empty() || packed.len() > size {
            return Err(Failure::invalid(format!("{} bytes", packed.len()), format!("1 to {size}")));
        }
        if packed.len() < size && matches!(self.header.compression, Method::DWAA(_) | Method::DWAB(_)) {
            self.check_dwa(rectangle, &packed)?;
        }
        // The B44 decoder of `exr` 1.74 subtracts below zero on damaged blocks, which panics wherever overflow is checked.
        // It only reads the header, so nothing half-changed is left behind.
        let decode = AssertUnwindSafe(|| {
            let section = bounds(rectangle);
            self.header.compression.decompress_image_section_from_le(&self.header, packed, section, false)
        });
        let samples = catch_unwind(decode).map_err(|_| Failure::invalid("bytes that upset the decoder", WHOLE))??;
        if samples.len() == size { Ok(samples) } else { Err(Failure::invalid("too few samples", WHOLE)) }
    }

    /// The chunk as stored in the file, from samples in native byte order.
    pub(super) fn compress(&self, rectangle: Window, samples: Vec<u8>) -> Result<Vec<u8>, Failure> {
        Ok(self.header.compression.compress_image_section_to_le(&self.header, samples, bounds(rectangle))?)
    }

    /// Holds the sizes that a DWA chunk claims against what its pixels can need.
    ///
    /// The decoder allocates what these counters say, and would abort the process over a few damaged bytes.
    fn check_dwa(&self, rectangle: Window, packed: &[u8]) -> Result<(), Failure> {
        let counters = packed.as_chunks::<8>().0;
        let Some(&[_, unknown, _, _, _, _, run_lengths, raw_runs, ac, dc, _]) = counters.first_chunk::<11>() else {
            return Err(Failure::invalid(format!("{} bytes", packed.len()), "88 bytes of counters"));
        };
        let size = self.raw_size(rectangle) as u64;
        let blocks = (rectangle.width().div_ceil(8) * rectangle.height().div_ceil(8)) as u64;
        let blocks = blocks * self.header.channels.list.len() as u64;
        let claims = [
            ("samples", unknown, size),
            // At worst every byte is its own run of two.
            ("run lengths", run_lengths, 2 * size + 2),
            ("samples in runs", raw_runs, size),
            ("AC coefficients", ac, 64 * blocks),
            ("DC coefficients", dc, blocks),
        ];
        for (what, found, most) in claims {
            let found = u64::from_le_bytes(found);
            if found > most {
                return Err(Failure::invalid(format!("{found} {what}"), format!("at most {most}")));
            }
        }
        Ok(())
    }
}

/// A chunk's rectangle, counted from the data window's corner; windows are checked to lie within 31 bits.
fn bounds(rectangle: Window) -> IntegerBounds {
    let position = Vec2(rectangle.x0 as i32, rectangle.y0 as i32);
    IntegerBounds::new(position, Vec2(rectangle.width(), rectangle.height()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Storage;

    fn codec(compression: Compression, sample_type: SampleType) -> (Codec, Window) {
        let window = Window::sized(20, 10);
        let layout = Layout::new(window, &Storage::Scanline, compression, false);
        let stored = [b"G", b"R"].map(|name| Stored { name, sample_type, linear: false });
        (Codec::new(compression, &layout, stored.into_iter()).unwrap(), window)
    }

    #[test]
    fn claims_of_dwa_counters_are_held_against_the_pixels() {
        let (codec, window) = codec(Compression::Dwaa, SampleType::Half);
        let packed = codec.compress(window, vec![60; codec.raw_size(window)]).unwrap();
        assert!(codec.decompress(window, packed.clone()).is_ok());
        for counter in [1, 6, 7, 8, 9] {
            for claim in [1 << 40, i64::MAX as u64, u64::MAX] {
                let mut bytes = packed.clone();
                bytes[8 * counter..][..8].copy_from_slice(&claim.to_le_bytes());
                let found = codec.decompress(window, bytes);
                assert!(
                    matches!(&found, Err(Failure::Invalid { expected, .. }) if expected.starts_with("at most")),
                    "{found:?}"
                );
            }
        }
        assert!(codec.decompress(window, vec![0; 20]).is_err());
    }

    #[test]
    fn chunks_of_absurd_size_are_refused() {
        for compression in [Compression::None, Compression::Zip, Compression::Piz] {
            let (codec, _) = codec(compression, SampleType::Float);
            let window = Window::sized(20, 1);
            let size = codec.raw_size(window);
            for length in [0, size + 1] {
                assert!(matches!(codec.decompress(window, vec![0; length]), Err(Failure::Invalid { .. })));
            }
            assert!(codec.decompress(window, vec![0; size]).is_ok());
        }
    }

    #[test]
    fn damaged_b44_blocks_are_an_error_or_garbage_but_no_panic() {
        let (codec, window) = codec(Compression::B44, SampleType::Half);
        for byte in [0x40, 0x01, 0xf8, 0xff] {
            if let Ok(raw) = codec.decompress(window, vec![byte; 500]) {
                assert_eq!(raw.len(), codec.raw_size(window), "{byte:#x}");
            }
        }
    }
}

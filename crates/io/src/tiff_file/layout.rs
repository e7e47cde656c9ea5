//! Layout of a TIFF's pixels according to its tags, and checks of whether it is supported.

use std::path::PathBuf;

use image::metadata::Orientation;

use super::directory::{Directory, tag};
use crate::raster::{Form, PLACE, bases, unsupported};
use crate::source::SourceFile;
use crate::{Encoding, Error, Limits, SampleType};

/// Compression of chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
    Jpeg,
}

/// Interpretation of samples as pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Gray, where 0 is black or white.
    Gray {
        inverted: bool,
    },
    Rgb,
    /// Palette, with all red entries first, then green, then blue.
    Palette(Vec<u16>),
    Cmyk,
    /// YCbCr with this many pixels per chroma sample, across and down.
    YCbCr([usize; 2]),
}

/// Picture of a TIFF file.
pub(super) struct Layout {
    pub(super) path: PathBuf,
    pub(super) form: Form,
    pub(super) meaning: Meaning,
    pub(super) packing: Packing,
    pub(super) big_endian: bool,
    /// Whether the bits of each byte are stored in reverse order.
    pub(super) reversed: bool,
    /// Predictor: 1 for none, 2 for differences, 3 for differences of the bytes of floats.
    pub(super) predictor: u64,
    /// Number of stored samples per pixel, and number of leading samples that are read.
    pub(super) samples: usize,
    pub(super) wanted: usize,
    pub(super) bits: usize,
    pub(super) float: bool,
    /// Whether each sample has its own chunks.
    pub(super) planar: bool,
    /// Width and height of a chunk in pixels.
    pub(super) chunk: [usize; 2],
    pub(super) tiled: bool,
    pub(super) offsets: Vec<u64>,
    pub(super) lengths: Vec<u64>,
    pub(super) tables: Vec<u8>,
}

/// Tags of an open file.
struct Tags<'a> {
    source: &'a mut SourceFile,
    directory: Directory,
}

impl Tags<'_> {
    fn number(&mut self, tag: u16) -> Result<Option<u64>, Error> {
        self.directory.number(self.source, tag)
    }

    fn numbers(&mut self, tag: u16, most: u64) -> Result<Option<Vec<u64>>, Error> {
        self.directory.numbers(self.source, tag, most)
    }

    fn refused(&self, found: String) -> Error {
        unsupported(self.directory.path(), found)
    }

    fn side(&mut self, tag: u16) -> Result<u32, Error> {
        let found = self.number(tag)?.unwrap_or_default();
        let fits = u32::try_from(found).ok().filter(|side| (1..=i32::MAX as u32).contains(side));
        fits.ok_or_else(|| {
            let expected = "at least one pixel, and 31 bits";
            self.directory.invalid(&format!("tag {tag}"), format!("a side of {found}"), expected)
        })
    }

    /// Returns the bits of a sample, and whether it is a float.
    fn stored(&mut self) -> Result<(usize, bool), Error> {
        let all = self.numbers(tag::BITS, 64)?.unwrap_or_else(|| vec![1]);
        let bits = all[0] as usize;
        if all.iter().any(|other| *other != all[0]) {
            return Err(self.refused(format!("a TIFF whose samples have {all:?} bits")));
        }
        let float = match self.numbers(tag::SAMPLE_FORMAT, 64)?.map_or(1, |formats| formats[0]) {
            // 4: unspecified.
            1 | 4 => false,
            3 => true,
            2 => return Err(self.refused("a TIFF with signed integers".into())),
            5 | 6 => return Err(self.refused("a TIFF with complex numbers".into())),
            other => return Err(self.refused(format!("a TIFF with samples of format {other}"))),
        };
        let known = if float { matches!(bits, 16 | 24 | 32 | 64) } else { (1..=32).contains(&bits) };
        if !known {
            let kind = if float { "floating-point" } else { "integer" };
            return Err(self.refused(format!("a TIFF with {kind} samples of {bits} bits")));
        }
        Ok((bits, float))
    }

    fn meaning(&mut self, samples: usize, bits: usize, float: bool) -> Result<Meaning, Error> {
        let meaning = match self.number(tag::PHOTOMETRIC)? {
            // Old writers omit the tag in color pictures.
            None if samples >= 3 => Meaning::Rgb,
            None | Some(1) => Meaning::Gray { inverted: false },
            Some(0) => Meaning::Gray { inverted: true },
            Some(2) => Meaning::Rgb,
            Some(3) => Meaning::Palette(self.palette(bits)?),
            Some(5) if matches!(self.number(tag::INK_SET)?, None | Some(1)) => Meaning::Cmyk,
            Some(5) => return Err(self.refused("a TIFF of other inks than CMYK".into())),
            Some(6) => {
                let steps = self.numbers(tag::SUBSAMPLING, 2)?.unwrap_or_else(|| vec![2, 2]);
                Meaning::YCbCr([0, 1].map(|at| steps.get(at).map_or(1, |step| *step as usize)))
            }
            Some(other) => return Err(self.refused(format!("a TIFF of {}", photometry(other)))),
        };
        let odd = match &meaning {
            Meaning::Palette(_) if float => Some("a palette"),
            Meaning::Cmyk if float || !matches!(bits, 8 | 16) => Some("CMYK"),
            Meaning::YCbCr(_) if float || bits != 8 => Some("YCbCr"),
            _ => None,
        };
        match odd {
            Some(what) => Err(self.refused(format!("a TIFF of {what} with {bits} bits a sample"))),
            None => Ok(meaning),
        }
    }

    fn palette(&mut self, bits: usize) -> Result<Vec<u16>, Error> {
        if bits > 16 {
            return Err(self.refused(format!("a TIFF of a palette with {bits} bits a sample")));
        }
        let entries = 3_u64 << bits;
        let map = self.numbers(tag::COLOR_MAP, entries)?.unwrap_or_default();
        if map.len() as u64 != entries {
            let found = format!("{} numbers of a palette", map.len());
            return Err(self.directory.invalid("tag 320", found, &format!("{entries} for {bits} bits")));
        }
        Ok(map.into_iter().map(|entry| entry as u16).collect())
    }

    /// Returns the width and height of a chunk, and whether it is a tile.
    fn chunk(&mut self, width: u32, height: u32) -> Result<([usize; 2], bool), Error> {
        let tile = self.number(tag::TILE_WIDTH)?;
        let chunk = match tile {
            Some(across) => [across, self.number(tag::TILE_HEIGHT)?.unwrap_or_default()],
            None => [width.into(), self.number(tag::ROWS_PER_STRIP)?.unwrap_or(u64::MAX).min(height.into())],
        };
        if chunk.iter().any(|side| !(1..=1 << 30).contains(side)) {
            let found = format!("chunks of {} × {} pixels", chunk[0], chunk[1]);
            return Err(self.directory.invalid(PLACE, found, "at least one pixel, and 30 bits"));
        }
        Ok((chunk.map(|side| side as usize), tile.is_some()))
    }

    /// Returns the positions and lengths of this many chunks.
    fn places(&mut self, tiled: bool, count: usize, packing: Packing) -> Result<[Vec<u64>; 2], Error> {
        let tags = if tiled { [tag::TILE_OFFSETS, tag::TILE_BYTES] } else { [tag::STRIP_OFFSETS, tag::STRIP_BYTES] };
        let mut lists = [Vec::new(), Vec::new()];
        for (list, tag) in lists.iter_mut().zip(tags) {
            // Some writers store one entry too many.
            *list = self.numbers(tag, (count as u64).saturating_add(1))?.unwrap_or_default();
            if list.is_empty() && tag == tag::STRIP_BYTES && packing == Packing::None && count == 1 {
                *list = vec![self.source.length];
            }
            if list.len() < count {
                let found = format!("{} places or lengths of chunks", list.len());
                return Err(self.directory.invalid(&format!("tag {tag}"), found, &format!("{count}")));
            }
        }
        Ok(lists)
    }

    fn predictor(&mut self, bits: usize, float: bool) -> Result<u64, Error> {
        let predictor = self.number(tag::PREDICTOR)?.unwrap_or(1);
        match predictor {
            1 => {}
            2 if matches!(bits, 8 | 16 | 32) => {}
            3 if float => {}
            _ => return Err(self.refused(format!("a TIFF with predictor {predictor} and {bits} bits a sample"))),
        }
        Ok(predictor)
    }
}

/// Returns the type of the decoded samples.
fn sample_type(meaning: &Meaning, bits: usize, float: bool) -> SampleType {
    match (meaning, float, bits) {
        (Meaning::Palette(map), ..) if to_bytes(map).is_some() => SampleType::U8,
        (Meaning::Palette(_), ..) => SampleType::U16,
        (_, true, 16) => SampleType::Half,
        (_, true, _) => SampleType::Float,
        (_, false, ..=8) => SampleType::U8,
        (_, false, ..=16) => SampleType::U16,
        (_, false, _) => SampleType::Float,
    }
}

impl Layout {
    pub(super) fn read(source: &mut SourceFile) -> Result<Self, Error> {
        let directory = Directory::read(source)?;
        let (path, length) = (source.path.clone(), source.length);
        let mut tags = Tags { source, directory };
        let (width, height) = (tags.side(tag::WIDTH)?, tags.side(tag::HEIGHT)?);
        let packing =
            packing(tags.number(tag::COMPRESSION)?.unwrap_or(1)).map_err(|found| tags.refused(found.to_string()))?;
        let samples = tags.number(tag::SAMPLES)?.unwrap_or(1) as usize;
        if !(1..=64).contains(&samples) {
            return Err(tags.refused(format!("a TIFF with {samples} samples a pixel")));
        }
        let (bits, float) = tags.stored()?;
        let meaning = tags.meaning(samples, bits, float)?;
        let colors = match &meaning {
            Meaning::Gray { .. } | Meaning::Palette(_) => 1,
            Meaning::Rgb | Meaning::YCbCr(_) => 3,
            Meaning::Cmyk => 4,
        };
        if samples < colors {
            let expected = format!("at least {colors}");
            return Err(tags.directory.invalid("tag 277", format!("{samples} samples a pixel"), &expected));
        }
        // The first sample after the colors is alpha, unless the file declares something else.
        let extra = tags.numbers(tag::EXTRA_SAMPLES, 64)?;
        let alpha = samples > colors
            && extra.map_or(samples == colors + 1, |extra| matches!(extra[0], 1 | 2))
            && matches!(meaning, Meaning::Gray { .. } | Meaning::Rgb);
        let planar = tags.number(tag::PLANAR)?.unwrap_or(1) == 2 && samples > 1;
        let (chunk, tiled) = tags.chunk(width, height)?;
        let chunks = (width as usize).div_ceil(chunk[0]).saturating_mul((height as usize).div_ceil(chunk[1]));
        let count = chunks.saturating_mul(if planar { samples } else { 1 });
        let [offsets, lengths] = tags.places(tiled, count, packing)?;
        let predictor = tags.predictor(bits, float)?;
        let tables = tags.numbers(tag::JPEG_TABLES, 1 << 20)?.unwrap_or_default();
        let orientation = tags.number(tag::ORIENTATION)?.and_then(|tag| u8::try_from(tag).ok());
        let form = Form {
            width,
            height,
            sample_type: sample_type(&meaning, bits, float),
            bases: bases(!matches!(meaning, Meaning::Gray { .. }), alpha),
            orientation: orientation.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms),
            encoding: if float { Encoding::Linear } else { Encoding::Srgb },
            rows: chunk[1].min(height as usize) as u32,
            working: 0,
        };
        let mut layout = Self {
            path,
            form,
            meaning,
            packing,
            big_endian: tags.directory.big_endian,
            reversed: tags.number(tag::FILL_ORDER)? == Some(2),
            predictor,
            samples,
            wanted: colors + usize::from(alpha),
            bits,
            float,
            planar,
            chunk,
            tiled,
            offsets,
            lengths,
            tables: tables.iter().map(|byte| *byte as u8).collect(),
        };
        layout.check()?;
        layout.check_claim(length)?;
        // The planes of a chunk, one more during decoding, and its packed bytes.
        let longest = layout.lengths.iter().copied().max().unwrap_or_default().min(length);
        let planes = 2 + if planar { layout.wanted as u64 } else { 1 };
        layout.form.working = planes.saturating_mul(layout.raw_size(chunk[1]) as u64).saturating_add(longest);
        Ok(layout)
    }

    /// Refuses combinations that no program writes, and chunks that need too much memory.
    fn check(&self) -> Result<(), Error> {
        if let Meaning::YCbCr(steps) = self.meaning {
            let plain = self.packing != Packing::Jpeg;
            let known = steps.iter().all(|step| matches!(step, 1 | 2 | 4)) && self.samples == 3;
            if self.planar || plain && (!known || self.predictor != 1) {
                return Err(unsupported(&self.path, "a TIFF of YCbCr with planes, other samples or a predictor"));
            }
        }
        if self.packing == Packing::Jpeg && (self.bits != 8 || self.predictor != 1) {
            return Err(unsupported(&self.path, format!("a TIFF with JPEG compression of {} bits", self.bits)));
        }
        Limits::default().check_bytes(&self.path, "one chunk", self.raw_size(self.chunk[1]) as u64)
    }

    /// Refuses a picture with more pixels than its chunks can represent, before memory is taken for it.
    fn check_claim(&self, length: u64) -> Result<(), Error> {
        // Equal chunks may be stored only once.
        let packed = self.lengths.iter().fold(0, |sum: u64, chunk| sum.saturating_add(length.min(*chunk)));
        let samples = if matches!(self.meaning, Meaning::YCbCr(_)) { 1 } else { self.samples };
        let row = (self.form.width as usize * samples * self.bits).div_ceil(8);
        if self.can_hold(packed, row.saturating_mul(self.form.height as usize)) {
            return Ok(());
        }
        let expected = format!("enough for {} × {} pixels", self.form.width, self.form.height);
        Err(Error::invalid(&self.path, PLACE, format!("{packed} bytes of chunks"), expected))
    }

    /// Returns the number of chunks across the picture.
    pub(super) fn across(&self) -> usize {
        (self.form.width as usize).div_ceil(self.chunk[0])
    }

    /// Returns the number of stored samples per pixel in one chunk.
    pub(super) fn interleaved(&self) -> usize {
        if self.planar { 1 } else { self.samples }
    }

    /// Returns the size of a row of a chunk, in bytes.
    pub(super) fn raw_row(&self) -> usize {
        (self.chunk[0] * self.interleaved() * self.bits).div_ceil(8)
    }

    /// Returns the size of a chunk with this many rows, in bytes.
    pub(super) fn raw_size(&self, rows: usize) -> usize {
        match self.meaning {
            Meaning::YCbCr([h, v]) if self.packing != Packing::Jpeg => {
                self.chunk[0].div_ceil(h).saturating_mul(rows.div_ceil(v)).saturating_mul(h * v + 2)
            }
            _ => self.raw_row().saturating_mul(rows),
        }
    }
}

/// Returns the divisor that converts the entries of a palette to bytes; `None` if they need all 16 bits. Old writers
/// store bytes, others store bytes followed by zeros.
pub(super) fn to_bytes(map: &[u16]) -> Option<u16> {
    [257, 256, 1].into_iter().find(|by| map.iter().all(|entry| entry % by == 0 && entry / by <= 255))
}

/// A compression that is not read.
#[derive(Debug, thiserror::Error)]
enum Unread {
    #[error("a TIFF with {0} compression")]
    Named(&'static str),
    #[error("a TIFF with compression method {0}")]
    Numbered(u64),
}

fn packing(number: u64) -> Result<Packing, Unread> {
    let name = match number {
        1 => return Ok(Packing::None),
        5 => return Ok(Packing::Lzw),
        7 => return Ok(Packing::Jpeg),
        8 | 32946 => return Ok(Packing::Deflate),
        32773 => return Ok(Packing::PackBits),
        2 => "CCITT run-length",
        3 => "CCITT G3",
        4 => "CCITT G4",
        6 => "old-style JPEG",
        9 | 10 => "JBIG",
        32766 => "NeXT",
        32809 => "ThunderScan",
        32895..=32898 => "a printer's",
        34661 => "JBIG",
        34676 | 34677 => "LogLuv (SGILog)",
        34712 | 33003 | 33005 => "JPEG 2000",
        34887 => "LERC",
        34925 => "LZMA",
        50000 => "Zstandard",
        50001 => "WebP",
        50002 | 52546 => "JPEG XL",
        _ => return Err(Unread::Numbered(number)),
    };
    Err(Unread::Named(name))
}

fn photometry(number: u64) -> String {
    let name = match number {
        4 => "a transparency mask",
        8..=10 => "L*a*b* colors",
        32803 => "a camera's raw sensor (CFA)",
        32844 => "LogL luminance",
        32845 => "LogLuv colors",
        34892 => "a camera's linear raw data",
        _ => return format!("photometric interpretation {number}"),
    };
    name.into()
}

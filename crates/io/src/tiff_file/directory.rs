//! The first directory of a TIFF or BigTIFF. Every claim is checked against the file's length.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::source::SourceFile;

/// Maximum number of entries in a directory; some hundred tags exist.
const MOST_ENTRIES: u64 = 4096;

/// Numbers of the supported tags.
pub(super) mod tag {
    pub(crate) const WIDTH: u16 = 256;
    pub(crate) const HEIGHT: u16 = 257;
    pub(crate) const BITS: u16 = 258;
    pub(crate) const COMPRESSION: u16 = 259;
    pub(crate) const PHOTOMETRIC: u16 = 262;
    pub(crate) const FILL_ORDER: u16 = 266;
    pub(crate) const STRIP_OFFSETS: u16 = 273;
    pub(crate) const ORIENTATION: u16 = 274;
    pub(crate) const SAMPLES: u16 = 277;
    pub(crate) const ROWS_PER_STRIP: u16 = 278;
    pub(crate) const STRIP_BYTES: u16 = 279;
    pub(crate) const PLANAR: u16 = 284;
    pub(crate) const PREDICTOR: u16 = 317;
    pub(crate) const COLOR_MAP: u16 = 320;
    pub(crate) const TILE_WIDTH: u16 = 322;
    pub(crate) const TILE_HEIGHT: u16 = 323;
    pub(crate) const TILE_OFFSETS: u16 = 324;
    pub(crate) const TILE_BYTES: u16 = 325;
    pub(crate) const INK_SET: u16 = 332;
    pub(crate) const EXTRA_SAMPLES: u16 = 338;
    pub(crate) const SAMPLE_FORMAT: u16 = 339;
    pub(crate) const JPEG_TABLES: u16 = 347;
    pub(crate) const SUBSAMPLING: u16 = 530;
}

/// Directory entry whose values have not been read.
#[derive(Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    /// Position of the values in the file.
    position: u64,
}

impl Entry {
    /// Returns the size of a value in bytes; `None` for unknown types.
    fn size(self) -> Option<u64> {
        Some(match self.kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16..=18 => 8,
            _ => return None,
        })
    }
}

/// Entries of the first directory.
pub(super) struct Directory {
    path: PathBuf,
    pub(super) big_endian: bool,
    entries: HashMap<u16, Entry>,
}

impl Directory {
    pub(super) fn read(source: &mut SourceFile) -> Result<Self, Error> {
        source.seek(0)?;
        let head = source.bytes(4, "header")?;
        let big_endian = head[0] == b'M';
        let big = head[2] == 43 || head[3] == 43;
        let number = |bytes: &[u8]| number(bytes, big_endian);
        let (word, size) = if big { (8, 20) } else { (4, 12) };
        if big {
            // The size of offsets, which is 8, and a zero.
            source.bytes(4, "header")?;
        }
        let start = number(&source.bytes(word, "header")?);
        let place = format!("directory at byte {start}");
        if start >= source.length {
            let expected = format!("an offset within the file's {} bytes", source.length);
            return Err(Error::invalid(&source.path, "header", format!("a directory at byte {start}"), expected));
        }
        source.seek(start)?;
        let count = number(&source.bytes(if big { 8 } else { 2 }, &place)?);
        if count > MOST_ENTRIES {
            let expected = format!("at most {MOST_ENTRIES}");
            return Err(Error::invalid(&source.path, place, format!("{count} entries"), expected));
        }
        let first = start + if big { 8 } else { 2 };
        let bytes = source.bytes(count * size, &place)?;
        let mut directory = Self { path: source.path.clone(), big_endian, entries: HashMap::new() };
        for (index, bytes) in bytes.chunks_exact(size as usize).enumerate() {
            let value = size as usize - word as usize;
            let mut entry = Entry {
                kind: number(&bytes[2..4]) as u16,
                count: number(&bytes[4..value]),
                position: number(&bytes[value..]),
            };
            let Some(length) = entry.size().map(|size| size.saturating_mul(entry.count)) else { continue };
            if length <= word {
                entry.position = first + index as u64 * size + value as u64;
            }
            // Tags that are not needed may be damaged.
            if entry.position.saturating_add(length) <= source.length {
                directory.entries.entry(number(&bytes[..2]) as u16).or_insert(entry);
            }
        }
        Ok(directory)
    }

    /// Returns the unsigned numbers of a tag, at most this many; none if the tag is absent.
    pub(super) fn numbers(&self, source: &mut SourceFile, tag: u16, most: u64) -> Result<Option<Vec<u64>>, Error> {
        let Some(entry) = self.entries.get(&tag).filter(|entry| entry.count > 0) else { return Ok(None) };
        let place = format!("tag {tag}");
        let (Some(size), 1 | 3 | 4 | 7 | 13 | 16 | 18) = (entry.size(), entry.kind) else {
            return Err(self.invalid(&place, format!("values of type {}", entry.kind), "whole numbers"));
        };
        if entry.count > most {
            return Err(self.invalid(&place, format!("{} values", entry.count), &format!("at most {most}")));
        }
        source.seek(entry.position)?;
        let bytes = source.bytes(size * entry.count, &place)?;
        Ok(Some(bytes.chunks_exact(size as usize).map(|bytes| number(bytes, self.big_endian)).collect()))
    }

    /// Returns the first number of a tag.
    pub(super) fn number(&self, source: &mut SourceFile, tag: u16) -> Result<Option<u64>, Error> {
        let Some(entry) = self.entries.get(&tag) else { return Ok(None) };
        Ok(self.numbers(source, tag, entry.count.min(u64::from(u16::MAX)))?.map(|numbers| numbers[0]))
    }

    pub(super) fn invalid(&self, place: &str, found: impl Into<String>, expected: &str) -> Error {
        Error::invalid(&self.path, place, found, expected)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

fn number(bytes: &[u8], big_endian: bool) -> u64 {
    let step = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, step) } else { bytes.iter().rev().fold(0, step) }
}

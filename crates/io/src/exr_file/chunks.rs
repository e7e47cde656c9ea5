//! Locating and reading of compressed chunks.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use trochoid_image::Window;

use super::attribute::Fields;
use super::header::Header;
use super::layout::Layout;
use crate::Error;
use crate::limits::grow;
use crate::source::{ReadAt, SourceFile};

/// Minimum number of bytes that are read at once: chunks of single rows are small, and each request costs as much as
/// many bytes.
const AHEAD: usize = 64 << 10;

/// Reusable buffer with a section of a file.
#[derive(Default)]
pub(super) struct Part {
    /// Identifier of the [`Chunks`] that it belongs to; 0 if none.
    file: u64,
    position: u64,
    length: usize,
    bytes: Vec<u8>,
}

impl Part {
    /// Returns the memory held, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.bytes.capacity()
    }
}

/// Chunks of a part at full resolution, and their positions in the file.
pub(super) struct Chunks {
    /// Path of the file, for messages.
    pub(super) path: PathBuf,
    /// Description of the part, for messages.
    pub(super) place: String,
    pub(super) layout: Layout,
    part: usize,
    multi_part: bool,
    /// Offsets of the chunks, in row order.
    offsets: Vec<u64>,
    /// End of the last table of offsets, where chunks begin.
    first: u64,
    /// Length of the file in bytes.
    pub(super) length: u64,
    /// Unique identifier.
    id: u64,
}

/// Checks that a file with one part of scanlines has all its chunks, one after another in order, and ends with the
/// last.
///
/// # Errors
/// A chunk is missing or out of place, or bytes follow the last; or the file is of a kind that this crate does not
/// write.
pub(crate) fn check_whole(source: &mut SourceFile) -> Result<(), Error> {
    let header = Header::read(source)?;
    let chunks = Chunks::find(source, &header, 0)?;
    if chunks.multi_part || chunks.layout.tiled {
        return Err(Error::invalid(&source.path, "header", "parts or tiles", "one part of scanlines"));
    }
    let mut end = chunks.first;
    for (band, offset) in chunks.offsets.iter().enumerate() {
        let at = Position { column: 0, band };
        if *offset != end {
            return Err(chunks.invalid(
                at,
                format!("the offset {offset}"),
                format!("{end}, where the one before ends"),
            ));
        }
        source.seek(end)?;
        let head = source.bytes(8, &chunks.place(at))?;
        let mut fields = Fields(&head);
        let (row, size) = (fields.i32().unwrap_or_default(), fields.i32().unwrap_or_default());
        let y = chunks.layout.window.y0 + chunks.rectangle(at).y0;
        let Some(size) = u64::try_from(size).ok().filter(|size| *size > 0 && i64::from(row) == y) else {
            let found = format!("row {row} and a size of {size} bytes");
            return Err(chunks.invalid(at, found, format!("row {y} and a size")));
        };
        end += 8 + size;
    }
    if end != chunks.length {
        let found = format!("{} bytes", chunks.length);
        return Err(Error::invalid(
            &source.path,
            "end of the file",
            found,
            format!("{end}, where the last chunk ends"),
        ));
    }
    Ok(())
}

/// Place of a chunk in a part, at full resolution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub(super) column: usize,
    pub(super) band: usize,
}

impl Chunks {
    /// Reads the part's table of offsets.
    pub(super) fn find(source: &mut SourceFile, header: &Header, part: usize) -> Result<Self, Error> {
        let (detail, place) = (&header.details[part], header.parts[part].place(part));
        let layout = detail.layout;
        if let Some(stated) = detail.stated_chunks.filter(|&stated| stated != layout.chunks) {
            let expected = format!("{} for its window and tiles", layout.chunks);
            return Err(Error::invalid(&source.path, place, format!("a chunk count of {stated}"), expected));
        }
        // The tables of all parts follow each other; parts of unknown kind can only be skipped by their stated count.
        let counts: Vec<u64> =
            header.details.iter().map(|detail| detail.stated_chunks.unwrap_or(detail.layout.chunks)).collect();
        let bytes = |counts: &[u64]| counts.iter().fold(0_u64, |sum, &n| sum.saturating_add(n.saturating_mul(8)));
        let (before, all) = (bytes(&counts[..part]), bytes(&counts));
        let first = header.tables.saturating_add(all);
        if first > source.length {
            let expected = format!("{all} bytes of chunk offsets from byte {}", header.tables);
            return Err(Error::invalid(&source.path, place, format!("{} bytes in all", source.length), expected));
        }
        source.seek(header.tables + before)?;
        // The full resolution comes before all other levels.
        let wanted = (layout.columns() * layout.bands()) as u64;
        let table = source.bytes(wanted * 8, &format!("{place}, chunk offsets"))?;
        let offsets = table.as_chunks::<8>().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
        static IDS: AtomicU64 = AtomicU64::new(1);
        let id = IDS.fetch_add(1, Ordering::Relaxed);
        let (path, length, multi_part) = (source.path.clone(), source.length, header.multi_part);
        Ok(Self { path, place, layout, part, multi_part, offsets, first, length, id })
    }

    /// Returns a description of the chunk for messages: its number and rows.
    pub(super) fn place(&self, at: Position) -> String {
        let rectangle = self.rectangle(at);
        let y0 = self.layout.window.y0;
        let rows = format!("rows {} to {}", y0 + rectangle.y0, y0 + rectangle.y1 - 1);
        format!("{}, chunk {} ({rows})", self.place, self.number(at))
    }

    /// Returns the window of the chunk, relative to the corner of the data window.
    pub(super) fn rectangle(&self, at: Position) -> Window {
        self.layout.rectangle(at.column, at.band)
    }

    /// Returns the compressed bytes of the chunk, at most `limit` of them, using `memory` as buffer.
    pub(super) fn read<'m>(
        &self,
        file: &dyn ReadAt,
        at: Position,
        limit: usize,
        memory: &'m mut Part,
    ) -> Result<&'m [u8], Error> {
        let offset = self.offsets[self.number(at)];
        if offset == 0 {
            let expected = "its place in the file; the writer was interrupted";
            return Err(self.invalid(at, "no chunk", expected));
        }
        if offset < self.first || offset >= self.length {
            let expected = format!("an offset from {} to {}", self.first, self.length);
            return Err(self.invalid(at, format!("the offset {offset}"), expected));
        }
        let mut wanted: Vec<i64> = Vec::new();
        if self.multi_part {
            wanted.push(self.part as i64);
        }
        if self.layout.tiled {
            wanted.extend([at.column as i64, at.band as i64, 0, 0]);
        } else {
            wanted.push(self.layout.window.y0 + self.rectangle(at).y0);
        }
        let head_size = 4 * (wanted.len() + 1);
        // If chunks follow each other, the head and the bytes are read at once.
        let next = self.offsets.get(self.number(at) + 1).and_then(|next| next.checked_sub(offset));
        let ahead = next.map_or(0, |next| next.min((head_size + limit) as u64) as usize).max(AHEAD);
        let mut fields = Fields(self.bytes(file, at, offset..offset + head_size as u64, ahead, memory)?);
        let found: Vec<i64> = wanted.iter().filter_map(|_| fields.i32()).map(i64::from).collect();
        if found != wanted {
            let expected = format!("coordinates {wanted:?}");
            return Err(self.invalid(at, format!("a chunk with coordinates {found:?}"), expected));
        }
        let size = fields.i32().unwrap_or_default();
        if size <= 0 || size as usize > limit {
            return Err(self.invalid(at, format!("a size of {size} bytes"), format!("1 to {limit} bytes")));
        }
        let start = offset + head_size as u64;
        self.bytes(file, at, start..start + size as u64, 0, memory)
    }

    /// Returns the bytes of this range. If they must be read, up to `ahead` bytes are read from its start on. Memory is
    /// taken only for bytes that exist.
    fn bytes<'m>(
        &self,
        file: &dyn ReadAt,
        at: Position,
        range: Range<u64>,
        ahead: usize,
        memory: &'m mut Part,
    ) -> Result<&'m [u8], Error> {
        let (count, rest) = ((range.end - range.start) as usize, self.length.saturating_sub(range.start));
        if rest < count as u64 {
            let found = format!("the end of the file after {rest} bytes");
            return Err(self.invalid(at, found, format!("{count} bytes")));
        }
        let held = memory.position..memory.position + memory.length as u64;
        if memory.file != self.id || range.start < held.start || range.end > held.end {
            memory.file = 0;
            memory.length = count.max(rest.min(ahead as u64) as usize);
            let lacking = |bytes| Error::OutOfMemory { path: self.path.clone(), place: self.place(at), bytes };
            grow(&mut memory.bytes, memory.length).map_err(lacking)?;
            let read = file.read_at(&mut memory.bytes[..memory.length], range.start);
            read.map_err(Error::io(&self.path, "read the file"))?;
            (memory.file, memory.position) = (self.id, range.start);
        }
        Ok(&memory.bytes[(range.start - memory.position) as usize..][..count])
    }

    fn invalid(&self, at: Position, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::invalid(&self.path, self.place(at), found, expected)
    }

    fn number(&self, at: Position) -> usize {
        at.band * self.layout.columns() + at.column
    }
}

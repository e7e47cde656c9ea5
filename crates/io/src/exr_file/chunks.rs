//! Finding and reading compressed chunks.

use std::io::{BufRead, Seek};

use trochoid_image::Window;

use super::attribute::Fields;
use super::header::{Detail, Header};
use crate::Error;
use crate::source::Source;

/// Where the chunks of one part's full resolution stand in the file.
pub(super) struct Chunks<'a> {
    detail: &'a Detail,
    /// For messages.
    place: String,
    part: usize,
    multi_part: bool,
    /// Row by row of chunks.
    offsets: Vec<u64>,
    /// Where the last table ends and chunks begin.
    first: u64,
}

/// One chunk of a part, at full resolution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub(super) column: usize,
    pub(super) band: usize,
}

impl<'a> Chunks<'a> {
    /// Reads the part's table of offsets.
    pub(super) fn find<R: BufRead + Seek>(
        source: &mut Source<R>,
        header: &'a Header,
        part: usize,
    ) -> Result<Self, Error> {
        let (detail, place) = (&header.details[part], header.parts[part].place(part));
        if let Some(stated) = detail.stated_chunks.filter(|&stated| stated != detail.layout.chunks) {
            let expected = format!("{} for its window and tiles", detail.layout.chunks);
            return Err(Error::invalid(&source.path, place, format!("a chunk count of {stated}"), expected));
        }
        // Tables follow each other, one for each part; parts of unknown kind can only be skipped by their own count.
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
        // The full resolution comes first, whatever other levels there are.
        let wanted = (detail.layout.columns() * detail.layout.bands()) as u64;
        let table = source.bytes(wanted * 8, &format!("{place}, chunk offsets"))?;
        let offsets = table.as_chunks::<8>().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
        Ok(Self { detail, place, part, multi_part: header.multi_part, offsets, first })
    }

    /// The chunk for messages: its number and rows.
    pub(super) fn place(&self, at: Position) -> String {
        let rectangle = self.rectangle(at);
        let y0 = self.detail.layout.window.y0;
        let rows = format!("rows {} to {}", y0 + rectangle.y0, y0 + rectangle.y1 - 1);
        format!("{}, chunk {} ({rows})", self.place, self.number(at))
    }

    /// Pixels of the chunk, counted from the data window's corner.
    pub(super) fn rectangle(&self, at: Position) -> Window {
        self.detail.layout.rectangle(at.column, at.band)
    }

    /// The chunk's compressed bytes; at most `limit` of them.
    pub(super) fn read<R: BufRead + Seek>(
        &self,
        source: &mut Source<R>,
        at: Position,
        limit: usize,
    ) -> Result<Vec<u8>, Error> {
        let offset = self.offsets[self.number(at)];
        if offset == 0 {
            let expected = "its place in the file; the writer was interrupted";
            return Err(Error::invalid(&source.path, self.place(at), "no chunk", expected));
        }
        if offset < self.first || offset >= source.length {
            let expected = format!("an offset from {} to {}", self.first, source.length);
            return Err(Error::invalid(&source.path, self.place(at), format!("the offset {offset}"), expected));
        }
        source.seek(offset)?;
        let layout = &self.detail.layout;
        let mut wanted: Vec<i64> = Vec::new();
        if self.multi_part {
            wanted.push(self.part as i64);
        }
        if layout.tiled {
            wanted.extend([at.column as i64, at.band as i64, 0, 0]);
        } else {
            wanted.push(layout.window.y0 + self.rectangle(at).y0);
        }
        let head = source.bytes(4 * (wanted.len() as u64 + 1), &self.place(at))?;
        let mut fields = Fields(&head);
        let found: Vec<i64> = wanted.iter().filter_map(|_| fields.i32()).map(i64::from).collect();
        if found != wanted {
            return Err(Error::invalid(
                &source.path,
                self.place(at),
                format!("a chunk with coordinates {found:?}"),
                format!("coordinates {wanted:?}"),
            ));
        }
        let size = fields.i32().unwrap_or_default();
        if size <= 0 || size as usize > limit {
            let expected = format!("1 to {limit} bytes");
            return Err(Error::invalid(&source.path, self.place(at), format!("a size of {size} bytes"), expected));
        }
        source.bytes(size as u64, &self.place(at))
    }

    fn number(&self, at: Position) -> usize {
        at.band * self.detail.layout.columns() + at.column
    }
}

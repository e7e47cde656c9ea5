//! TIFF and BigTIFF: strips and tiles, gray, color, palettes, CMYK and YCbCr, integers of any size and floats.
//!
//! This is implemented here and not by a library, so that only a row of chunks is decoded at a time, and errors name
//! what is not supported.

mod directory;
mod layout;
mod samples;
mod unpack;

use crate::limits::reserve;
use crate::raster::{Form, PLACE, TakeBytes, damaged};
use crate::source::SourceFile;
use crate::{Error, FileKind};
use layout::Layout;

/// Reads the tags.
pub(crate) fn form(source: &mut SourceFile) -> Result<Form, Error> {
    Ok(Layout::read(source)?.form)
}

/// Decodes all rows, a row of chunks at a time.
pub(crate) fn rows(source: &mut SourceFile, form: &Form, take: &mut TakeBytes<'_>) -> Result<(), Error> {
    let layout = Layout::read(source)?;
    let (height, high) = (form.height as usize, layout.chunk[1]);
    let row = form.row_bytes();
    let mut band: Vec<u8> = reserve(&source.path, PLACE, row * high.min(height))?;
    band.resize(row * high.min(height), 0);
    for y in (0..height).step_by(high) {
        let rows = high.min(height - y);
        for column in 0..layout.across() {
            let chunks = read_chunks(source, &layout, y, column)?;
            layout.place(&chunks, column, rows, &mut band);
        }
        for (index, row) in band.chunks_exact(row).take(rows).enumerate() {
            if take(y + index, row).is_break() {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Returns the raw samples of the chunk that starts at row `y`; if planes are separate, one chunk of each.
fn read_chunks(source: &mut SourceFile, layout: &Layout, y: usize, column: usize) -> Result<Vec<Vec<u8>>, Error> {
    let (height, high) = (layout.form.height as usize, layout.chunk[1]);
    // The last strip has only the remaining rows; tiles are always whole.
    let rows = if layout.tiled { high } else { high.min(height - y) };
    let plane = layout.across() * height.div_ceil(high);
    let first = y / high * layout.across() + column;
    let count = if layout.planar { layout.wanted } else { 1 };
    let mut chunks = Vec::new();
    for index in (0..count).map(|at| first + at * plane) {
        let size = layout.raw_size(rows);
        let (offset, mut length) = (layout.offsets[index], layout.lengths[index]);
        let place = || format!("{PLACE}, chunk {index} (row {y})");
        let rest = source.length.saturating_sub(offset);
        if layout.packing == layout::Packing::None {
            length = length.min(size as u64);
        }
        if length > rest {
            let found = format!("{length} bytes from byte {offset}");
            return Err(Error::invalid(&source.path, place(), found, format!("at most the {rest} that the file has")));
        }
        if !layout.can_hold(length, size) {
            let found = format!("{length} bytes");
            return Err(Error::invalid(&source.path, place(), found, format!("enough for {size} when decoded")));
        }
        source.seek(offset)?;
        let packed = source.bytes(length, &place())?;
        let raw = layout.unpack(packed, rows).map_err(|_| damaged(&source.path, FileKind::Tiff, y))?;
        chunks.push(raw);
    }
    Ok(chunks)
}

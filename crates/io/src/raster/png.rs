//! Reading of PNG row by row, by the `png` crate; interlaced files are decoded as a whole.

use std::fs::File;
use std::io::{BufReader, ErrorKind};
use std::ops::ControlFlow;
use std::path::Path;

use image::metadata::Orientation;
use png::{BitDepth, ColorType, Decoder, DecodingError, Reader, Transformations};

use super::form::{Form, PLACE, TakeBytes, bases, check_claim, damaged};
use crate::limits::reserve;
use crate::source::SourceFile;
use crate::{Encoding, Error, FileKind, SampleType};

/// Maximum number of bytes per byte of DEFLATE; each row has one byte in addition to its pixels.
const DEFLATE: u64 = 1032;
/// Memory for decoding in addition to rows, in bytes: the window of DEFLATE with its buffers, and ancillary chunks.
const WORKING: usize = 1 << 20;

fn open(source: &mut SourceFile) -> Result<Reader<&mut BufReader<File>>, Error> {
    let path = source.path.clone();
    // The rows that the crate holds are limited by the size that the file can inflate to.
    let room = usize::try_from(source.length.saturating_mul(DEFLATE)).unwrap_or(usize::MAX).saturating_add(WORKING);
    let mut decoder = Decoder::new_with_limits(&mut source.reader, png::Limits { bytes: room });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // Palettes and small samples are converted to bytes, transparent colors to alpha.
    decoder.set_transformations(Transformations::EXPAND);
    decoder.read_info().map_err(|error| failed(&path, 0, error))
}

fn failed(path: &Path, row: usize, error: DecodingError) -> Error {
    match error {
        DecodingError::IoError(error) if error.kind() != ErrorKind::UnexpectedEof => {
            Error::io(path, "read the file")(error)
        }
        DecodingError::IoError(_) => {
            let place = if row == 0 { PLACE.into() } else { format!("{PLACE}, row {row}") };
            Error::invalid(path, place, "the end of the file", "a whole PNG file")
        }
        _ => damaged(path, FileKind::Png, row),
    }
}

pub(super) fn form(source: &mut SourceFile) -> Result<Form, Error> {
    let length = source.length;
    let path = source.path.clone();
    let reader = open(source)?;
    let (color, depth) = reader.output_color_type();
    let info = reader.info();
    let bases = match color {
        ColorType::Grayscale => bases(false, false),
        ColorType::GrayscaleAlpha => bases(false, true),
        ColorType::Rgba => bases(true, true),
        ColorType::Rgb | ColorType::Indexed => bases(true, false),
    };
    let exif = info.exif_metadata.as_ref();
    let form = Form {
        width: info.width,
        height: info.height,
        sample_type: if depth == BitDepth::Sixteen { SampleType::U16 } else { SampleType::U8 },
        bases,
        // A damaged tag is ignored, as in viewers.
        orientation: exif.and_then(|chunk| Orientation::from_exif_chunk(chunk)).unwrap_or(Orientation::NoTransforms),
        encoding: Encoding::Srgb,
        rows: if info.interlaced { info.height } else { 4 },
        working: WORKING as u64,
    };
    // Eight samples of one bit become eight bytes, and four with alpha, twice that.
    check_claim(&path, &form, length, DEFLATE * 8 * 4)?;
    Ok(form)
}

pub(super) fn rows(source: &mut SourceFile, form: &Form, take: &mut TakeBytes<'_>) -> Result<(), Error> {
    let path = source.path.clone();
    let mut reader = open(source)?;
    let size = form.row_bytes();
    if reader.info().interlaced {
        let mut whole: Vec<u8> = reserve(&path, PLACE, size * form.height as usize)?;
        whole.resize(size * form.height as usize, 0);
        reader.next_frame(&mut whole).map_err(|error| failed(&path, 0, error))?;
        for (y, row) in whole.chunks_exact_mut(size).enumerate() {
            if take(y, native(row, form)).is_break() {
                break;
            }
        }
        return Ok(());
    }
    let mut row: Vec<u8> = reserve(&path, PLACE, size)?;
    row.resize(size, 0);
    for y in 0..form.height as usize {
        match reader.read_row(&mut row) {
            Ok(Some(_)) => {}
            Ok(None) => return Err(damaged(&path, FileKind::Png, y)),
            Err(error) => return Err(failed(&path, y, error)),
        }
        if take(y, native(&mut row, form)) == ControlFlow::Break(()) {
            return Ok(());
        }
    }
    // The data after the last row, including its checksum.
    reader.read_row(&mut row).map_err(|error| failed(&path, form.height as usize, error))?;
    Ok(())
}

/// Converts samples of 16 bits, which are stored with their high byte first.
fn native<'r>(row: &'r mut [u8], form: &Form) -> &'r [u8] {
    if form.sample_type == SampleType::U16 {
        row.as_chunks_mut().0.iter_mut().for_each(|sample| *sample = u16::from_be_bytes(*sample).to_ne_bytes());
    }
    row
}

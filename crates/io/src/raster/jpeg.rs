//! Reading of JPEG by the `image` crate, which decodes the whole picture to bytes.

use std::fs::File;
use std::io::{BufRead, BufReader};

use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::metadata::Orientation;

use super::form::{Form, PLACE, TakeBytes, bases, check_claim, damaged, unsupported};
use crate::limits::reserve;
use crate::source::SourceFile;
use crate::{Encoding, Error, FileKind, SampleType};

/// Maximum number of pixel bytes per byte of a file. At best, a bit is a block of 64 samples. An area of 32 × 32 pixels
/// has at least 9 blocks, if one component has 4 across, one 4 down, and one a single block: 3072 bytes in 9 bits.
pub(crate) const DENSEST: u64 = 4096;

/// Header of the frame: a marker of its kind, bits per sample, and the size of the picture.
struct Frame {
    mark: u8,
    bits: u8,
    width: u16,
    height: u16,
    components: u8,
}

/// Finds the header of the frame, and refuses a truncated JPEG, whose decoder would silently fill the rest with gray.
fn frame(source: &mut SourceFile) -> Result<Frame, Error> {
    source.seek(2)?;
    let path = source.path.clone();
    let broken = |found: &str| Error::invalid(&path, PLACE, found, "segments and an end-of-image marker");
    let mut frame = None;
    loop {
        // Segments before the pixels may hold a whole thumbnail, so they are skipped by their length.
        let head = source.bytes(4, PLACE)?;
        let [0xff, kind, high, low] = head[..] else { return Err(broken("no marker")) };
        if kind == 0xff {
            source.reader.seek_relative(-3).map_err(Error::io(&path, "read the file"))?;
            continue;
        }
        if kind == 0xda {
            break;
        }
        let mut skip = i64::from(u16::from_be_bytes([high, low])) - 2;
        if matches!(kind, 0xc0..=0xcf) && !matches!(kind, 0xc4 | 0xc8 | 0xcc) && skip >= 6 {
            let found = source.bytes(6, PLACE)?;
            let number = |at: usize| u16::from_be_bytes([found[at], found[at + 1]]);
            frame =
                Some(Frame { mark: kind, bits: found[0], height: number(1), width: number(3), components: found[5] });
            skip -= 6;
        }
        source.reader.seek_relative(skip.max(0)).map_err(Error::io(&path, "read the file"))?;
    }
    let mut last = 0;
    loop {
        let bytes = source.reader.fill_buf().map_err(Error::io(&path, "read the file"))?;
        let Some(&end) = bytes.last() else { return Err(broken("no end-of-image marker")) };
        if last == 0xff && bytes[0] == 0xd9 || bytes.windows(2).any(|pair| pair == [0xff, 0xd9]) {
            break;
        }
        last = end;
        let count = bytes.len();
        source.reader.consume(count);
    }
    frame.ok_or_else(|| broken("no frame"))
}

pub(super) fn form(source: &mut SourceFile) -> Result<Form, Error> {
    let found = frame(source)?;
    let path = &source.path;
    match found.mark {
        0xc3 | 0xc5..=0xc7 => return Err(unsupported(path, "a JPEG with lossless or hierarchical coding")),
        0xc9..=0xcf => return Err(unsupported(path, "a JPEG with arithmetic coding")),
        _ => {}
    }
    if found.bits != 8 {
        return Err(unsupported(path, format!("a JPEG with {} bits per sample", found.bits)));
    }
    let color = match found.components {
        1 => false,
        3 | 4 => true,
        other => return Err(unsupported(path, format!("a JPEG with {other} components"))),
    };
    let mut form = Form {
        width: found.width.into(),
        height: found.height.into(),
        sample_type: SampleType::U8,
        bases: bases(color, false),
        orientation: Orientation::NoTransforms,
        encoding: Encoding::Srgb,
        rows: u32::from(found.height),
        working: source.length,
    };
    check_claim(path, &form, source.length, DENSEST)?;
    if found.mark == 0xc2 {
        // Coefficients of 16 bits for all components, whose sizes are rounded up to whole blocks.
        form.working = form.working.saturating_add(
            2 * (u64::from(found.width) + 64) * (u64::from(found.height) + 64) * u64::from(found.components),
        );
    }
    source.seek(0)?;
    let mut decoder = decoder(source)?;
    form.orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok(form)
}

fn decoder(source: &mut SourceFile) -> Result<JpegDecoder<&mut BufReader<File>>, Error> {
    JpegDecoder::new(&mut source.reader).map_err(|_| damaged(&source.path, FileKind::Jpeg, 0))
}

pub(super) fn rows(source: &mut SourceFile, form: &Form, take: &mut TakeBytes<'_>) -> Result<(), Error> {
    let path = source.path.clone();
    let decoder = decoder(source)?;
    let size = form.row_bytes() * form.height as usize;
    if decoder.total_bytes() != size as u64 {
        return Err(damaged(&path, FileKind::Jpeg, 0));
    }
    let mut whole: Vec<u8> = reserve(&path, PLACE, size)?;
    whole.resize(size, 0);
    decoder.read_image(&mut whole).map_err(|_| damaged(&path, FileKind::Jpeg, 0))?;
    for (y, row) in whole.chunks_exact(form.row_bytes()).enumerate() {
        if take(y, row).is_break() {
            break;
        }
    }
    Ok(())
}

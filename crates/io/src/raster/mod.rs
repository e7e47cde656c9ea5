//! Reading of PNG, JPEG and TIFF row by row: only requested samples are converted to f32, and for most files only a few
//! rows are decoded at a time.

mod form;
mod jpeg;
mod png;
mod turn;

use std::ops::ControlFlow;

use image::metadata::Orientation;
use trochoid_image::Plane;

use crate::limits::reserve;
use crate::source::SourceFile;
use crate::{
    ChannelInfo, Compression, Error, FileKind, Limits, PartInfo, SampleType, Storage, names, png_file, tiff_file,
};
pub use form::TakeRow;
pub(crate) use form::{Form, PLACE, TakeBytes, bases, damaged, unsupported};
pub(crate) use jpeg::DENSEST as JPEG_DENSEST;
pub(crate) use turn::oriented;

/// Reads the header.
pub(crate) fn form(source: &mut SourceFile, kind: FileKind) -> Result<Form, Error> {
    source.seek(0)?;
    let form = match kind {
        FileKind::Jpeg => jpeg::form(source)?,
        FileKind::Tiff => tiff_file::form(source)?,
        FileKind::Png | FileKind::Exr => png::form(source)?,
    };
    if form.stored().is_empty() {
        return Err(Error::invalid(&source.path, PLACE, format!("the window {}", form.stored()), "at least one pixel"));
    }
    Ok(form)
}

/// Returns the description of a header for users.
pub(crate) fn info(source: &mut SourceFile, kind: FileKind) -> Result<(PartInfo, Form), Error> {
    let attributes = if kind == FileKind::Png { png_file::read_text(source)? } else { Vec::new() };
    let form = form(source, kind)?;
    let channels = form.bases.iter().map(|base| ChannelInfo {
        full_name: (*base).into(),
        layer: String::new(),
        base: String::new(),
        sample_type: form.sample_type,
        sampling: [1, 1],
    });
    let window = oriented(form.stored(), form.orientation);
    let mut part = PartInfo {
        name: None,
        display: window,
        data: window,
        compression: match kind {
            FileKind::Jpeg => Compression::Jpeg,
            FileKind::Tiff => Compression::Tiff,
            FileKind::Png | FileKind::Exr => Compression::Png,
        },
        storage: Storage::Scanline,
        layers: Vec::new(),
        channels: channels.collect(),
        attributes,
        chromaticities: None,
        encoding: form.encoding,
    };
    names::resolve(std::slice::from_mut(&mut part));
    Ok((part, form))
}

/// Decodes all rows and passes `channels` of each to the receiver, from the top down, until the receiver stops.
pub(crate) fn each_row(
    source: &mut SourceFile,
    kind: FileKind,
    form: &Form,
    channels: &[usize],
    limits: &Limits,
    take: &mut TakeRow<'_>,
) -> Result<(), Error> {
    limits.check_bytes(&source.path, PLACE, form.decoding())?;
    let upright = oriented(form.stored(), form.orientation);
    let mut lines: Vec<Vec<f32>> = Vec::new();
    for _ in channels {
        let mut line = reserve(&source.path, PLACE, upright.width())?;
        line.resize(upright.width(), 0.0);
        lines.push(line);
    }
    let mut hand_over = |y: usize, row: &[u8]| {
        for (line, channel) in lines.iter_mut().zip(channels) {
            spread(row, form, *channel, line);
        }
        take(y as i64, &lines)
    };
    if form.in_order() {
        let mut mirrored = Vec::new();
        return rows(source, kind, form, &mut |y, row| {
            if form.orientation == Orientation::NoTransforms {
                return hand_over(y, row);
            }
            mirrored.clear();
            row.rchunks_exact(form.pixel()).for_each(|pixel| mirrored.extend_from_slice(pixel));
            hand_over(y, &mirrored)
        });
    }
    // Rows of the upright picture are columns of the stored one, or are stored bottom to top.
    let mut whole: Vec<u8> = reserve(&source.path, PLACE, form.row_bytes() * form.height as usize)?;
    rows(source, kind, form, &mut |_, row| {
        whole.extend_from_slice(row);
        ControlFlow::Continue(())
    })?;
    let mut row = Vec::new();
    for y in 0..upright.height() {
        turn::row(&whole, form, y, &mut row);
        if hand_over(y, &row).is_break() {
            break;
        }
    }
    Ok(())
}

fn rows(source: &mut SourceFile, kind: FileKind, form: &Form, take: &mut TakeBytes<'_>) -> Result<(), Error> {
    source.seek(0)?;
    match kind {
        FileKind::Jpeg => jpeg::rows(source, form, take),
        FileKind::Tiff => tiff_file::rows(source, form, take),
        FileKind::Png | FileKind::Exr => png::rows(source, form, take),
    }
}

/// Converts one channel of a row of interleaved samples to f32.
fn spread(row: &[u8], form: &Form, channel: usize, line: &mut [f32]) {
    fn each<const N: usize>(row: &[u8], channel: usize, count: usize, line: &mut [f32], of: impl Fn([u8; N]) -> f32) {
        let samples = row.as_chunks::<N>().0.iter().skip(channel).step_by(count);
        line.iter_mut().zip(samples).for_each(|(out, sample)| *out = of(*sample));
    }
    let count = form.bases.len();
    match form.sample_type {
        SampleType::U8 => each(row, channel, count, line, |[v]| f32::from(v) / 255.0),
        SampleType::U16 => each(row, channel, count, line, |v| f32::from(u16::from_ne_bytes(v)) / 65535.0),
        SampleType::Half => each(row, channel, count, line, |v| half::f16::from_ne_bytes(v).to_f32()),
        SampleType::Float => each(row, channel, count, line, f32::from_ne_bytes),
        SampleType::Uint => each(row, channel, count, line, |v| u32::from_ne_bytes(v) as f32),
    }
}

/// Decodes `channels` of the picture, in that order.
pub(crate) fn read_planes(
    source: &mut SourceFile,
    kind: FileKind,
    info: &PartInfo,
    form: &Form,
    channels: &[usize],
    limits: &Limits,
) -> Result<Vec<Plane>, Error> {
    info.check_windows(&source.path, 0, limits)?;
    limits.check_planes(&source.path, PLACE, info.data, channels.len())?;
    let mut planes: Vec<Vec<f32>> = Vec::new();
    for _ in channels {
        planes.push(reserve(&source.path, PLACE, info.data.area())?);
    }
    each_row(source, kind, form, channels, limits, &mut |_, lines| {
        planes.iter_mut().zip(lines).for_each(|(plane, line)| plane.extend_from_slice(line));
        ControlFlow::Continue(())
    })?;
    let whole = |samples| {
        Plane::new(info.data, samples).map_err(|error| {
            Error::invalid(&source.path, PLACE, error.to_string(), "as many samples as the header says")
        })
    };
    planes.into_iter().map(whole).collect()
}

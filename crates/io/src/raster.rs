//! PNG, JPEG and TIFF through the `image` crate.

use std::io::{BufRead, ErrorKind, Read, Seek};

use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader};
use trochoid_image::{Plane, Window};

use crate::limits::reserve;
use crate::source::Source;
use crate::{
    ChannelInfo, Compression, Encoding, Error, FileKind, Limits, PartInfo, SampleType, Storage, names, png_file,
};

const PLACE: &str = "the picture";

/// Reads the header.
pub(crate) fn info<R: BufRead + Seek>(
    source: &mut Source<R>,
    kind: FileKind,
    limits: &Limits,
) -> Result<PartInfo, Error> {
    let attributes = if kind == FileKind::Png { png_file::read_text(source)? } else { Vec::new() };
    let (color, window) = with_decoder(source, kind, limits, |decoder, orientation| {
        let (width, height) = decoder.dimensions();
        Ok((decoder.color_type(), oriented(Window::sized(width, height), orientation)))
    })?;
    if window.is_empty() {
        return Err(Error::invalid(&source.path, PLACE, format!("the window {window}"), "at least one pixel"));
    }
    let (bases, sample_type) = layout(color).ok_or_else(|| Error::Unsupported {
        path: source.path.clone(),
        place: PLACE.into(),
        found: format!("{kind} with samples of type {color:?}"),
        remedy: "save it with 8 or 16 bits a channel, or as EXR",
    })?;
    let channels = bases.iter().map(|base| ChannelInfo {
        full_name: (*base).into(),
        layer: String::new(),
        base: String::new(),
        sample_type,
        sampling: [1, 1],
    });
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
        encoding: Encoding::Srgb,
    };
    names::resolve(std::slice::from_mut(&mut part));
    Ok(part)
}

/// Decodes `channels` of the picture, in that order.
pub(crate) fn read_planes<R: BufRead + Seek>(
    source: &mut Source<R>,
    kind: FileKind,
    info: &PartInfo,
    channels: &[usize],
    limits: &Limits,
) -> Result<Vec<Plane>, Error> {
    info.check_windows(&source.path, 0, limits)?;
    limits.check_planes(&source.path, PLACE, info.data, channels.len())?;
    if kind == FileKind::Jpeg {
        check_jpeg_end(source)?;
    }
    let path = source.path.clone();
    let (bytes, orientation, stored) = with_decoder(source, kind, limits, |decoder, orientation| {
        let (width, height) = decoder.dimensions();
        let size = decoder.total_bytes();
        limits.check_bytes(&path, PLACE, size)?;
        let mut bytes: Vec<u8> = reserve(&path, PLACE, size as usize)?;
        bytes.resize(size as usize, 0);
        decoder.read_image(&mut bytes).map_err(|error| failed(&path, kind, error))?;
        Ok((bytes, orientation, Window::sized(width, height)))
    })?;
    let count = info.channels.len();
    let mut planes = Vec::new();
    for &channel in channels {
        let mut samples: Vec<f32> = reserve(&path, PLACE, info.data.area())?;
        match info.channels[channel].sample_type {
            SampleType::U8 => {
                samples.extend(bytes.iter().skip(channel).step_by(count).map(|&v| f32::from(v) / 255.0));
            }
            _ => {
                let values = bytes.as_chunks::<2>().0.iter().skip(channel).step_by(count);
                samples.extend(values.map(|v| f32::from(u16::from_ne_bytes(*v)) / 65535.0));
            }
        }
        let upright = turn(samples, stored, orientation);
        let plane = Plane::new(info.data, upright);
        planes.push(
            plane.map_err(|error| {
                Error::invalid(&path, PLACE, error.to_string(), "as many samples as the header says")
            })?,
        );
    }
    Ok(planes)
}

/// Base names and type of the samples; `None` for floating point.
fn layout(color: ColorType) -> Option<(&'static [&'static str], SampleType)> {
    Some(match color {
        ColorType::L8 => (&["Y"], SampleType::U8),
        ColorType::La8 => (&["Y", "A"], SampleType::U8),
        ColorType::Rgb8 => (&["R", "G", "B"], SampleType::U8),
        ColorType::Rgba8 => (&["R", "G", "B", "A"], SampleType::U8),
        ColorType::L16 => (&["Y"], SampleType::U16),
        ColorType::La16 => (&["Y", "A"], SampleType::U16),
        ColorType::Rgb16 => (&["R", "G", "B"], SampleType::U16),
        ColorType::Rgba16 => (&["R", "G", "B", "A"], SampleType::U16),
        _ => return None,
    })
}

fn with_decoder<R: BufRead + Seek, T>(
    source: &mut Source<R>,
    kind: FileKind,
    limits: &Limits,
    act: impl FnOnce(Box<dyn ImageDecoder + '_>, Orientation) -> Result<T, Error>,
) -> Result<T, Error> {
    source.seek(0)?;
    // The decoder of JPEG holds the whole file in memory.
    limits.check_bytes(&source.path, "the file", if kind == FileKind::Jpeg { source.length } else { 0 })?;
    let format = match kind {
        FileKind::Jpeg => ImageFormat::Jpeg,
        FileKind::Tiff => ImageFormat::Tiff,
        FileKind::Png | FileKind::Exr => ImageFormat::Png,
    };
    let mut reader = ImageReader::with_format(&mut source.reader, format);
    let mut bounds = image::Limits::no_limits();
    bounds.max_alloc = Some(limits.bytes);
    reader.limits(bounds);
    let mut decoder = reader.into_decoder().map_err(|error| failed(&source.path, kind, error))?;
    // A damaged tag says nothing; viewers show such a picture as it is.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    act(Box::new(decoder), orientation)
}

fn failed(path: &std::path::Path, kind: FileKind, error: ImageError) -> Error {
    match error {
        ImageError::IoError(error) if error.kind() != ErrorKind::UnexpectedEof => {
            Error::io(path, "read the file")(error)
        }
        ImageError::Unsupported(error) => Error::Unsupported {
            path: path.into(),
            place: PLACE.into(),
            found: format!("this kind of {kind} ({error})"),
            remedy: "save it as PNG with 8 or 16 bits a channel, or as EXR",
        },
        ImageError::Limits(error) => Error::Unsupported {
            path: path.into(),
            place: PLACE.into(),
            found: format!("a {kind} of this size ({error})"),
            remedy: "scale the picture or raise the limit",
        },
        error => Error::invalid(path, PLACE, error.to_string(), format!("a whole {kind} file")),
    }
}

/// Refuses a JPEG that stops short: its decoder would fill the rest with gray and say nothing.
fn check_jpeg_end<R: BufRead + Seek>(source: &mut Source<R>) -> Result<(), Error> {
    source.seek(2)?;
    let path = source.path.clone();
    let broken = |found: &str| Error::invalid(&path, PLACE, found, "segments and an end-of-image marker");
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
        let skip = i64::from(u16::from_be_bytes([high, low])) - 2;
        source.reader.seek_relative(skip.max(0)).map_err(Error::io(&path, "read the file"))?;
    }
    let mut rest = Vec::new();
    (&mut source.reader).take(source.length).read_to_end(&mut rest).map_err(Error::io(&path, "read the file"))?;
    let end = rest.as_slice().windows(2).any(|pair| pair == [0xff, 0xd9]);
    if end { Ok(()) } else { Err(broken("no end-of-image marker")) }
}

/// The window of the upright picture.
fn oriented(stored: Window, orientation: Orientation) -> Window {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    match orientation {
        Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH => Window::new(0, 0, stored.y1, stored.x1),
        _ => stored,
    }
}

/// Turns and mirrors samples over `stored` as the orientation tag says.
fn turn(samples: Vec<f32>, stored: Window, orientation: Orientation) -> Vec<f32> {
    if orientation == Orientation::NoTransforms || samples.len() != stored.area() {
        return samples;
    }
    let (w, h) = (stored.width(), stored.height());
    let width = oriented(stored, orientation).width();
    let mut upright = vec![0.0; samples.len()];
    for (y, row) in samples.chunks_exact(w).enumerate() {
        for (x, &value) in row.iter().enumerate() {
            let (column, line) = match orientation {
                Orientation::NoTransforms => (x, y),
                Orientation::FlipHorizontal => (w - 1 - x, y),
                Orientation::Rotate180 => (w - 1 - x, h - 1 - y),
                Orientation::FlipVertical => (x, h - 1 - y),
                Orientation::Rotate90FlipH => (y, x),
                Orientation::Rotate90 => (h - 1 - y, x),
                Orientation::Rotate270FlipH => (h - 1 - y, w - 1 - x),
                Orientation::Rotate270 => (y, w - 1 - x),
            };
            upright[line * width + column] = value;
        }
    }
    upright
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_agrees_with_the_image_crate() {
        let (w, h) = (3, 2);
        let samples: Vec<f32> = (0..6).map(|v| v as f32).collect();
        for tag in 1..=8 {
            let orientation = Orientation::from_exif(tag).expect("a legal tag");
            let buffer = image::GrayImage::from_raw(w, h, (0..6).collect()).expect("six pixels");
            let mut image = image::DynamicImage::ImageLuma8(buffer);
            image.apply_orientation(orientation);
            let upright = turn(samples.clone(), Window::sized(w, h), orientation);
            let expected: Vec<f32> = image.as_bytes().iter().map(|&v| f32::from(v)).collect();
            assert_eq!(upright, expected, "{orientation:?}");
            assert_eq!(oriented(Window::sized(w, h), orientation), Window::sized(image.width(), image.height()));
        }
    }
}
